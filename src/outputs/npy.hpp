// SPDX-License-Identifier: Apache-2.0
// NumPy's .npy files, version 1.0: arrays that every tool of the field reads.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/matrix_view.hpp"

namespace choreo::outputs {

/// The header of a little-endian C-order array, padded to a multiple of 64 bytes and to at least `least_bytes`.
/// @param dtype  as NumPy writes it: "<f4", "<f8", "|u1".
[[nodiscard]] std::string npy_header(const std::string& dtype, std::span<const std::size_t> shape,
                                     std::size_t least_bytes = 128);

/// Writes a vector of float64. @throws Error (failure)
void write_npy(const std::filesystem::path& path, std::span<const double> values);

/// A float32 matrix that lives in its file: as large as the disk, not the memory.
///
/// All its disk space is taken at the start, so that a full disk is an error here and not a crash later.
class NpyMatrix {
 public:
  /// @throws Error (failure) where the disk has not the room.
  NpyMatrix(const std::filesystem::path& path, std::size_t rows, std::size_t cols);
  ~NpyMatrix();
  NpyMatrix(const NpyMatrix&) = delete;
  NpyMatrix& operator=(const NpyMatrix&) = delete;

  [[nodiscard]] MatrixView<float> view() const { return {data_, rows_, cols_}; }

 private:
  std::size_t rows_;
  std::size_t cols_;
  void* map_ = nullptr;
  std::size_t bytes_ = 0;
  float* data_ = nullptr;
};

/// Pictures one after the other, N x H x W of uint8, N known only at the end.
class NpyPictures {
 public:
  NpyPictures(const std::filesystem::path& path, cv::Size size);

  /// @param picture  CV_8UC1 of that size; what is not 0 is written as 1. @throws Error (failure)
  void add(const cv::Mat& picture);

  /// Completes the file. @throws Error (failure)
  void close();

 private:
  [[noreturn]] void refuse() const;

  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_;
  cv::Size size_;
  std::size_t count_ = 0;
  std::vector<std::uint8_t> line_;
  std::unique_ptr<std::FILE, Closer> file_;
};

}  // namespace choreo::outputs

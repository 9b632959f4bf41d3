// SPDX-License-Identifier: Apache-2.0
// NumPy's .npy files, version 1.0: arrays that every tool of the field reads.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
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

/// A float32 matrix that is written band by band: as large as the disk, not the memory.
///
/// All its disk space is taken at the start, so that a full disk is an error before the work and not after it. What is
/// not written is 0.
class NpyMatrix {
 public:
  /// @throws Error (failure) where the disk has not the room.
  NpyMatrix(const std::filesystem::path& path, std::size_t rows, std::size_t cols);
  ~NpyMatrix();
  NpyMatrix(const NpyMatrix&) = delete;
  NpyMatrix& operator=(const NpyMatrix&) = delete;

  /// Writes rows first_row, first_row + 1, ... of a symmetric matrix up to the band's last row's own column, and by
  /// symmetry the same numbers above the diagonal.
  /// @param band  B x (first_row + B). @throws Error (failure)
  void write_symmetric(std::size_t first_row, MatrixView<const float> band);

 private:
  void write_at(std::size_t row, std::size_t col, std::span<const float> values);

  std::string path_;
  std::size_t rows_;
  std::size_t cols_;
  std::size_t header_bytes_ = 0;
  int file_ = -1;
};

/// Pictures one after the other, N x H x W of uint8, N known only at the end.
class NpyPictures {
 public:
  NpyPictures(const std::filesystem::path& path, cv::Size size);
  ~NpyPictures();
  NpyPictures(const NpyPictures&) = delete;
  NpyPictures& operator=(const NpyPictures&) = delete;

  /// @param picture  CV_8UC1 of that size; what is not 0 is written as 1. @throws Error (failure)
  void add(const cv::Mat& picture);

  /// Keeps pictures 0, 2, 4, ... of those added so far. @throws Error (failure)
  void keep_every_second();

  /// Completes the file. @throws Error (failure)
  void close();

 private:
  [[nodiscard]] off_t place_of(std::size_t picture) const;
  void write_header();

  std::string path_;
  cv::Size size_;
  std::size_t header_bytes_ = 0;
  std::size_t count_ = 0;
  std::vector<std::uint8_t> picture_;
  int file_ = -1;
};

}  // namespace choreo::outputs

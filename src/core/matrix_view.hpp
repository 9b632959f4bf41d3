// SPDX-License-Identifier: Apache-2.0
// A rectangular window onto row-major numbers that somebody else owns.
#pragma once

#include <cassert>
#include <cstddef>
#include <span>

namespace choreo {

/// Rows x columns of T, row-major, `stride` elements from one row to the next. Does not own: the data must outlive it.
template <typename T>
class MatrixView {
 public:
  MatrixView() = default;
  MatrixView(T* data, std::size_t rows, std::size_t cols) : MatrixView(data, rows, cols, cols) {}
  MatrixView(T* data, std::size_t rows, std::size_t cols, std::size_t stride)
      : data_(data), rows_(rows), cols_(cols), stride_(stride) {
    assert(stride >= cols);
  }
  /// A view of const elements onto the same data.
  operator MatrixView<const T>() const { return {data_, rows_, cols_, stride_}; }

  [[nodiscard]] std::size_t rows() const { return rows_; }
  [[nodiscard]] std::size_t cols() const { return cols_; }
  [[nodiscard]] std::size_t stride() const { return stride_; }
  [[nodiscard]] T* data() const { return data_; }
  [[nodiscard]] T& operator()(std::size_t row, std::size_t col) const {
    assert(row < rows_ && col < cols_);
    return data_[row * stride_ + col];
  }
  [[nodiscard]] std::span<T> row(std::size_t row) const {
    assert(row < rows_);
    return {data_ + row * stride_, cols_};
  }

 private:
  T* data_ = nullptr;
  std::size_t rows_ = 0;
  std::size_t cols_ = 0;
  std::size_t stride_ = 0;
};

}  // namespace choreo

// SPDX-License-Identifier: Apache-2.0
#include "outputs/npy.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/error.hpp"
#include "outputs/output_set.hpp"

namespace choreo::outputs {
namespace {

static_assert(std::endian::native == std::endian::little, "the files written here are little-endian");

[[noreturn]] void refuse_file(const std::string& path, int code) {
  throw failure(fmt::format("\"{}\" cannot be written: {}", final_name(path), std::generic_category().message(code)));
}

// Writes all of it at a place of a file. @return 0, or the error's number.
int write_whole(int file, const void* data, std::size_t bytes, off_t offset) {
  const auto* from = static_cast<const char*>(data);
  while (bytes > 0) {
    const auto written = ::pwrite(file, from, bytes, offset);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return written < 0 ? errno : ENOSPC;
    from += written;
    offset += written;
    bytes -= std::size_t(written);
  }
  return 0;
}

// Reads all of it from a place of a file. @return 0, or the error's number.
int read_whole(int file, void* data, std::size_t bytes, off_t offset) {
  auto* to = static_cast<char*>(data);
  while (bytes > 0) {
    const auto got = ::pread(file, to, bytes, offset);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return got < 0 ? errno : EIO;
    to += got;
    offset += got;
    bytes -= std::size_t(got);
  }
  return 0;
}

}  // namespace

std::string npy_header(const std::string& dtype, std::span<const std::size_t> shape, std::size_t least_bytes) {
  // One dimension needs its comma to be a Python tuple.
  const auto dict = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}{}), }}", dtype,
                                fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
  constexpr std::size_t kPrefix = 10;
  const auto bytes = std::max(least_bytes, (kPrefix + dict.size() + 1 + 63) / 64 * 64);
  std::string header("\x93NUMPY\x01\x00", 8);
  const auto length = bytes - kPrefix;
  header += static_cast<char>(length & 0xff);
  header += static_cast<char>(length >> 8);
  header += dict;
  header.append(bytes - header.size() - 1, ' ');
  header += '\n';
  return header;
}

void write_npy(const std::filesystem::path& path, std::span<const double> values) {
  const std::size_t shape[] = {values.size()};
  auto bytes = npy_header("<f8", shape);
  const auto raw = std::as_bytes(values);
  bytes.append(reinterpret_cast<const char*>(raw.data()), raw.size());
  write_file(path, bytes);
}

NpyMatrix::NpyMatrix(const std::filesystem::path& path, std::size_t rows, std::size_t cols)
    : path_(path.string()), rows_(rows), cols_(cols) {
  const std::size_t shape[] = {rows, cols};
  const auto header = npy_header("<f4", shape);
  constexpr auto kMostBytes = std::size_t(std::numeric_limits<off_t>::max()) - 4096;
  if (cols > 0 && rows > kMostBytes / sizeof(float) / cols) {
    throw failure(fmt::format("\"{}\" cannot hold {} x {} numbers", path_, rows, cols));
  }
  header_bytes_ = header.size();
  const auto bytes = header.size() + rows * cols * sizeof(float);
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0) refuse_file(path_, errno);
  if (const int code = ::posix_fallocate(file_, 0, static_cast<off_t>(bytes)); code != 0) {
    ::close(file_);
    throw failure(fmt::format("\"{}\" needs {:.1f} MB: {}", final_name(path), double(bytes) / 1e6,
                              std::generic_category().message(code)),
                  {}, "a matrix of N frames takes 4 N^2 bytes; take fewer frames with --every or --span");
  }
  if (const int code = write_whole(file_, header.data(), header.size(), 0); code != 0) {
    ::close(file_);
    refuse_file(path_, code);
  }
}

NpyMatrix::~NpyMatrix() { ::close(file_); }

void NpyMatrix::write_at(std::size_t row, std::size_t col, std::span<const float> values) {
  const auto offset = header_bytes_ + (row * cols_ + col) * sizeof(float);
  const int code = write_whole(file_, values.data(), values.size_bytes(), static_cast<off_t>(offset));
  if (code != 0) refuse_file(path_, code);
}

void NpyMatrix::write_symmetric(std::size_t first_row, MatrixView<const float> band) {
  assert(rows_ == cols_ && band.cols() == first_row + band.rows() && band.cols() <= cols_);
  for (std::size_t i = 0; i < band.rows(); ++i) write_at(first_row + i, 0, band.row(i));
  // A block of columns at a time: each line of the band is then read by whole cache lines.
  constexpr std::size_t kBlock = 16;
  std::vector<float> turned(kBlock * band.rows());
  for (std::size_t begin = 0; begin < first_row; begin += kBlock) {
    const auto size = std::min(kBlock, first_row - begin);
    for (std::size_t i = 0; i < band.rows(); ++i) {
      for (std::size_t j = 0; j < size; ++j) turned[j * band.rows() + i] = band(i, begin + j);
    }
    for (std::size_t j = 0; j < size; ++j) {
      write_at(begin + j, first_row, {turned.data() + j * band.rows(), band.rows()});
    }
  }
}

NpyPictures::NpyPictures(const std::filesystem::path& path, cv::Size size)
    : path_(path.string()), size_(size), picture_(std::size_t(size.area())) {
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0) refuse_file(path_, errno);
  try {
    write_header();  // Its place is kept; the number of pictures comes at the end.
  } catch (...) {
    ::close(file_);
    throw;
  }
}

NpyPictures::~NpyPictures() {
  if (file_ >= 0) ::close(file_);
}

off_t NpyPictures::place_of(std::size_t picture) const {
  return static_cast<off_t>(header_bytes_ + picture * picture_.size());
}

void NpyPictures::write_header() {
  const std::size_t shape[] = {count_, std::size_t(size_.height), std::size_t(size_.width)};
  const auto header = npy_header("|u1", shape);
  assert(header_bytes_ == 0 || header_bytes_ == header.size());
  header_bytes_ = header.size();
  if (const int code = write_whole(file_, header.data(), header.size(), 0); code != 0) refuse_file(path_, code);
}

void NpyPictures::add(const cv::Mat& picture) {
  assert(picture.type() == CV_8UC1 && picture.size() == size_);
  auto out = picture_.begin();
  for (int y = 0; y < picture.rows; ++y) {
    const auto* in = picture.ptr<std::uint8_t>(y);
    out = std::transform(in, in + picture.cols, out, [](std::uint8_t v) { return v != 0 ? 1 : 0; });
  }
  if (const int code = write_whole(file_, picture_.data(), picture_.size(), place_of(count_)); code != 0) {
    refuse_file(path_, code);
  }
  ++count_;
}

void NpyPictures::keep_every_second() {
  const auto kept = (count_ + 1) / 2;
  for (std::size_t k = 1; k < kept; ++k) {
    if (const int code = read_whole(file_, picture_.data(), picture_.size(), place_of(2 * k)); code != 0) {
      refuse_file(path_, code);
    }
    if (const int code = write_whole(file_, picture_.data(), picture_.size(), place_of(k)); code != 0) {
      refuse_file(path_, code);
    }
  }
  count_ = kept;
  if (::ftruncate(file_, place_of(count_)) != 0) refuse_file(path_, errno);
}

void NpyPictures::close() {
  write_header();
  if (::close(std::exchange(file_, -1)) != 0) refuse_file(path_, errno);
}

}  // namespace choreo::outputs

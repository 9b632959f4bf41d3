// SPDX-License-Identifier: Apache-2.0
#include "outputs/npy.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <limits>
#include <system_error>

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

NpyMatrix::NpyMatrix(const std::filesystem::path& path, std::size_t rows, std::size_t cols) : rows_(rows), cols_(cols) {
  const std::size_t shape[] = {rows, cols};
  const auto header = npy_header("<f4", shape);
  constexpr auto kMostBytes = std::size_t(std::numeric_limits<off_t>::max()) - 4096;
  if (cols > 0 && rows > kMostBytes / sizeof(float) / cols) {
    throw failure(fmt::format("\"{}\" cannot hold {} x {} numbers", path.string(), rows, cols));
  }
  bytes_ = header.size() + rows * cols * sizeof(float);
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) refuse_file(path.string(), errno);
  // Writing into a hole of a mapped file on a full disk would be a SIGBUS.
  const int code = ::posix_fallocate(file, 0, static_cast<off_t>(bytes_));
  if (code != 0) {
    ::close(file);
    throw failure(fmt::format("\"{}\" needs {:.1f} MB: {}", final_name(path), double(bytes_) / 1e6,
                              std::generic_category().message(code)),
                  {}, "a matrix of N frames takes 4 N^2 bytes; take fewer frames with --every or --span");
  }
  map_ = ::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  const int map_code = errno;
  ::close(file);
  if (map_ == MAP_FAILED) {
    map_ = nullptr;
    refuse_file(path.string(), map_code);
  }
  std::memcpy(map_, header.data(), header.size());
  data_ = reinterpret_cast<float*>(static_cast<char*>(map_) + header.size());
}

NpyMatrix::~NpyMatrix() {
  if (map_ != nullptr) ::munmap(map_, bytes_);
}

NpyPictures::NpyPictures(const std::filesystem::path& path, cv::Size size)
    : path_(path.string()), size_(size), line_(std::size_t(size.width)), file_(std::fopen(path_.c_str(), "wb")) {
  if (!file_) refuse();
  // Its place is kept; the number of pictures comes at the end.
  const std::size_t shape[] = {0, std::size_t(size.height), std::size_t(size.width)};
  const auto header = npy_header("|u1", shape);
  if (std::fwrite(header.data(), 1, header.size(), file_.get()) != header.size()) refuse();
}

void NpyPictures::add(const cv::Mat& picture) {
  assert(picture.type() == CV_8UC1 && picture.size() == size_);
  for (int y = 0; y < picture.rows; ++y) {
    const auto* in = picture.ptr<std::uint8_t>(y);
    std::transform(in, in + picture.cols, line_.begin(), [](std::uint8_t v) { return v != 0 ? 1 : 0; });
    if (std::fwrite(line_.data(), 1, line_.size(), file_.get()) != line_.size()) refuse();
  }
  ++count_;
}

void NpyPictures::close() {
  const std::size_t shape[] = {count_, std::size_t(size_.height), std::size_t(size_.width)};
  const auto header = npy_header("|u1", shape);
  auto* file = file_.get();
  if (std::fseek(file, 0, SEEK_SET) != 0 || std::fwrite(header.data(), 1, header.size(), file) != header.size() ||
      std::fflush(file) != 0) {
    refuse();
  }
  if (std::fclose(file_.release()) != 0) refuse();
}

void NpyPictures::refuse() const { refuse_file(path_, errno); }

}  // namespace choreo::outputs

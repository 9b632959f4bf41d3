// SPDX-License-Identifier: Apache-2.0
#include "outputs/kinect_dump_writer.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "devices/media/kinect_depth.hpp"

namespace choreo::outputs {
namespace {

constexpr Nanoseconds kEnd = std::chrono::seconds(4'000'000'000);

// @return 0, or the error's number.
int append(int file, const void* data, std::size_t bytes) {
  const auto* from = static_cast<const char*>(data);
  while (bytes > 0) {
    const auto written = ::write(file, from, bytes);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return written < 0 ? errno : ENOSPC;
    from += written;
    bytes -= static_cast<std::size_t>(written);
  }
  return 0;
}

int write_file(const std::filesystem::path& path, std::string_view header, std::span<const std::uint8_t> pixels) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file < 0) return errno;
  int code = append(file, header.data(), header.size());
  if (code == 0) code = append(file, pixels.data(), pixels.size());
  if (::close(file) != 0 && code == 0) code = errno;
  if (code != 0) ::unlink(path.c_str());
  return code;
}

[[noreturn]] void refuse(const std::filesystem::path& path, int code) {
  throw failure(fmt::format("\"{}\" cannot be written: {}", path.string(), std::generic_category().message(code)));
}

void check(const cv::Mat& picture, int type, std::string_view what) {
  if (picture.size() == devices::kKinectSize && picture.type() == type) return;
  throw failure(fmt::format("a {} picture of {}x{} does not go into a Kinect's dump", what, picture.cols, picture.rows),
                {}, "its pictures are 640x480");
}

}  // namespace

KinectDumpWriter::KinectDumpWriter(const std::filesystem::path& folder)
    : folder_(folder), colour_{'r', "ppm", "P6 640 480 255\n"}, depth_{'d', "pgm", "P5 640 480 65535\n"} {
  std::error_code problem;
  std::filesystem::create_directories(folder_, problem);
  if (!problem && !std::filesystem::is_empty(folder_, problem) && !problem) {
    throw usage_error(fmt::format("folder \"{}\" is not empty", folder_.string()), {},
                      "a dump needs a folder of its own");
  }
  if (!problem) {
    index_ = ::open((folder_ / "INDEX.txt").c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0666);
    if (index_ < 0) problem = std::error_code(errno, std::generic_category());
  }
  if (problem) {
    throw usage_error(fmt::format("\"{}\" cannot be written to: {}", folder_.string(), problem.message()));
  }
}

KinectDumpWriter::~KinectDumpWriter() { ::close(index_); }

void KinectDumpWriter::write_colour(const cv::Mat& bgr, Nanoseconds time) {
  check(bgr, CV_8UC3, "colour");
  cv::Mat rgb;
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  write(colour_, {rgb.data, rgb.total() * rgb.elemSize()}, time);
}

void KinectDumpWriter::write_depth(const cv::Mat& depth_mm, Nanoseconds time) {
  check(depth_mm, CV_16UC1, "depth");
  std::vector<std::uint8_t> words;
  words.reserve(depth_mm.total() * 2);
  for (int y = 0; y < depth_mm.rows; ++y) {
    const auto* line = depth_mm.ptr<std::uint16_t>(y);
    for (int x = 0; x < depth_mm.cols; ++x) {
      const auto word = devices::kinect_word(line[x]);
      words.push_back(static_cast<std::uint8_t>(word & 0xff));
      words.push_back(static_cast<std::uint8_t>(word >> 8));
    }
  }
  write(depth_, words, time);
}

void KinectDumpWriter::write_words(std::span<const std::uint8_t> words, Nanoseconds time) {
  if (words.size() != 2 * static_cast<std::size_t>(devices::kKinectSize.area())) {
    throw failure(fmt::format("a depth picture of {} bytes does not go into a Kinect's dump", words.size()), {},
                  "it has 640x480 words of 16 bits");
  }
  write(depth_, words, time);
}

void KinectDumpWriter::write(Stream& stream, std::span<const std::uint8_t> pixels, Nanoseconds time) {
  if (time < Nanoseconds{0} || time >= kEnd || (stream.last && time <= *stream.last)) {
    throw failure(fmt::format("a picture of {:.9f} s does not go into a dump", to_seconds(time)), folder_.string(),
                  "times increase, from 0 to 4e9 s");
  }
  const auto ns = time.count();
  const auto ticks = static_cast<std::uint32_t>(ns / 50 * 3 + ns % 50 * 3 / 50);
  const auto name =
      fmt::format("{}-{}.{:09}-{}.{}", stream.kind, ns / 1'000'000'000, ns % 1'000'000'000, ticks, stream.extension);
  if (const int code = write_file(folder_ / name, stream.header, pixels); code != 0) refuse(folder_ / name, code);
  const auto line = name + "\n";
  if (const int code = append(index_, line.data(), line.size()); code != 0) refuse(folder_ / "INDEX.txt", code);
  stream.last = time;
}

}  // namespace choreo::outputs

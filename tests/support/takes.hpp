// SPDX-License-Identifier: Apache-2.0
// Frames as devices give them, and takes of them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "devices/fourcc.hpp"
#include "devices/media/raw_converter.hpp"
#include "devices/take/take_driver.hpp"
#include "outputs/take_writer.hpp"
#include "support/frames.hpp"

namespace choreo::test {

inline devices::RawPicturePtr noise_picture(std::uint32_t fourcc, cv::Size size, std::uint64_t seed) {
  auto raw = std::make_shared<devices::RawPicture>();
  raw->fourcc = fourcc;
  raw->size = size;
  const auto bytes = noise({int(devices::bytes_of(devices::dense_layout(fourcc, size))), 1}, CV_8UC1, seed);
  raw->bytes.assign(bytes.begin<std::uint8_t>(), bytes.end<std::uint8_t>());
  return raw;
}

/// A frame whose picture is made of `raw`, as a driver makes it.
inline std::shared_ptr<devices::Frame> raw_frame(std::uint64_t sequence, Nanoseconds time, devices::RawPicturePtr raw) {
  auto frame = std::make_shared<devices::Frame>();
  frame->sequence = sequence;
  frame->device_time = time;
  frame->bgr = devices::RawConverter().to_bgr(*raw);
  frame->raw_colour = std::move(raw);
  return frame;
}

/// A frame of noise without raw pictures. @param depth  whether it has depth.
inline std::shared_ptr<devices::Frame> plain_frame(std::uint64_t sequence, Nanoseconds time, cv::Size size,
                                                   bool depth = false) {
  auto frame = std::make_shared<devices::Frame>();
  frame->sequence = sequence;
  frame->device_time = time;
  frame->bgr = noise(size, CV_8UC3, sequence + 1);
  if (depth) {
    frame->depth.create(size, CV_16UC1);
    cv::RNG random(sequence + 7);
    random.fill(frame->depth, cv::RNG::UNIFORM, 0, 65536);
  }
  return frame;
}

inline std::vector<devices::FramePtr> plain_frames(int count, cv::Size size, bool depth = false) {
  std::vector<devices::FramePtr> frames;
  for (int i = 0; i < count; ++i) {
    frames.push_back(plain_frame(std::uint64_t(i), i * Nanoseconds(33'333'333), size, depth));
  }
  return frames;
}

inline devices::SourceInfo info_of(const devices::Frame& frame) {
  devices::SourceInfo info;
  info.name = "fake://device?gain=3";
  info.size = frame.bgr.size();
  info.nominal_fps = 30;
  return info;
}

/// Options with which nothing is left out.
inline outputs::TakeOptions whole_take() {
  outputs::TakeOptions options;
  options.full = outputs::FullQueue::kWait;
  return options;
}

inline outputs::TakeReport write_take(const std::string& path, const std::vector<devices::FramePtr>& frames,
                                      const outputs::TakeOptions& options, const devices::SourceInfo& info) {
  outputs::TakeWriter writer(path, info, options);
  for (const auto& frame : frames) writer.add(frame);
  return writer.close();
}

inline outputs::TakeReport write_take(const std::string& path, const std::vector<devices::FramePtr>& frames,
                                      const outputs::TakeOptions& options = whole_take()) {
  return write_take(path, frames, options, info_of(*frames.front()));
}

/// @param source  a path, perhaps with settings.
inline std::unique_ptr<devices::Source> open_take(const std::string& source, bool keep_raw = false) {
  devices::Registry registry;
  registry.add(devices::take_driver());
  devices::OpenOptions options;
  options.keep_raw = keep_raw;
  return registry.open(source, options);
}

inline bool same_raw(const devices::RawPicturePtr& a, const devices::RawPicturePtr& b) {
  if (!a || !b) return a == b;
  return a->fourcc == b->fourcc && a->size == b->size && a->bytes == b->bytes;
}

/// Whether every byte, number and time is the same.
inline bool same_frame(const devices::Frame& a, const devices::Frame& b) {
  return a.sequence == b.sequence && a.device_time == b.device_time && same_pixels(a.bgr, b.bgr) &&
         (a.depth.empty() ? b.depth.empty() : same_pixels(a.depth, b.depth)) && same_raw(a.raw_colour, b.raw_colour) &&
         same_raw(a.raw_depth, b.raw_depth);
}

}  // namespace choreo::test

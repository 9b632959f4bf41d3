// SPDX-License-Identifier: Apache-2.0
// A source of made-up frames, a clock that only moves when told to, and a stage made of a function.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "core/time.hpp"
#include "devices/source.hpp"
#include "pipeline/stage.hpp"

namespace choreo::test {

/// Time as the test has it. @thread thread-safe
class SimulatedClock final : public Clock {
 public:
  [[nodiscard]] Nanoseconds now() const override {
    const Nanoseconds time(now_.load());
    if (on_now) on_now();
    return time;
  }
  void advance(Nanoseconds by) { now_ += by.count(); }

  std::function<void()> on_now;  ///< Called after each reading of the time.

 private:
  std::atomic<Nanoseconds::rep> now_{0};
};

/// Time that passes only in the thread whose work it is: what others do meanwhile does not count.
class OwnTimeClock final : public Clock {
 public:
  [[nodiscard]] Nanoseconds now() const override { return mine(); }
  static void advance(Nanoseconds by) { mine() += by; }

 private:
  static Nanoseconds& mine() {
    static thread_local Nanoseconds time{0};
    return time;
  }
};

inline devices::FramePtr frame_at(std::uint64_t sequence, Nanoseconds time, const cv::Mat& picture = {}) {
  auto frame = std::make_shared<devices::Frame>();
  frame->sequence = sequence;
  frame->device_time = time;
  frame->bgr = picture;
  return frame;
}

/// `count` frames without pictures, the first at `begin`.
inline std::vector<devices::FramePtr> frames_every(Nanoseconds step, std::uint64_t count, Nanoseconds begin = {}) {
  std::vector<devices::FramePtr> frames;
  for (std::uint64_t i = 0; i < count; ++i) frames.push_back(frame_at(i, begin + step * static_cast<long>(i)));
  return frames;
}

/// Gives the frames it was given.
class ListedSource final : public devices::Source {
 public:
  explicit ListedSource(std::vector<devices::FramePtr> frames, devices::SourceInfo about = {})
      : frames_(std::move(frames)), info_(std::move(about)) {}

  [[nodiscard]] const devices::SourceInfo& info() const override { return info_; }
  devices::FramePtr read(std::stop_token stop) override {
    if (before_read) before_read(next_);
    if (stop.stop_requested() || next_ == frames_.size()) return nullptr;
    return frames_[next_++];
  }
  [[nodiscard]] std::vector<std::string> warnings() const override { return {"a warning of the source"}; }
  [[nodiscard]] std::size_t frames_given() const { return next_; }

  std::function<void(std::size_t)> before_read;  ///< Called with the index of the frame to come; may throw.

 private:
  std::vector<devices::FramePtr> frames_;
  devices::SourceInfo info_;
  std::size_t next_ = 0;
};

class FunctionStage final : public pipeline::Stage {
 public:
  FunctionStage(std::string name, std::function<void(pipeline::Observation&)> work)
      : name_(std::move(name)), work_(std::move(work)) {}
  [[nodiscard]] std::string name() const override { return name_; }
  void process(pipeline::Observation& observation) override { work_(observation); }

 private:
  std::string name_;
  std::function<void(pipeline::Observation&)> work_;
};

}  // namespace choreo::test

// SPDX-License-Identifier: Apache-2.0
#include "devices/take/take_driver.hpp"

#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"
#include "devices/fourcc.hpp"
#include "devices/media/kinect_depth.hpp"
#include "devices/media/raw_converter.hpp"
#include "devices/oriented_source.hpp"
#include "devices/take/take_file.hpp"
#include "devices/take/take_stream.hpp"

namespace choreo::devices {
namespace {

using take::Part;

class TakeSource final : public Source {
 public:
  TakeSource(const SourceUri& uri, bool only_processed, const OpenOptions& options)
      : location_(uri.location), file_(uri.location, options.stop), keep_raw_(options.keep_raw) {
    if (only_processed && !file_.has_marks()) {
      throw usage_error(
          fmt::format("\"{}\" was recorded without a run: no frame of it is marked as processed", location_), {},
          "leave frames=processed out");
    }
    only_processed_ = only_processed;
    open_stream(Part::kColour, colour_, options.threads);
    open_stream(Part::kDepth, depth_, options.threads);
    if (colour_ && depth_ && colour_->facts().upright() != depth_->facts().upright()) {
      throw usage_error(fmt::format("\"{}\": colour and depth are of different sizes", location_));
    }
    const auto& shape = colour_ ? colour_->facts() : depth_->facts();
    info_.name = uri.text;
    info_.size = shape.upright();
    info_.raw_orientation =
        (colour_ && colour_->facts().raw) || !depth_ ? shape.orientation : depth_->facts().orientation;
    info_.nominal_fps = file_.facts().nominal_fps;
    info_.duration = file_.declared_duration();
    info_.repeatable = file_.is_regular_file();
    info_.foreseeable = !only_processed || file_.facts().foreseeable;
    info_.depth = depth_.has_value();
    info_.registers_depth = depth_ && depth_->facts().registered;
    info_.controls = file_.facts().controls;
    if (only_processed) info_.settings = file_.facts().settings;
    waiting_ = next(options.stop);
    if (!waiting_ && !options.stop.stop_requested()) {
      throw usage_error(fmt::format("\"{}\" holds no whole frame", location_), {},
                        "the recording was cut off before its first frame, or is damaged");
    }
  }

  const SourceInfo& info() const override { return info_; }

  FramePtr read(std::stop_token stop) override {
    if (stop.stop_requested()) return nullptr;
    return waiting_ ? std::exchange(waiting_, nullptr) : next(stop);
  }

  std::vector<std::string> warnings() const override {
    std::vector<std::string> all;
    if (const auto damaged = file_.damaged() + undecodable_; damaged > 0) {
      all.push_back(fmt::format("\"{}\": {} damaged {} left out", location_, damaged,
                                damaged == 1 ? "picture was" : "pictures were"));
    }
    if (file_.lost_marks()) {
      all.push_back(
          fmt::format("\"{}\": the marks of the run that recorded it are missing from some frame on", location_));
    }
    if (!file_.ended()) return all;
    const auto length = last_ && first_ ? to_seconds(*last_ - *first_) : 0.0;
    // Of a finished file the declared length is where its last picture ends, to the millisecond.
    const double fps = info_.nominal_fps > 0 ? info_.nominal_fps : 30;
    const double end = to_seconds(file_.last_time()) + 1.0 / fps + 0.003;
    if (file_.read_error() < 0) {
      all.push_back(fmt::format("\"{}\" ends at {:.1f} s with an error: {}", location_, length,
                                libav_error_text(file_.read_error())));
    } else if (!info_.duration) {
      all.push_back(fmt::format("\"{}\" was cut off at {:.1f} s: its recording was never finished", location_, length));
    } else if (end < to_seconds(*info_.duration)) {
      all.push_back(fmt::format("\"{}\" ends at {:.1f} s of the {:.1f} s it declares: truncated?", location_, length,
                                to_seconds(*info_.duration)));
    }
    return all;
  }

 private:
  void open_stream(Part part, std::optional<take::TakeStream>& stream, int threads) {
    if (const auto& facts = file_.stream(part)) stream.emplace(location_, file_.parameters(part), *facts, threads);
  }

  FramePtr next(const std::stop_token& stop) {
    while (const auto stored = file_.next(stop, only_processed_)) {
      auto frame = std::make_shared<Frame>();
      frame->sequence = stored->stamp.sequence;
      frame->device_time = stored->stamp.time;
      frame->overtaken = only_processed_ && file_.fate() != take::Fate::kProcessed;
      frame->late_face = only_processed_ && file_.late_face();
      frame->late_person = only_processed_ && file_.late_person();
      if (!add_colour(*frame, stored->packets[0].get()) || !add_depth(*frame, stored->packets[1].get())) {
        ++undecodable_;
        continue;
      }
      if (!first_) first_ = frame->device_time;
      last_ = frame->device_time;
      return frame;
    }
    return nullptr;
  }

  // False where the picture is damaged.
  bool add_colour(Frame& frame, const AVPacket* packet) {
    if (packet == nullptr || !colour_) {
      // Nothing was recorded: nothing is seen.
      if (!colour_) frame.bgr = cv::Mat::zeros(info_.size, CV_8UC3);
      return !colour_;
    }
    auto raw = picture(*colour_, *packet);
    if (!raw) return false;
    try {
      frame.bgr = oriented(converter_.to_bgr(*raw), colour_->facts().orientation);
    } catch (const Error&) {
      return false;
    }
    if (keep_raw_ && colour_->facts().raw) frame.raw_colour = std::move(raw);
    return true;
  }

  bool add_depth(Frame& frame, const AVPacket* packet) {
    if (packet == nullptr || !depth_) return true;
    auto raw = picture(*depth_, *packet);
    if (!raw) return false;
    cv::Mat depth;
    if (raw->fourcc == kKinectDepth) {
      depth = kinect_depth(raw->bytes, raw->size);
      if (depth_->facts().registered) depth = kinect_registered(depth);
    } else {
      depth.create(raw->size, CV_16UC1);
      std::memcpy(depth.data, raw->bytes.data(), raw->bytes.size());
    }
    frame.depth = oriented(depth, depth_->facts().orientation);
    if (keep_raw_ && depth_->facts().raw) frame.raw_depth = std::move(raw);
    return true;
  }

  static std::shared_ptr<RawPicture> picture(take::TakeStream& stream, const AVPacket& packet) {
    auto bytes = stream.bytes_of(packet);
    if (!bytes) return nullptr;
    auto raw = std::make_shared<RawPicture>();
    raw->fourcc = stream.facts().fourcc;
    raw->size = stream.facts().size;
    raw->bytes = std::move(*bytes);
    return raw;
  }

  std::string location_;
  take::TakeFile file_;
  bool keep_raw_;
  bool only_processed_ = false;
  std::optional<take::TakeStream> colour_;
  std::optional<take::TakeStream> depth_;
  RawConverter converter_;
  SourceInfo info_;
  FramePtr waiting_;  // The first, which opening has read.
  std::optional<Nanoseconds> first_;
  std::optional<Nanoseconds> last_;
  std::uint64_t undecodable_ = 0;
};

}  // namespace

Driver take_driver() {
  Driver driver;
  driver.scheme = "take";
  driver.example = "take.mkv?frames=processed";
  driver.summary = "what choreoscope recorded (record, live --record), frame for frame as it came";
  driver.open = [](const SourceUri& uri, SettingReader& settings,
                   const OpenOptions& options) -> std::unique_ptr<Source> {
    static const std::vector<std::string> kFrames = {"all", "processed"};
    const auto frames = settings.take_choice("frames", "all", kFrames);
    settings.refuse_the_rest();
    return std::make_unique<TakeSource>(uri, frames == "processed", options);
  };
  driver.claims = take::looks_like_take;
  return driver;
}

}  // namespace choreo::devices

// SPDX-License-Identifier: Apache-2.0
#include "devices/video_file/video_file.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <new>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"
#include "devices/media/picture.hpp"
#include "devices/media/video_stream.hpp"
#include "devices/video_file/timeline.hpp"

namespace choreo::devices {
namespace {

// What decides the size of the delivered picture.
struct Shape {
  cv::Size coded;
  AVRational sample_aspect{0, 1};
  Orientation orientation;

  [[nodiscard]] cv::Size delivered() const {
    auto size = with_square_pixels(coded, sample_aspect);
    if (orientation.swaps_sides()) std::swap(size.width, size.height);
    return size;
  }
};

class VideoFile final : public Source {
 public:
  VideoFile(const SourceUri& uri, bool network, const OpenOptions& options, Nanoseconds patience)
      : location_(network ? without_password(uri.location) : uri.location),
        stream_(uri.location, network, options, patience),
        pictures_(stream_.stream().codecpar->codec_id),
        timeline_(stream_.nominal_fps() > 0 ? from_seconds(1.0 / stream_.nominal_fps()) : Nanoseconds(0),
                  libav_time(1, stream_.stream().time_base).value_or(Nanoseconds(1))),
        frame_(av_frame_alloc()) {
    if (!frame_) throw std::bad_alloc();
    hang_by_stream();
    // Only decoding tells whether there is a frame, and of which size.
    switch (stream_.next(*frame_, {})) {
      case VideoStream::Outcome::kFrame:
        break;
      case VideoStream::Outcome::kStopped:
        throw failure(fmt::format("\"{}\": opening was interrupted", location_));
      case VideoStream::Outcome::kEnd:
        throw usage_error(fmt::format("\"{}\" holds no frame that can be decoded", location_), {},
                          stream_.damaged() == 1  ? "its one frame is damaged"
                          : stream_.damaged() > 1 ? fmt::format("all its {} frames are damaged", stream_.damaged())
                                                  : "the recording was cut off or never begun");
    }
    frame_waits_ = true;
    shape_ = shape_of(*frame_);
    const auto size = shape_.delivered();
    if (size.width > kMostSide || size.height > kMostSide) {
      throw usage_error(fmt::format("\"{}\": a picture of {}x{} is too large", location_, size.width, size.height), {},
                        fmt::format("sides up to {} pixels are read", kMostSide));
    }
    info_.name = uri.text;
    info_.size = size;
    info_.nominal_fps = stream_.nominal_fps();
    info_.duration = stream_.declared_duration();
    info_.repeatable = stream_.is_regular_file();
  }

  const SourceInfo& info() const override { return info_; }

  FramePtr read(std::stop_token stop) override { return next(std::move(stop), true); }
  FramePtr skim(std::stop_token stop) override { return next(std::move(stop), false); }

  std::vector<std::string> warnings() const override {
    std::vector<std::string> all = hanging_warnings_;
    const auto truncated = ended_ ? truncation() : std::string();
    // Where the recording breaks off, its last frame is cut as well: one cause, one warning.
    const auto damaged = stream_.damaged() - (truncated.empty() ? 0 : stream_.damaged_at_the_end());
    if (damaged > 0) {
      all.push_back(fmt::format("\"{}\": {} damaged {} left out", location_, damaged,
                                damaged == 1 ? "frame was" : "frames were"));
    }
    if (timeline_.mended() > 0) {
      all.push_back(fmt::format("\"{}\": {} of {} time stamps were missing or did not increase, and were mended",
                                location_, timeline_.mended(), delivered_));
    }
    if (!truncated.empty()) all.push_back(fmt::format("\"{}\" {}", location_, truncated));
    return all;
  }

 private:
  static constexpr int kMostSide = 32767;
  static constexpr Nanoseconds kLeastMissing = std::chrono::milliseconds(100);

  void hang_by_stream() {
    std::size_t size = 0;
    const auto* matrix = av_stream_get_side_data(&stream_.stream(), AV_PKT_DATA_DISPLAYMATRIX, &size);
    if (matrix != nullptr && size >= 9 * sizeof(std::int32_t)) hang(matrix);
  }

  void hang(const std::uint8_t* bytes) {
    std::array<std::int32_t, 9> matrix{};
    std::memcpy(matrix.data(), bytes, sizeof matrix);
    const auto hanging = hanging_of(matrix.data());
    orientation_ = hanging.orientation;
    if (!hanging.exact && hanging_warnings_.empty()) {
      hanging_warnings_.push_back(
          fmt::format("\"{}\" asks to be shown at an angle; the nearest quarter turn is used", location_));
    }
  }

  Shape shape_of(AVFrame& frame) {
    const auto* side = av_frame_get_side_data(&frame, AV_FRAME_DATA_DISPLAYMATRIX);
    if (side != nullptr && side->size >= 9 * sizeof(std::int32_t)) hang(side->data);
    Shape shape{{frame.width, frame.height}, {1, 1}, orientation_};
    const auto aspect = av_guess_sample_aspect_ratio(&stream_.container(), &stream_.stream(), &frame);
    if (aspect.num > 0 && aspect.den > 0) {
      av_reduce(&shape.sample_aspect.num, &shape.sample_aspect.den, aspect.num, aspect.den, INT32_MAX);
    }
    return shape;
  }

  FramePtr next(std::stop_token stop, bool with_picture) {
    if (ended_ || stop.stop_requested()) return nullptr;
    if (!frame_waits_) {
      const auto outcome = stream_.next(*frame_, stop);
      ended_ = outcome == VideoStream::Outcome::kEnd;
      if (outcome != VideoStream::Outcome::kFrame) return nullptr;
    }
    frame_waits_ = false;
    return deliver(with_picture);
  }

  FramePtr deliver(bool with_picture) {
    const auto raw = libav_time(frame_->best_effort_timestamp, stream_.stream().time_base);
    const auto time = timeline_.next(raw);
    const auto shape = shape_of(*frame_);
    if (shape.delivered() != info_.size || shape.coded != shape_.coded) refuse_change(shape, time);

    auto out = std::make_shared<Frame>();
    if (with_picture) out->bgr = pictures_.make(*frame_, shape.sample_aspect, shape.orientation);
    out->sequence = delivered_++ + stream_.damaged();
    out->device_time = time;

    if (!first_time_) first_time_ = time;
    // The length of a frame is declared, or that of a nominal frame, or as long as the one before.
    const auto declared = libav_time(frame_->pkt_duration, stream_.stream().time_base);
    auto length = declared && declared->count() > 0 ? *declared : time - last_time_.value_or(time);
    if (!(declared && declared->count() > 0) && info_.nominal_fps > 0) length = from_seconds(1.0 / info_.nominal_fps);
    longest_step_ = std::max(longest_step_, time - last_time_.value_or(time));
    last_time_ = time;
    last_end_ = time + length;
    last_length_ = length;
    av_frame_unref(frame_.get());
    return out;
  }

  [[noreturn]] void refuse_change(const Shape& now, Nanoseconds time) {
    ended_ = true;
    const auto before = info_.size;
    const auto after = now.delivered();
    throw failure(fmt::format("\"{}\": the picture changes from {}x{} to {}x{} at {:.3f} s", location_, before.width,
                              before.height, after.width, after.height, to_seconds(time - first_time_.value_or(time))),
                  {}, "cut the recording there, or bring it to one size with ffmpeg");
  }

  // Says where a recording ended before its declared length or with an error; empty where it did not.
  std::string truncation() const {
    const auto& stream = stream_.stream();
    auto begin = first_time_.value_or(Nanoseconds(0));
    if (const auto start = libav_time(stream.start_time, stream.time_base)) begin = std::min(begin, *start);
    // Matroska counts its lengths from zero and not from the first frame.
    if (std::strstr(stream_.container().iformat->name, "matroska") != nullptr) begin = std::min(begin, Nanoseconds(0));
    const auto length = last_end_ - begin;
    if (info_.duration) {
      // Of a variable frame rate the last frame may have been meant to stand as long as any other.
      // Nothing below a tenth of a second is worth a word, nor known where there is but one frame.
      const auto tolerance = std::max({2 * last_length_, longest_step_, *info_.duration / 50, kLeastMissing});
      if (length + tolerance < *info_.duration) {
        return fmt::format("ends at {:.1f} s of the {:.1f} s it declares: truncated?", to_seconds(length),
                           to_seconds(*info_.duration));
      }
    }
    if (stream_.read_error() != 0) {
      return fmt::format("ends at {:.1f} s with an error: {}", to_seconds(length),
                         libav_error_text(stream_.read_error()));
    }
    return {};
  }

  std::string location_;
  VideoStream stream_;
  PictureMaker pictures_;
  Timeline timeline_;
  Libav<AVFrame> frame_;
  bool frame_waits_ = false;
  bool ended_ = false;
  Orientation orientation_;
  Shape shape_;
  SourceInfo info_;
  std::uint64_t delivered_ = 0;
  std::optional<Nanoseconds> first_time_;
  std::optional<Nanoseconds> last_time_;
  Nanoseconds last_end_{0};
  Nanoseconds last_length_{0};
  Nanoseconds longest_step_{0};
  std::vector<std::string> hanging_warnings_;
};

}  // namespace

Driver video_file_driver() {
  Driver driver;
  driver.scheme = "file";
  driver.example = "clip.mp4?rotate=90";
  driver.summary = "a video file, anything FFmpeg opens";
  driver.open = [](const SourceUri& uri, SettingReader& settings, const OpenOptions& options) {
    settings.refuse_the_rest();
    return std::make_unique<VideoFile>(uri, false, options, Nanoseconds(0));
  };
  return driver;
}

std::unique_ptr<Source> open_remote_recording(const SourceUri& uri, const OpenOptions& options, Nanoseconds patience) {
  return std::make_unique<VideoFile>(uri, true, options, patience);
}

}  // namespace choreo::devices

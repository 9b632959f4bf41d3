// SPDX-License-Identifier: Apache-2.0
#include "devices/oriented_source.hpp"

#include <utility>

#include <opencv2/core.hpp>

namespace choreo::devices {

cv::Mat oriented(const cv::Mat& picture, const Orientation& orientation) {
  if (orientation.is_identity()) return picture;
  cv::Mat turned = picture;
  if (orientation.quarter_turns != 0) {
    static constexpr int kCodes[] = {cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180, cv::ROTATE_90_COUNTERCLOCKWISE};
    cv::Mat out;
    cv::rotate(turned, out, kCodes[orientation.quarter_turns - 1]);
    turned = out;
  }
  if (orientation.flip_horizontal || orientation.flip_vertical) {
    const int code = orientation.flip_horizontal ? (orientation.flip_vertical ? -1 : 1) : 0;
    cv::Mat out;
    cv::flip(turned, out, code);
    turned = out;
  }
  return turned;
}

namespace {

class OrientedSource final : public Source {
 public:
  OrientedSource(std::unique_ptr<Source> source, const Orientation& orientation)
      : source_(std::move(source)), orientation_(orientation), info_(source_->info()) {
    if (orientation_.swaps_sides()) std::swap(info_.size.width, info_.size.height);
    info_.raw_orientation = info_.raw_orientation.then(orientation_);
  }

  const SourceInfo& info() const override { return info_; }

  FramePtr read(std::stop_token stop) override { return turned(source_->read(std::move(stop))); }
  FramePtr skim(std::stop_token stop) override { return turned(source_->skim(std::move(stop))); }

  std::vector<std::string> warnings() const override { return source_->warnings(); }

 private:
  [[nodiscard]] FramePtr turned(const FramePtr& frame) const {
    if (!frame) return nullptr;
    auto turned = std::make_shared<Frame>(*frame);
    if (!frame->bgr.empty()) turned->bgr = oriented(frame->bgr, orientation_);
    if (!frame->depth.empty()) turned->depth = oriented(frame->depth, orientation_);
    return turned;
  }

  std::unique_ptr<Source> source_;
  Orientation orientation_;
  SourceInfo info_;
};

}  // namespace

std::unique_ptr<Source> make_oriented(std::unique_ptr<Source> source, const Orientation& orientation) {
  if (orientation.is_identity()) return source;
  return std::make_unique<OrientedSource>(std::move(source), orientation);
}

}  // namespace choreo::devices

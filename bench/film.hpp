// SPDX-License-Identifier: Apache-2.0
// A synthetic performer filmed beforehand, so that a benchmark does not measure the making of its pictures.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "devices/source.hpp"
#include "devices/synthetic/performer.hpp"

namespace choreo::bench {

/// Pictures in an endless loop, as far apart in their own time as they were filmed.
class Film final : public devices::Source {
 public:
  /// @param frames  of the performance, from its first one.
  Film(std::string_view script, const devices::synthetic::PerformerSettings& settings, int frames);

  /// Begins anew, and ends after so many frames.
  void rewind(std::uint64_t frames) {
    next_ = 0;
    end_ = frames;
  }
  [[nodiscard]] const cv::Mat& room() const { return room_; }
  [[nodiscard]] const std::vector<cv::Mat>& pictures() const { return pictures_; }

  [[nodiscard]] const devices::SourceInfo& info() const override { return info_; }
  devices::FramePtr read(std::stop_token stop) override;

 private:
  std::vector<cv::Mat> pictures_;
  cv::Mat room_;
  devices::SourceInfo info_;
  std::uint64_t next_ = 0;
  std::uint64_t end_ = 0;
};

/// The film as a source that may be owned; the film must outlive it.
[[nodiscard]] std::unique_ptr<devices::Source> borrowed(Film& film);

}  // namespace choreo::bench

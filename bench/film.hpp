// SPDX-License-Identifier: Apache-2.0
// A synthetic performer filmed beforehand, so that a benchmark does not measure the making of its pictures.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "devices/source.hpp"
#include "devices/synthetic/performer.hpp"
#include "pipeline/runner.hpp"
#include "vision/body_masker.hpp"

namespace choreo::bench {

constexpr double kFilmNoise = 3;
/// Of the live history: ten minutes of 30 frames a second.
constexpr auto kHistory = std::chrono::minutes(10);
constexpr std::size_t kHistoryFrames = 18'000;

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

/// What knows the film's room, at the size that is worked at.
[[nodiscard]] vision::BodyMasker masker_for(const Film& film, cv::Size working);

enum class Pace { kMax, kCamera };  ///< A camera waits for nobody: the newest frame wins.

/// Runs the film from its beginning for so many frames.
pipeline::RunReport run_film(Film& film, std::vector<std::unique_ptr<pipeline::Stage>>& stages, int threads, Pace pace,
                             std::uint64_t frames, const Clock& clock);

}  // namespace choreo::bench

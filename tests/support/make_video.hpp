// SPDX-License-Identifier: Apache-2.0
// Makes video files of every kind for tests, with what the program itself never writes: display matrices, sample
// aspect ratios, other pixel formats.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

extern "C" {
#include <libavcodec/avcodec.h>
}

namespace choreo::test {

struct VideoRecipe {
  const char* format = nullptr;  ///< FFmpeg's name of the container; from the file name where null.
  const char* encoder = "ffv1";
  AVPixelFormat pixel_format = AV_PIX_FMT_BGR0;
  int width = 32;
  int height = 24;
  AVRational time_base{1, 1000};
  std::vector<std::int64_t> times = {0, 40, 80};  ///< One frame each, in units of the time base.
  std::int64_t duration = 0;  ///< Of each frame, in units of the time base; 0: undeclared but where it must be.
  AVRational rate{0, 1};      ///< As the container declares it; 0: it does not.
  AVRational sample_aspect{0, 1};
  std::vector<std::int32_t> display_matrix;  ///< Nine numbers, or none.
  AVColorSpace colour_space = AVCOL_SPC_UNSPECIFIED;
  AVColorRange colour_range = AVCOL_RANGE_UNSPECIFIED;
  int threads = 1;
  /// Fills frame number `index`, whose buffers are zero.
  std::function<void(AVFrame& frame, int index)> paint = [](AVFrame&, int) {};
};

[[nodiscard]] bool has_encoder(const char* name);

/// @throws std::runtime_error naming the FFmpeg call that failed.
void make_video(const std::string& path, const VideoRecipe& recipe);

/// Sets every sample of plane `plane` (8 bit, or 16 bit words where `words`).
void fill_plane(AVFrame& frame, int plane, int value, bool words = false);

}  // namespace choreo::test

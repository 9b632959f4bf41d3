// SPDX-License-Identifier: Apache-2.0
// The synthetic performer: frames of a scripted figure with everything that is true of them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "body/figure.hpp"
#include "core/time.hpp"
#include "devices/synthetic/look.hpp"
#include "devices/synthetic/scene.hpp"
#include "devices/synthetic/script.hpp"

namespace choreo::devices::synthetic {

/// How a script is filmed.
struct PerformerSettings {
  cv::Size size{640, 480};         ///< 16x16 to 3840x2160, or turned on its side.
  double fps = 30;                 ///< Frames a second, 1 to 240.
  std::uint64_t seed = 1;          ///< Of looks, style and noise.
  double noise = 3;                ///< Standard deviation in grey levels per channel, 0 to 30.
  double drift = 0;                ///< Brightness, grey levels a minute, -60 to 60.
  double flicker = 0;              ///< Amplitude in grey levels, 0 to 30, of light that swings 100 times a second.
  double shake = 0;                ///< Camera shake, pixels rms along each axis, 0 to 10.
  bool depth = false;              ///< Also what a depth camera sees.
  double empty = 1;                ///< Seconds of empty room before the performance, 0 to 60.
  double tail = 0;                 ///< And after it.
  std::optional<double> duration;  ///< Seconds of performance, up to 36000; the script's own where absent.
  std::string text;                ///< For semaphore; the alphabet where empty.
  double letters_per_minute = 12;  ///< For semaphore, 4 to 60.
  std::string build = "auto";      ///< See look.hpp for the names.
  std::string skin = "auto";
  std::string clothes = "auto";
  std::string sleeves = "half";  ///< See scene.hpp for the names of these three.
  std::string room = "plain";
  std::string light = "neutral";
  bool poster = false;  ///< A painted face on the wall.
  bool flags = false;   ///< One in each hand.
  double distance = 1;  ///< Factor on how far the performer stands, 0.6 to 2.5.
  double place = 0;     ///< To the right, in widths of the picture, -0.35 to 0.35.
  CameraPan pan;        ///< The camera stands elsewhere throughout.
  double exposure = 1;  ///< Factor on everything but the noise, 0.5 to 1.5.

  /// @throws Error (usage) where a value is out of its range.
  void validate() const;
};

/// One frame and the truth about it.
struct Performance {
  cv::Mat bgr;           ///< CV_8UC3.
  cv::Mat mask;          ///< CV_8UC1, 255 where body and flags cover at least half the pixel, else 0.
  cv::Mat depth;         ///< CV_16UC1, mm, 0 where unknown (see DepthCamera); empty unless `settings.depth`.
  body::Pose pose;       ///< Standing where nobody is in the room.
  bool present = false;  ///< Some pixel of the mask is set.
  cv::Rect2d face;       ///< Cheek to cheek, chin to hairline, px; empty where turned away or more than half hidden.
  std::array<cv::Mat, 2> bare_arm;  ///< By body::Side: CV_8UC1, 255 where its bare skin covers at least half the pixel.
  std::string_view sign;            ///< Held now by `semaphore` (SpelledSign's name); empty elsewhere and in between.
  Nanoseconds time{0};              ///< From the first frame.
  std::vector<std::pair<std::string, double>> angles;  ///< Root in units of H, joints in degrees; empty if not present.
};

/// Films a script. Every frame depends on its index alone: the same settings give the same bytes in any order.
/// @thread reentrant; one object must not be used by two threads at once.
class Performer {
 public:
  /// @throws Error (usage) for an unknown script or settings out of range.
  Performer(std::string_view script, const PerformerSettings& settings);
  ~Performer();
  Performer(Performer&&) noexcept;
  Performer& operator=(Performer&&) noexcept;

  [[nodiscard]] int frame_count() const;
  [[nodiscard]] const Script& script() const;
  [[nodiscard]] const Look& look() const;
  [[nodiscard]] const PerformerSettings& settings() const;

  /// Index of the first frame after `empty`; its time in the script is 0.
  [[nodiscard]] int first_frame() const;

  /// The room without body, noise, shake or changes of light. CV_8UC3.
  [[nodiscard]] cv::Mat room() const;

  /// @param index  from 0 to frame_count() - 1.
  /// @cost  About the time to add noise to a picture; pictures are newly allocated.
  [[nodiscard]] Performance perform(int index) const;

 private:
  struct Film;
  std::unique_ptr<Film> film_;
};

}  // namespace choreo::devices::synthetic

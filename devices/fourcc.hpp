// SPDX-License-Identifier: Apache-2.0
// Four letters that name how the bytes of a picture lie, as the kernel's cameras have them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace choreo::devices {

/// fourcc("YUYV"): the first letter is the lowest byte.
[[nodiscard]] constexpr std::uint32_t fourcc(const char (&letters)[5]) {
  std::uint32_t code = 0;
  for (int k = 3; k >= 0; --k) code = code << 8U | static_cast<unsigned char>(letters[k]);
  return code;
}

inline constexpr std::uint32_t kBgr3 = fourcc("BGR3");
inline constexpr std::uint32_t kRgb3 = fourcc("RGB3");
inline constexpr std::uint32_t kYuyv = fourcc("YUYV");
inline constexpr std::uint32_t kUyvy = fourcc("UYVY");
inline constexpr std::uint32_t kYvyu = fourcc("YVYU");
inline constexpr std::uint32_t kNv12 = fourcc("NV12");
inline constexpr std::uint32_t kGrey = fourcc("GREY");
inline constexpr std::uint32_t kMjpg = fourcc("MJPG");
inline constexpr std::uint32_t kZ16 = fourcc("Z16 ");  ///< Depth in millimetres, 16 bits, the low byte first.
/// The first Kinect's own depth: 11 bits in 16, the low byte first, 2047 where nothing is known.
inline constexpr std::uint32_t kKinectDepth = fourcc("KD11");

/// "YUYV"; what is not printable becomes a dot, and spaces at the end go.
[[nodiscard]] std::string name_of_fourcc(std::uint32_t code);

}  // namespace choreo::devices

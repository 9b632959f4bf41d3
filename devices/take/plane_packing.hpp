// SPDX-License-Identifier: Apache-2.0
// Between the bytes that devices give and the planes that codecs take: nothing but another order.
#pragma once

#include <cstdint>
#include <vector>

#include "devices/media/libav.hpp"
#include "devices/media/raw_converter.hpp"

namespace choreo::devices::take {

/// How the planes of a format lie. Colours of three bytes become `bgr`, which is one of AV_PIX_FMT_BGR0 and
/// AV_PIX_FMT_GBRP: not every codec takes both. AV_PIX_FMT_NONE for MJPG and what is unknown.
[[nodiscard]] AVPixelFormat planes_for(std::uint32_t fourcc, AVPixelFormat bgr);

/// Fills the planes of `frame`, which is of `planes_for(layout.fourcc, ...)` and of the layout's size.
/// @param bytes  at least bytes_of(layout), and lines of `layout.stride`.
void to_planes(const Layout& layout, const std::uint8_t* bytes, AVFrame& frame);

/// The inverse, without padding. @param frame  as for `to_planes`.
[[nodiscard]] std::vector<std::uint8_t> from_planes(const AVFrame& frame, std::uint32_t fourcc);

}  // namespace choreo::devices::take

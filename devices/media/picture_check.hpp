// SPDX-License-Identifier: Apache-2.0
// Tells whole picture files from truncated ones before a decoder fills in what is missing.
#pragma once

#include <cstdint>
#include <span>

namespace choreo::devices {

/// False where a PNG, JPEG, BMP, WebP, PGM or PPM file ends before its own structure does, or a PNG checksum is wrong.
///
/// Decoders deliver a truncated JPEG with grey or repeated rows and call it a success. Other formats, and pixels that
/// are wrong in a well-formed file, are the decoder's to judge.
/// @source PNG: W3C 2003, chapter 5; JPEG: ITU T.81, annex B; BMP: BITMAPFILEHEADER, BITMAPINFOHEADER.
[[nodiscard]] bool is_whole_picture(std::span<const std::uint8_t> file);

}  // namespace choreo::devices

// SPDX-License-Identifier: Apache-2.0
// Finds damage in FFV1 packets, which FFmpeg's decoder would hide by repeating parts of the picture before.
#pragma once

#include <cstdint>
#include <span>

namespace choreo::devices {

/// Checks the checksum that FFV1 version 3 carries at the end of every slice.
///
/// Whether a stream carries them at all is known from the first packet in which all are right; until then nothing is
/// called damaged.
/// @source RFC 9043, section 4.9, Slice Footer: slice_size (24 bit), error_status (8), slice_crc_parity (32).
class Ffv1Check {
 public:
  /// True where the packet is certainly damaged.
  [[nodiscard]] bool is_damaged(std::span<const std::uint8_t> packet);

 private:
  bool carries_checksums_ = false;
};

}  // namespace choreo::devices

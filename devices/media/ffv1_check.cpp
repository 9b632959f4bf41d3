// SPDX-License-Identifier: Apache-2.0
#include "devices/media/ffv1_check.hpp"

extern "C" {
#include <libavutil/crc.h>
}

namespace choreo::devices {
namespace {

bool all_slices_are_right(std::span<const std::uint8_t> packet) {
  constexpr std::size_t kFooter = 8;
  const auto* table = av_crc_get_table(AV_CRC_32_IEEE);
  if (packet.empty()) return false;
  // The slices are found from the last to the first: each ends with its size.
  while (!packet.empty()) {
    if (packet.size() < kFooter) return false;
    const auto* footer = packet.data() + packet.size() - kFooter;
    const std::size_t size = kFooter + (std::size_t{footer[0]} << 16) + (std::size_t{footer[1]} << 8) + footer[2];
    if (size > packet.size()) return false;
    // The parity is chosen so that the checksum over the slice and its footer is zero.
    if (av_crc(table, 0, packet.data() + packet.size() - size, size) != 0) return false;
    packet = packet.first(packet.size() - size);
  }
  return true;
}

}  // namespace

bool Ffv1Check::is_damaged(std::span<const std::uint8_t> packet) {
  if (all_slices_are_right(packet)) {
    carries_checksums_ = true;
    return false;
  }
  return carries_checksums_;
}

}  // namespace choreo::devices

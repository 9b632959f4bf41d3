// SPDX-License-Identifier: Apache-2.0
// How the semaphore script spells: which sign is held when.
#pragma once

#include <string_view>
#include <vector>

#include "body/semaphore_signs.hpp"

namespace choreo::devices::synthetic {

/// A sign and the stretch over which it is held, in seconds from the script's beginning.
struct SpelledSign {
  body::SemaphoreSign sign;  ///< Of a movement "ATTENTION" or "ERROR", with the positions about which the arms swing.
  double from = 0;
  double to = 0;
  bool moves = false;
};

/// The signs of a text. Letters of either case are themselves, a digit is its letter (1 to 9: A to I, 0: K) after
/// NUMERALS, and J leads back to letters; '#' is NUMERALS and '!' CANCEL by themselves; a space is a longer REST.
/// Every sign takes 60 / rate seconds: 15 % to raise the arms, 55 % held, 15 % to lower them, 15 % at REST.
///
/// '^' is ATTENTION: both arms are waved four times from positions 3 and 5 to where they cross overhead, and back. '~'
/// is ERROR: both are raised five times from 1 and 7 to 3 and 5, and lowered. Each wave takes 0.8 s whatever the rate.
/// @throws Error (usage) for any other character, and for a text without any sign or of more than 10000.
[[nodiscard]] std::vector<SpelledSign> spelled(std::string_view text, double letters_per_minute);

}  // namespace choreo::devices::synthetic

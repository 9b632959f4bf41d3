// SPDX-License-Identifier: Apache-2.0
// What was found of the two arms in one picture.
#pragma once

#include <array>
#include <string_view>

#include "vision/blob.hpp"

namespace choreo::vision {

enum class ArmCase {
  kNoFace,  ///< Nothing tells how large the body is and where the arms may be.
  kNoArm,   ///< No region of the tone is an arm.
  kOneArm,  ///< The other is hidden.
  kJoined,  ///< One region holds both: hands joined, or arms that cross.
  kTwoArms,
};

/// "no_face", "no_arm", "one_arm", "joined", "two_arms".
[[nodiscard]] constexpr std::string_view name_of(ArmCase found) {
  switch (found) {
    case ArmCase::kNoFace:
      return "no_face";
    case ArmCase::kNoArm:
      return "no_arm";
    case ArmCase::kOneArm:
      return "one_arm";
    case ArmCase::kJoined:
      return "joined";
    case ArmCase::kTwoArms:
      return "two_arms";
  }
  return "";
}

struct Arms {
  ArmCase found = ArmCase::kNoFace;
  /// With kTwoArms both, the one farther left in the picture first; with kJoined and kOneArm the first alone.
  std::array<Blob, 2> blob;
  bool at_face = false;  ///< An arm reaches into the face's region, and lacks what is hidden there.
  bool pieced = false;   ///< An arm was put together from several regions: a sleeve, a watch, a strap.
};

}  // namespace choreo::vision

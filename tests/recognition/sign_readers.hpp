// SPDX-License-Identifier: Apache-2.0
// The two ways to read signs, by tone and by looks, for tests of what is the same in both.
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "recognition/arm_sign_reader.hpp"
#include "recognition/semaphore_reader.hpp"
#include "recognition/signaller.hpp"

namespace choreo::test {

/// Where the figure's arms point, with the signaller's jitter in every direction.
inline body::ArmPoses pointing(const body::Pose& pose, const Signaller& who, std::mt19937_64& chance) {
  const auto s = body::skeleton_of(pose);
  body::ArmPoses arms;
  for (const auto side : {body::kLeft, body::kRight}) {
    const Eigen::Vector3d upper = s.elbow[side] - s.shoulder[side], fore = s.fingertip[side] - s.elbow[side];
    const auto direction = [&](const Eigen::Vector3d& v) {
      const double degrees = std::atan2(-v.x(), -v.y()) * 180 / std::numbers::pi;
      return body::whole_turns_off(degrees + who.joint_jitter * normal(chance));
    };
    const double shown = (upper.head<2>().norm() + fore.head<2>().norm()) / (upper.norm() + fore.norm());
    arms[side] = body::ArmPose{direction(upper), direction(fore), shown, 1, 0};
  }
  return arms;
}

struct ByTone {
  using Reader = recognition::SemaphoreReader;
  using Seen = body::ParticleState;
  static constexpr const char* kName = "ByTone";
  static Seen see(const body::Pose& pose, const Signaller& who, std::mt19937_64& chance) {
    return seen(pose, who, chance);
  }
};

struct ByLooks {
  using Reader = recognition::ArmSignReader;
  using Seen = body::ArmPoses;
  static constexpr const char* kName = "ByLooks";
  static Seen see(const body::Pose& pose, const Signaller& who, std::mt19937_64& chance) {
    return pointing(pose, who, chance);
  }
};

using WaysToRead = ::testing::Types<ByTone, ByLooks>;

struct WayNames {
  template <class Way>
  static std::string GetName(int /*place*/) {
    return Way::kName;
  }
};

}  // namespace choreo::test

// SPDX-License-Identifier: Apache-2.0
#include "pipeline/person_evidence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <opencv2/core.hpp>

namespace choreo::pipeline {
namespace {

using Name = vision::PersonPointName;

// Silhouettes lack a sleeve now and then that is like the wall, where the joints are seen all the same.
struct Bone {
  Name from, to;
  double radius_m;  // With clothes.
};
constexpr double kArm = 0.08, kLeg = 0.1, kTrunk = 0.12;
constexpr std::array<Bone, 12> kBones = {{{Name::kLeftShoulder, Name::kLeftElbow, kArm},
                                          {Name::kRightShoulder, Name::kRightElbow, kArm},
                                          {Name::kLeftElbow, Name::kLeftWrist, kArm},
                                          {Name::kRightElbow, Name::kRightWrist, kArm},
                                          {Name::kLeftHip, Name::kLeftKnee, kLeg},
                                          {Name::kRightHip, Name::kRightKnee, kLeg},
                                          {Name::kLeftKnee, Name::kLeftAnkle, kLeg},
                                          {Name::kRightKnee, Name::kRightAnkle, kLeg},
                                          {Name::kLeftShoulder, Name::kLeftHip, kTrunk},
                                          {Name::kRightShoulder, Name::kRightHip, kTrunk},
                                          {Name::kLeftShoulder, Name::kRightHip, kTrunk},
                                          {Name::kRightShoulder, Name::kLeftHip, kTrunk}}};

}  // namespace

vision::PersonEvidence evidence_of(const vision::PersonLook& look, cv::Size size) {
  constexpr double kBlur = 2.5;  // Pixels of the network's silhouette, whose edges are so soft.
  constexpr double kHeld = 0.5;  // Metres about a hand: a flag, a fan, a hat.
  vision::PersonEvidence evidence;
  evidence.likely = vision::silhouette_in_picture(look, size);
  evidence.doubt_px = kBlur * look.region.side / std::max(1, look.silhouette.cols);
  const double scale = look.pixels_per_metre();
  for (const auto& bone : kBones) {
    constexpr double kSeen = 0.5;
    if (std::min(look[bone.from].visibility, look[bone.to].visibility) < kSeen) continue;
    evidence.limbs.push_back({look[bone.from].at, look[bone.to].at, bone.radius_m * scale});
  }
  for (const auto wrist : {Name::kLeftWrist, Name::kRightWrist}) {  // A flag may hide it.
    evidence.held.push_back({look[wrist].at, look[wrist].at, kHeld * scale});
  }
  return evidence;
}

vision::PersonEvidence evidence_of(const PersonSighting& sighting, cv::Size size, Nanoseconds now) {
  constexpr double kFastest = 2.0;  // Sides of the region a second; faster is a joint that was mistaken.
  auto evidence = evidence_of(sighting.look, size);
  const double side = sighting.look.region.side;
  const double speed = std::min(sighting.speed.value_or(side), kFastest * side);
  evidence.seen_s = to_seconds(sighting.time);
  evidence.doubt_px += speed * to_seconds(std::max(now - sighting.time, Nanoseconds{0}));
  return evidence;
}

vision::PersonEvidence evidence_of(const Observation& observation, cv::Size size, OtherPeople others) {
  vision::PersonEvidence evidence;
  if (observation.person) evidence = evidence_of(*observation.person, size, observation.time);
  for (const auto& other : observation.others) {
    const auto theirs = evidence_of(*other, size, observation.time);
    if (others == OtherPeople::kBodies) {
      evidence = vision::together(std::move(evidence), theirs);
    } else if (evidence.others.empty()) {
      evidence.others = theirs.likely;
      evidence.about_others = vision::possible(theirs, size);
    } else {
      cv::max(evidence.others, theirs.likely, evidence.others);
      evidence.about_others |= vision::possible(theirs, size);
    }
  }
  return evidence;
}

}  // namespace choreo::pipeline

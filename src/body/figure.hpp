// SPDX-License-Identifier: Apache-2.0
// A jointed human figure in Vitruvian proportions: poses, their mirror images, where the limbs then are.
//
// Body coordinates: x to the performer's left, y up, z forward, the origin on the floor between the feet of the
// standing figure; lengths in units of the body's height H. Seen from the front, x runs to the picture's right.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace choreo::body {

/// Lengths in units of H. Face, head, upper arm, forearm with hand as in docs/mathematics (particles); the rest is
/// Vitruvius, De architectura III.1, and Leonardo's note to his drawing of it.
namespace vitruvian {
inline constexpr double kFaceWidth = 1.0 / 10;     ///< Also the face's height, chin to hairline [Vitruvius].
inline constexpr double kHeadHeight = 1.0 / 8;     ///< Chin to crown [Vitruvius].
inline constexpr double kUpperArm = 1.0 / 8;       ///< Shoulder to elbow [Leonardo: elbow to armpit].
inline constexpr double kForearm = 1.0 / 4;        ///< The cubit: elbow to finger tip [Vitruvius].
inline constexpr double kForearmWidth = 1.0 / 20;  ///< Of the forearm with its hand.
inline constexpr double kHand = 1.0 / 10;          ///< Wrist to tip of the middle finger [Vitruvius].
inline constexpr double kShoulderHalf = 1.0 / 8;   ///< Shoulders a quarter wide [Leonardo]; so the arms span H.
inline constexpr double kFoot = 1.0 / 6;           ///< Heel to toe [Vitruvius].
inline constexpr double kNeckPit =
    1.0 - 1.0 / 40 - 1.0 / 6;  ///< Top of the breast, 1/6 below the hairline [Vitruvius].
inline constexpr double kShoulderHeight = kNeckPit;
inline constexpr double kHipHeight = 0.52;    ///< Joint just above the groin, which is at H/2 [Leonardo].
inline constexpr double kHipHalf = 0.05;      ///< Our choice.
inline constexpr double kKneeHeight = 0.27;   ///< The knee's lower edge is at H/4 [Leonardo].
inline constexpr double kAnkleHeight = 0.04;  ///< Our choice.
inline constexpr double kThigh = kHipHeight - kKneeHeight;
inline constexpr double kShank = kKneeHeight - kAnkleHeight;
inline constexpr double kWaistHeight = 0.60;  ///< The navel, where the trunk bends [Leonardo].
}  // namespace vitruvian

enum Side : std::size_t { kLeft = 0, kRight = 1 };  ///< The performer's own.

/// Degrees; 0 hangs straight down with the thumb forward. Applied from the shoulder outwards in the order written.
struct ArmAngles {
  double abduction = 0;  ///< Raises the arm sideways about z: 90 horizontal, 180 overhead, negative across the body.
  double flexion = 0;    ///< Raises the arm forward; after abduction, so the picture's angle stays the abduction.
  double twist = 0;      ///< Turns the arm outwards about itself: where the elbow bends to. 0 forward, 90 outwards
                         ///< (upwards of an arm held out sideways), -90 inwards.
  double elbow = 0;      ///< 0 straight, 140 folded.
};

/// Degrees; 0 stands straight with the foot forward. Applied from the hip outwards in the order written.
struct LegAngles {
  double abduction = 0;  ///< Spreads the leg sideways.
  double flexion = 0;    ///< Lifts the thigh forward.
  double twist = 0;      ///< Turns the leg outwards about itself.
  double knee = 0;       ///< 0 straight, 140 folded; the shank goes back.
  double ankle = 0;      ///< Positive points the toes down.
};

/// What the body does, as joint angles in degrees and the place of the pelvis in units of H.
struct Pose {
  Eigen::Vector3d root = Eigen::Vector3d::Zero();  ///< Displacement of the pelvis from where it is in standing.
  double heading = 0;            ///< About y; positive turns to the performer's left. 0 faces the viewer.
  double trunk_lean = 0;         ///< Forward, at the waist.
  double trunk_side = 0;         ///< Towards the performer's left.
  double trunk_twist = 0;        ///< To the performer's left.
  double neck_nod = 0;           ///< Forward.
  double neck_side = 0;          ///< Towards the performer's left.
  double neck_turn = 0;          ///< To the performer's left.
  std::array<ArmAngles, 2> arm;  ///< By Side.
  std::array<LegAngles, 2> leg;  ///< By Side.
};

/// Number of values in a pose: three of the root, seven of trunk and neck, four an arm, five a leg.
inline constexpr std::size_t kPoseValues = 28;

/// The pose's values in the order of `pose_value_names()`.
[[nodiscard]] std::array<double, kPoseValues> pose_values(const Pose& pose);
[[nodiscard]] Pose pose_from_values(const std::array<double, kPoseValues>& values);

/// "root_x", "heading", "left_arm_abduction", ...; the first three in units of H, the others in degrees.
[[nodiscard]] const std::array<std::string, kPoseValues>& pose_value_names();

/// The pose in a mirror: left with right, and every turn about y or z reversed. Mirroring twice is the identity.
[[nodiscard]] Pose mirrored(const Pose& pose);

/// (1 - share) a + share b, value by value.
[[nodiscard]] Pose blended(const Pose& a, const Pose& b, double share);

/// The pose lifted or lowered so that its lowest sole is `above` (units of H) over the floor.
[[nodiscard]] Pose grounded(const Pose& pose, double above = 0);

/// Where the joints are, and how the larger parts are turned (columns: the part's own left, up and forward).
struct Skeleton {
  Eigen::Vector3d pelvis, waist, neck, skull, crown;  ///< Hip line's middle, navel, neck pit, head's centre and top.
  Eigen::Matrix3d pelvis_axes, chest_axes, head_axes;
  std::array<Eigen::Vector3d, 2> shoulder, elbow, wrist, fingertip, hip, knee, ankle, heel, toe;
  std::array<Eigen::Matrix3d, 2> forearm_axes, thigh_axes, shank_axes, foot_axes;
};

/// Forward kinematics. All in body coordinates.
[[nodiscard]] Skeleton skeleton_of(const Pose& pose);

enum class Build { kSlender, kMedium, kStout };

/// Factors on the thickness of trunk and limbs; lengths, head and forearms stay.
struct BuildScale {
  double trunk = 1;
  double limb = 1;
};
[[nodiscard]] BuildScale scale_of(Build build);

/// A prolate ellipsoid: half axes (thickness, length, thickness) along the columns of `axes`.
struct Ellipsoid {
  std::string_view part;  ///< "head", "chest", "left_forearm", ...
  Eigen::Vector3d centre;
  Eigen::Matrix3d axes;  ///< Orthonormal; the second column runs along the limb.
  Eigen::Vector3d half;  ///< Half lengths along the columns; half.x() == half.z() <= half.y().
};

/// The figure as 14 ellipsoids: head, neck, chest, pelvis, then upper arm, forearm (with hand), thigh, shank and foot,
/// left before right. In body coordinates, units of H.
[[nodiscard]] std::vector<Ellipsoid> ellipsoids_of(const Pose& pose, Build build = Build::kMedium);

}  // namespace choreo::body

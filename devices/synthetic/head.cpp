// SPDX-License-Identifier: Apache-2.0
#include "devices/synthetic/head.hpp"

#include <algorithm>
#include <cmath>

namespace choreo::devices::synthetic {
namespace {

// From chin (0) to crown (1), in units of the body's height: a jaw, cheeks a tenth wide, a round skull.
const Profile kFace = {{0, 0.004},     {0.015, 0.0125}, {0.05, 0.0205}, {0.12, 0.0300}, {0.22, 0.0385},
                       {0.34, 0.0445}, {0.48, 0.0480},  {0.62, 0.0485}, {0.75, 0.0455}, {0.86, 0.0380},
                       {0.94, 0.0265}, {0.98, 0.0160},  {1, 0.002}};
const Profile kCap = {{0, 0.0465},    {0.3, 0.0512},  {0.55, 0.0500},  {0.75, 0.0435},
                      {0.88, 0.0330}, {0.95, 0.0225}, {0.985, 0.0130}, {1, 0.002}};
const Profile kBob = {{0, 0.045},     {0.1, 0.0575},  {0.3, 0.0590},  {0.6, 0.0555}, {0.78, 0.0470},
                      {0.90, 0.0340}, {0.96, 0.0230}, {0.99, 0.0120}, {1.0, 0.002}};
const Profile kBall = {{0, 0.010}, {0.1, 0.017}, {0.3, 0.0235}, {0.5, 0.025}, {0.7, 0.0235}, {0.9, 0.017}, {1, 0.010}};
const Profile kEar = {{0, 0.0045}, {0.5, 0.0085}, {1, 0.0055}};

bool inside(double x, double y, double centre_x, double centre_y, double half_width, double half_height) {
  const double u = (x - centre_x) / half_width;
  const double v = (y - centre_y) / half_height;
  return u * u + v * v <= 1;
}

// 1 at the centre of an ellipse, 0 at its edge and outside.
double nearness(double x, double y, double centre_x, double centre_y, double half_width, double half_height) {
  const double u = (x - centre_x) / half_width;
  const double v = (y - centre_y) / half_height;
  return std::max(0.0, 1 - u * u - v * v);
}

cv::Vec3f mixed_colour(const cv::Vec3f& a, const cv::Vec3f& b, double share) {
  const auto s = static_cast<float>(std::min(share, 1.0));
  return a * (1 - s) + b * s;
}

// Colours of one face, so that they are mixed once and not for every sample.
struct FacePaint {
  explicit FacePaint(const Look& look)
      : skin(look.skin),
        hair(look.hair),
        iris(mixed_colour(look.hair, {24, 20, 18}, 0.6)),
        brow(mixed_colour(look.skin, mixed_colour(look.hair, {20, 18, 18}, 0.6), 0.88)),
        lid(mixed_colour(look.skin, {16, 14, 16}, 0.85)),
        lips(mixed_colour(look.skin, {72, 62, 168}, 0.50)),
        mouth(mixed_colour(look.skin, {34, 22, 70}, 0.8)) {
    // Dark skin shows its relief by highlights where light skin shows it by shadows.
    const double dark = 1 - (0.114 * skin[0] + 0.587 * skin[1] + 0.299 * skin[2]) / 255;
    white = mixed_colour(skin, {236, 240, 242}, 0.86 - 0.45 * dark);
    const cv::Vec3f lit = skin * 2.0F;  // of the skin's own hue
    cheek = mixed_colour(mixed_colour(skin, {110, 104, 222}, 0.09), lit, 0.42 * dark * dark);
    bridge = mixed_colour(mixed_colour(skin, {235, 242, 250}, 0.12), lit, 0.35 * dark * dark);
    brightened = mixed_colour(skin, lit, 0.35 * dark * dark);
    socket = skin * static_cast<float>(0.86 - 0.16 * dark);
    shadow = skin * 0.74F;
  }
  cv::Vec3f skin, hair, white, iris, brow, lid, lips, mouth, cheek, socket, shadow, bridge, brightened;
};

// The face's colour at x (signed, positive to the performer's left) and y (from the head's middle, up), in units of
// the body's height. Features lie in the order in which they cover one another.
cv::Vec3f face_colour(const FacePaint& p, double x, double y) {
  const double ax = std::abs(x);
  if (inside(ax, y, 0.0200, 0.0195, 0.0115, 0.0026 + 0.05 * std::max(0.0, 0.02 - ax))) return p.brow;
  if (inside(ax, y, 0.0200, 0.0060, 0.0046, 0.0048)) {
    return inside(x, y, x > 0 ? 0.0215 : -0.0185, 0.0078, 0.0013, 0.0014) ? p.white : p.iris;
  }
  if (inside(ax, y, 0.0200, 0.0060, 0.0098, 0.0054)) return y > 0.0092 ? p.lid : p.white;
  if (inside(ax, y, 0.0200, 0.0072, 0.0112, 0.0066) && y > 0.0060) return p.lid;
  // A smile: the mouth's line is a shallow curve, lips above and below it.
  const double smile = -0.0335 + 9.0 * x * x;
  if (ax < 0.0165) {
    const double open = 0.0016 * (1 - (ax / 0.0165) * (ax / 0.0165));
    if (std::abs(y - smile) < open + 0.0005) return p.mouth;
    if (std::abs(y - smile) < 0.0045 * (1 - (ax / 0.0165) * (ax / 0.0165))) return p.lips;
  }
  if (inside(ax, y, 0.0055, -0.0175, 0.0026, 0.0016)) return p.mouth;
  if (inside(x, y, 0, -0.0195, 0.0095, 0.0022)) return p.shadow;
  if (inside(x, y, 0, -0.0130, 0.0062, 0.0070)) return p.bridge;
  if (ax < 0.0032 && y > -0.014 && y < 0.016) return p.bridge;
  if (inside(x, y, 0, -0.0415, 0.0085, 0.0018)) return p.shadow;
  // The face's relief, without edges.
  auto colour = mixed_colour(p.skin, p.socket, 1.4 * nearness(ax, y, 0.0195, 0.0085, 0.0175, 0.0145));
  colour = mixed_colour(colour, p.cheek, 1.2 * nearness(ax, y, 0.0240, -0.0150, 0.0190, 0.0150));
  return mixed_colour(colour, p.brightened, 1.2 * nearness(x, y, 0, 0.0300, 0.0290, 0.0130));
}

}  // namespace

void draw_head(Brush& brush, cv::Point2d chin, cv::Point2d crown, const Eigen::Matrix3d& axes, double unit,
               const Look& look, unsigned char face_mark) {
  using body::vitruvian::kHeadHeight;
  const cv::Point2d up = crown - chin;
  const double yaw = std::atan2(axes(0, 2), axes(2, 2));
  const cv::Point2d right(-up.y / unit, up.x / unit);  // of the picture, one head high, in units of the height
  const auto place = [&](double share, double aside) {
    return chin + share * up + right * (aside / kHeadHeight) * unit;
  };
  const FacePaint paint(look);

  // The back of the hair; a knot sits on the crown's far side and shows above it.
  const double turn = std::sin(yaw);
  if (look.hair_style == HairStyle::kBob) {
    brush.draw({place(0.10, -0.012 * turn), place(1.0, 0), &kBob, unit, false, false, look.hair, 0.82});
  } else if (look.hair_style == HairStyle::kBun) {
    brush.draw({place(0.72, -0.045 * turn), place(1.08, -0.045 * turn), &kBall, unit, true, true, look.hair, 0.9});
    brush.draw({place(0.45, -0.006 * turn), place(1.0, 0), &kCap, unit, true, false, look.hair});
  } else {
    brush.draw({place(0.40, -0.006 * turn), place(1.0, 0), &kCap, unit, true, false, look.hair});
  }
  for (const double side : {1.0, -1.0}) {
    // An ear shows while it is not on the far side.
    if (side * turn > 0.5) continue;
    const double aside = side * 0.0475 * std::cos(yaw);
    if (look.hair_style != HairStyle::kBob) {
      brush.draw({place(0.36, aside * 0.97), place(0.56, aside * 1.02), &kEar, unit, true, true, look.skin, 0.9});
    }
  }
  const Stroke skull{place(0, 0), place(0.985, 0), &kFace, unit, false, false, look.skin};
  const cv::Point2d across = right * (1 / std::max(1e-9, std::hypot(right.x, right.y)));
  brush.mark(face_mark);
  brush.draw(skull, [&](double s, double share) {
    // The side of a stroke that runs upwards is the picture's right; longitude is counted to the performer's left.
    const double lateral = std::clamp(s, -1.0, 1.0);
    const double longitude = std::asin(lateral) - yaw;
    const double y = (share * 0.985 - 0.5) * kHeadHeight;
    const double x = std::sin(longitude) * 0.0475;
    const bool front = std::cos(longitude) > 0;
    const double light = light_on(across, lateral);
    // Hairline: high over the brow, down at the temples, the whole back of the head.
    const double hairline = 0.0385 - 16.0 * x * x * (look.hair_style == HairStyle::kBob ? 1.5 : 1.0);
    const double sideburn = look.hair_style == HairStyle::kBob ? -0.030 : -0.002;
    const bool hair = (front && (y > hairline || (std::abs(x) > 0.0440 && y > sideburn))) || (!front && y > -0.035);
    if (hair) return paint.hair * (light * (0.94 + 0.10 * std::sin(x * 900)));
    if (!front) return paint.skin * light;
    return face_colour(paint, x, y) * light;
  });
  brush.mark(1);
}

cv::Rect2d face_box(cv::Point2d chin, cv::Point2d crown, const Eigen::Matrix3d& axes, double unit) {
  using body::vitruvian::kHeadHeight;
  constexpr double kCheek = 0.0485, kHairline = 0.0385;  // as drawn: half the width, and above the head's middle
  if (axes(2, 2) <= 0) return {};
  const double length = std::max(1e-9, std::hypot(crown.x - chin.x, crown.y - chin.y));
  const cv::Point2d up = (crown - chin) / length;
  const cv::Point2d right(-up.y, up.x);
  const double yaw = std::atan2(axes(0, 2), axes(2, 2));
  // Turned to the performer's left, the face reaches the skull's rim there and ends before it on the other side.
  const double towards = kCheek * unit;
  const double away = kCheek * unit * std::cos(yaw);
  const double middle = (yaw > 0 ? 1 : -1) * (towards - away) / 2;
  const double half_width = (towards + away) / 2;
  const double top = length * (0.5 + kHairline / kHeadHeight);
  const cv::Point2d centre = chin + up * (top / 2) + right * middle;
  const double half_x = std::hypot(half_width * right.x, top / 2 * up.x);
  const double half_y = std::hypot(half_width * right.y, top / 2 * up.y);
  return {centre.x - half_x, centre.y - half_y, 2 * half_x, 2 * half_y};
}

}  // namespace choreo::devices::synthetic

// SPDX-License-Identifier: Apache-2.0
// Draws everything kFine times as large, with a picture of labels beside it, and reduces both: soft edges, exact truth.
#include "support/flat_performer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "body/semaphore_signs.hpp"

namespace choreo::test {
namespace {

using Point = cv::Point2d;
using Polygon = std::vector<Point>;

constexpr int kFine = 4;
constexpr uchar kBody = 1, kHeld = 2;
constexpr double kWalkSeconds = 3;

cv::Scalar rgb(double red, double green, double blue) { return {blue, green, red}; }
double smooth(double x) { return x <= 0 ? 0 : x >= 1 ? 1 : x * x * (3 - 2 * x); }
double wave(double cycles) { return std::sin(2 * std::numbers::pi * cycles); }
/// Unit vector, degrees from straight down towards the picture's right.
Point heading(double degrees) {
  const double a = degrees * std::numbers::pi / 180;
  return {std::sin(a), -std::cos(a)};
}
Point turned(Point p, double degrees) {  // Clockwise as seen, where y points up.
  const Point down = heading(-degrees);
  return {-p.x * down.y - p.y * down.x, p.x * down.x - p.y * down.y};
}

Polygon oval(Point centre, double rx, double ry, double from = 0, double to = 360) {
  Polygon points;
  for (int k = 0; k <= 36; ++k) {
    const Point h = heading(from + (to - from) * k / 36 + 90);
    points.emplace_back(centre.x + rx * h.x, centre.y + ry * h.y);
  }
  return points;
}

/// Two discs and what lies between them.
Polygon limb(Point a, double radius_a, Point b, double radius_b) {
  const Point along = b - a;
  const double towards = std::atan2(along.x, -along.y) * 180 / std::numbers::pi;
  Polygon points = oval(a, radius_a, radius_a, towards, towards + 180);
  for (const Point& p : oval(b, radius_b, radius_b, towards + 180, towards + 360)) points.push_back(p);
  return points;
}

Polygon box(double left, double top, double right, double bottom) {
  return {{left, top}, {right, top}, {right, bottom}, {left, bottom}};
}

/// Fills polygons given in coordinates of its own; marks what it drew where there is a picture of labels.
struct Brush {
  cv::Mat picture, labels;
  Point origin, unit;  // In pixels of the fine picture.
  double outline = 0;  // Its width, in units.

  [[nodiscard]] Brush without_outline() const { return {picture, labels, origin, unit}; }

  /// Polygons that belong together have one outline around them all.
  /// @param round  units by which everything grows, its corners round.
  void paint(const std::vector<Polygon>& shapes, const cv::Scalar& colour, double round = 0,
             uchar label = kBody) const {
    std::vector<std::vector<cv::Point>> fixed;
    for (const auto& shape : shapes) {
      auto& points = fixed.emplace_back();
      for (const Point& p : shape) {
        points.emplace_back(cvRound((origin.x + p.x * unit.x) * 16), cvRound((origin.y + p.y * unit.y) * 16));
      }
    }
    const auto fill = [&](cv::Mat image, const cv::Scalar& value, double radius) {
      const int thickness = cvRound(2 * radius * unit.x);
      for (const auto& points : fixed) {
        cv::fillPoly(image, std::vector{points}, value, cv::LINE_8, 4);
        if (thickness > 0) cv::polylines(image, std::vector{points}, true, value, thickness, cv::LINE_8, 4);
      }
    };
    if (outline > 0) fill(picture, colour * 0.4, round + outline);
    fill(picture, colour, round);
    if (!labels.empty()) fill(labels, cv::Scalar(label), round + outline);
  }
};

// ---- The room: in widths and heights of the picture, from its top left corner.

cv::Scalar wall_colour(unsigned seed) {
  const std::array walls{rgb(176, 196, 178), rgb(172, 188, 208), rgb(206, 196, 170)};
  return walls[seed % walls.size()];
}

/// A wooden chair seen from the front, in units of the performer's height.
void paint_chair(const Brush& brush, double x, double y) {
  const auto wood = rgb(196, 138, 92), seat = rgb(214, 158, 110), dark = rgb(158, 106, 68);
  for (const double side : {-0.095, 0.07}) brush.paint({box(x + side, y + 0.56, x + side + 0.025, y)}, dark);
  for (const double bar : {0.36, 0.45}) brush.paint({box(x - 0.08, y + bar + 0.06, x + 0.08, y + bar)}, wood);
  for (const double side : {-0.12, 0.09}) brush.paint({box(x + side, y + 0.28, x + side + 0.03, y - 0.03)}, wood);
  brush.paint({{{x - 0.1, y + 0.3}, {x + 0.1, y + 0.3}, {x + 0.13, y + 0.25}, {x - 0.13, y + 0.25}}}, seat);
  brush.paint({box(x - 0.13, y + 0.25, x + 0.13, y + 0.22)}, wood);
}

void paint_room(const Brush& brush, const cv::Scalar& wall) {
  const auto white = rgb(238, 236, 228), beige = rgb(222, 190, 158), board = rgb(150, 128, 112);
  brush.paint({box(0, 0, 1, 0.8)}, wall);
  brush.paint({box(0, 0.8, 1, 1)}, board);
  for (const double y : {0.835, 0.89, 0.96}) brush.paint({box(0, y, 1, y + 0.003)}, board * 0.86);
  brush.paint({box(0, 0.77, 1, 0.8)}, white);
  // The cupboard.
  brush.paint({box(0.03, 0.26, 0.2, 0.83)}, beige * 0.84);
  for (const double x : {0.037, 0.118}) {
    brush.paint({box(x, 0.275, x + 0.075, 0.6)}, beige);
    brush.paint({box(x, 0.615, x + 0.075, 0.805)}, beige);
  }
  for (const double x : {0.102, 0.123}) brush.paint({box(x, 0.42, x + 0.006, 0.47)}, beige * 0.5);
  // The picture of a pinkish disc.
  brush.paint({box(0.265, 0.15, 0.375, 0.36)}, rgb(120, 78, 50));
  brush.paint({box(0.275, 0.165, 0.365, 0.345)}, rgb(232, 224, 206));
  brush.paint({oval({0.32, 0.25}, 0.033, 0.05)}, rgb(236, 176, 156));
  // The window, its curtains and its sill.
  brush.paint({box(0.66, 0.1, 0.86, 0.47)}, white);
  brush.paint({box(0.672, 0.116, 0.848, 0.454)}, rgb(180, 216, 238));
  brush.paint({{{0.672, 0.454}, {0.672, 0.4}, {0.73, 0.36}, {0.79, 0.41}, {0.848, 0.38}, {0.848, 0.454}}},
              rgb(138, 176, 120));
  brush.paint({box(0.755, 0.11, 0.765, 0.46)}, white);
  brush.paint({box(0.67, 0.275, 0.85, 0.287)}, white);
  brush.paint({{{0.64, 0.08}, {0.7, 0.08}, {0.69, 0.3}, {0.66, 0.52}, {0.64, 0.52}}}, rgb(204, 120, 104));
  brush.paint({{{0.88, 0.08}, {0.82, 0.08}, {0.83, 0.3}, {0.86, 0.52}, {0.88, 0.52}}}, rgb(204, 120, 104));
  brush.paint({box(0.63, 0.07, 0.89, 0.085)}, board * 0.7);
}

// ---- The movement: in units of the performer's height, x to the picture's right, y up from the floor.

constexpr double kThigh = 0.205, kShank = 0.2, kUpperArm = 0.15, kForearm = 0.145, kAnkle = 0.035;
constexpr double kSignalBegins = 1, kOnTheWay = 1, kLetter = 2.5;  // Seconds.
constexpr double kStance = 0.065, kHip = 0.052, kTrunk = 0.335;

struct Pose {
  double x = 0;                                    // Of the pelvis.
  double lean = 0, tilt = 0, face = 0;             // Degrees of trunk and head; where it looks, -1 to 1: left to right.
  double breath = 0;                               // By which shoulders and head rise.
  double dip = 0;                                  // By which the pelvis sinks.
  std::array<double, 2> arm{9, 9}, elbow{10, 10};  // Degrees outwards; at the picture's left, right.
  std::array<Point, 2> foot{{{-kStance, 0}, {kStance, 0}}};  // Its sole.
};

// Where an arm points, degrees outwards of its own side; beyond up and down it reaches across.
double outwards(std::string_view sign, std::size_t side) {
  const auto shown = body::semaphore(sign).value();
  const int position = side == 0 ? shown.right : body::mirrored_position(shown.left);
  return 45.0 * (position <= 4 ? position : position - 8);
}

// Both arms at a letter, or at rest.
Pose letter_pose(const FlatScene& scene, std::size_t k, Pose pose) {
  if (k >= scene.text.size()) return pose;
  for (std::size_t side = 0; side < 2; ++side) {
    const double points = outwards(std::string_view(scene.text).substr(k, 1), side);
    if (points == 0) continue;
    // The forearm's direction is off by a third of what the elbow is bent.
    const double bend = scene.bend * ((k + side) % 2 == 0 ? 1 : -1);
    pose.elbow[side] = bend;
    pose.arm[side] = points - bend * 2 / 3;
  }
  return pose;
}

Pose signalling(const FlatScene& scene, double since, const Pose& rest) {
  const double at = std::max(0.0, since - kSignalBegins) / kLetter;
  const auto k = std::size_t(at);
  const double way = smooth((at - double(k)) * kLetter / kOnTheWay);
  const auto from = k == 0 ? rest : letter_pose(scene, k - 1, rest), to = letter_pose(scene, k, rest);
  Pose pose = since < kSignalBegins ? rest : to;
  for (std::size_t side = 0; side < 2 && since >= kSignalBegins; ++side) {
    pose.arm[side] = from.arm[side] + way * (to.arm[side] - from.arm[side]);
    pose.elbow[side] = from.elbow[side] + way * (to.elbow[side] - from.elbow[side]);
  }
  return pose;
}

/// @param away  from the middle of the room to where nothing of the performer is in the picture.
Pose pose_at(const FlatScene& scene, double away, double time) {
  Pose pose;
  // About a pixel at 640x480.
  pose.breath = 0.0032 * wave(time / 4);
  const double walked = scene.empty_s > 0 ? (time - scene.empty_s) / kWalkSeconds : 1;
  if (walked < 1) {
    constexpr double kStride = 0.4;
    pose.x = -away * (1 - walked) * (1 - walked);
    pose.face = smooth((1 - walked) * 5);
    for (std::size_t side = 0; side < 2; ++side) {
      const double phase = pose.x / kStride + 0.5 * double(side), part = phase - std::floor(phase);
      const double step = smooth(2 * part - 0.5);  // A foot stands for half of the stride.
      pose.foot[side].x += pose.x + pose.face * kStride * (step - part);
      pose.foot[side].y = pose.face * 0.16 * step * (1 - step);
      pose.arm[side] += pose.face * 9 * (1 + wave(phase + 0.25));
    }
    return pose;
  }
  const double since = scene.empty_s > 0 ? time - scene.empty_s - kWalkSeconds : time;
  const double amount = scene.empty_s > 0 ? smooth(since / 1.5) : 1;
  if (scene.script == "dance") {
    const double beat = since * (0.9 + 0.06 * (scene.seed % 5)), own = 0.37 * (scene.seed % 7);
    // One step to the left and back every eight beats; the foot on that side goes first.
    const double bar = beat - 8 * std::floor(beat / 8);
    for (std::size_t side = 0; side < 2; ++side) {
      const double late = 0.8 * double(side);
      const double out = smooth(bar - 2 - late), back = smooth(bar - 6.8 + late);
      pose.foot[side].x -= 0.2 * (out - back);
      pose.foot[side].y = 0.2 * (out * (1 - out) + back * (1 - back));
      pose.x += pose.foot[side].x / 2;
      const double phase = own + 0.3 * double(side);
      pose.arm[side] += amount * (61 + 36 * wave(beat / 4 + phase) + 22 * wave(beat / 7 + own));
      pose.elbow[side] += amount * (28 + 32 * wave(beat / 2 + phase));
    }
    const double sway = wave(beat / 2);
    pose.x += amount * 0.035 * sway;
    pose.dip = amount * 0.007 * (1 + wave(beat));
    pose.lean = amount * 5 * sway;
    pose.tilt = amount * 7 * wave(beat / 2 + 0.1);
    pose.face = amount * 0.4 * wave(beat / 6);
  } else if (scene.script == "signal") {
    return signalling(scene, since, pose);
  } else if (scene.script == "wave") {
    for (std::size_t side = 0; side < 2; ++side) {
      const double up = amount * smooth(1.5 * wave(since / 8 + 0.5 * double(1 - side)) + 0.5);
      pose.arm[side] += up * (116 + 8 * wave(since * 0.6));
      pose.elbow[side] += up * (22 + 28 * wave(since * 1.1));
    }
  }
  return pose;
}

// ---- The performer.

struct Outfit {
  cv::Scalar skin, hair, top, sleeve, bottom, shoes;
  double outline = 0;
};

Outfit outfit_of(const FlatScene& scene) {
  if (scene.look == 0) {
    const auto shirt = rgb(206, 66, 58);
    return {rgb(238, 190, 154), rgb(96, 60, 38), shirt, shirt, rgb(54, 78, 128), rgb(236, 236, 232), 0.0035};
  }
  if (scene.look == 1) {
    return {rgb(116, 74, 50),  rgb(34, 26, 28),   rgb(232, 168, 52),
            rgb(240, 182, 72), rgb(232, 168, 52), rgb(150, 44, 62)};
  }
  const auto jacket = wall_colour(scene.seed) * 0.9;
  return {rgb(226, 174, 138), rgb(150, 76, 42), jacket, jacket * 0.94, rgb(74, 64, 72), rgb(44, 38, 40)};
}

/// @param at  from the head's centre, 1 its half width and half height, to the figure's coordinates.
template <typename At>
void paint_head(const Brush& brush, const Outfit& outfit, int look, double face, const At& at) {
  const auto placed = [&](Polygon points) {
    for (Point& p : points) p = at(p);
    return points;
  };
  const auto ink = rgb(44, 34, 36);
  for (const double side : {-1, 1}) {
    if (look != 1) brush.paint({placed(oval({side - 0.2 * face, -0.1}, 0.16, 0.2))}, outfit.skin);
  }
  brush.paint({placed(oval({0, 0}, 1, 1))}, outfit.skin);
  const Brush plain = brush.without_outline();
  const double turn = 0.3 * face;
  for (const double side : {-0.38, 0.38}) {
    plain.paint({placed(oval({side + turn, -0.02}, 0.17, 0.17))}, rgb(250, 250, 246));
    plain.paint({placed(oval({side + 1.3 * turn, -0.03}, 0.09, 0.12))}, ink);
    plain.paint({placed(box(side + turn - 0.18, 0.28, side + turn + 0.18, 0.22))}, outfit.hair * 0.8);
  }
  plain.paint({placed(limb({1.2 * turn, -0.2}, 0.05, {1.4 * turn, -0.3}, 0.08))}, outfit.skin * 0.86);
  plain.paint({placed(oval({turn, -0.48}, 0.3, 0.19, 180, 360))}, rgb(164, 52, 56));
  // The hair's front: over the skull, back along the hairline.
  Polygon cap = oval({0, 0.02}, 1.08, 1.08, 188, -8);
  for (const Point p : {Point(0.93, 0.2), {0.7, 0.42}, {0.25, 0.52}, {-0.3, 0.6}, {-0.75, 0.36}, {-0.93, 0.2}}) {
    cap.emplace_back(p.x + 0.5 * turn * (1 - p.x * p.x), p.y);
  }
  brush.paint({placed(cap)}, outfit.hair);
}

void paint_performer(const Brush& brush, const Outfit& outfit, int look, const Pose& pose) {
  const bool dress = look == 1, jacket = look == 2;
  const Brush plain = brush.without_outline();
  // Straight legs hold the pelvis up; spread ones let it down.
  double height = kAnkle + 0.997 * (kThigh + kShank);
  std::array<Point, 2> hip, knee, ankle;
  for (std::size_t side = 0; side < 2; ++side) {
    ankle[side] = pose.foot[side] + Point(0, kAnkle);
    const double across = pose.x + kHip * (side == 0 ? -1 : 1) - ankle[side].x;
    height = std::min(height, ankle[side].y + std::sqrt(std::max(0.0, 0.163 - across * across)));
  }
  const Point pelvis(pose.x, height - pose.dip);
  const auto trunk = [&](double x, double up) { return pelvis + turned({x, up * (kTrunk + pose.breath)}, pose.lean); };
  const Point skull = trunk(0, 1) + turned({0, 0.135}, pose.lean + pose.tilt);
  const auto head = [&](Point p) { return skull + turned({p.x * 0.08, p.y * 0.092}, pose.lean + pose.tilt); };

  if (dress) brush.paint({limb(head({0, 0.05}), 0.096, trunk(0, 0.72), 0.088)}, outfit.hair);
  if (jacket) brush.paint({oval(head({0, 1.2}), 0.042, 0.038)}, outfit.hair);
  for (std::size_t side = 0; side < 2; ++side) {
    const double out = side == 0 ? -1 : 1;
    hip[side] = pelvis + Point(kHip * out, 0);
    const Point reach = ankle[side] - hip[side];
    const double far = std::min(std::hypot(reach.x, reach.y), 0.9999 * (kThigh + kShank));
    const double bend = std::acos((kThigh * kThigh + far * far - kShank * kShank) / (2 * kThigh * far));
    const double down = std::atan2(reach.x, -reach.y);
    knee[side] = hip[side] + kThigh * heading((down + out * bend) * 180 / std::numbers::pi);
    const double toe = out + (1 - out) * std::clamp(pose.face - 0.4, 0.0, 0.6) / 0.6;
    brush.paint({limb(ankle[side] + Point(0, -0.008), 0.027, ankle[side] + Point(0.038 * toe, -0.013), 0.022)},
                outfit.shoes);
    const double slim = dress ? 0.6 : 1;
    brush.paint({limb(hip[side], 0.058 * slim, knee[side], 0.045 * slim),
                 limb(knee[side], 0.045 * slim, ankle[side] + Point(0, 0.008), 0.036 * slim)},
                dress ? outfit.skin : outfit.bottom);
  }
  if (!dress) plain.paint({{trunk(-0.05, 0.2), trunk(0.05, 0.2), hip[1], hip[0]}}, outfit.bottom, 0.035);
  brush.paint({limb(trunk(0, 0.95), 0.032, skull, 0.03)}, outfit.skin);
  Polygon top{trunk(-0.035, 1), trunk(0.035, 1), trunk(0.07, 0.94), trunk(0.055, 0.5)};
  if (dress) {
    const double hem = std::min(knee[0].y, knee[1].y) - 0.015;
    top.emplace_back(std::max(knee[1].x + 0.05, pelvis.x + 0.14), hem);
    top.emplace_back(std::min(knee[0].x - 0.05, pelvis.x - 0.14), hem);
  } else {
    const double wide = jacket ? 0.1 : 0.075, low = jacket ? -0.12 : 0.06;
    for (const double x : {wide, -wide}) top.push_back(trunk(x, low));
  }
  for (const double up : {0.5, 0.94}) top.push_back(trunk(up < 0.9 ? -0.055 : -0.07, up));
  brush.paint({top}, outfit.top, 0.02);
  if (dress) brush.paint({limb(trunk(-0.06, 0.35), 0.016, trunk(0.06, 0.35), 0.016)}, outfit.shoes);
  if (jacket) brush.paint({{trunk(-0.03, 1.03), trunk(0.03, 1.03), trunk(0, 0.45)}}, rgb(244, 242, 236));
  paint_head(brush, outfit, look, pose.face, head);

  for (std::size_t side = 0; side < 2; ++side) {
    const double out = side == 0 ? -1 : 1;
    const Point shoulder = trunk(0.07 * out, 0.92);
    const Point upper = heading(out * pose.arm[side] + pose.lean);
    const Point fore = heading(out * (pose.arm[side] + pose.elbow[side]) + pose.lean);
    const Point elbow = shoulder + kUpperArm * upper, wrist = elbow + kForearm * fore, hand = wrist + 0.03 * fore;
    if (look == 0) {
      brush.paint({limb(shoulder, 0.03, elbow, 0.027), limb(elbow, 0.027, wrist, 0.022)}, outfit.skin);
      brush.paint({limb(shoulder, 0.04, shoulder + 0.09 * upper, 0.042)}, outfit.sleeve);
      plain.paint({limb(shoulder, 0.038, trunk(0.02 * out, 0.84), 0.04)},
                  outfit.top);  // No outline between trunk and sleeve.
    }
    if (jacket) {
      const Point across = turned(fore, -90 * out);
      const auto cloth = [&](double along, double away) { return hand + along * fore + away * across; };
      brush.paint({limb(cloth(-0.03, 0), 0.007, cloth(0.23, 0), 0.007)}, rgb(120, 84, 56), 0, kHeld);
      brush.paint({{cloth(0.07, 0), cloth(0.22, 0), cloth(0.22, 0.15), cloth(0.07, 0.15)}}, rgb(244, 206, 60), 0,
                  kHeld);
      brush.paint({{cloth(0.22, 0), cloth(0.22, 0.15), cloth(0.07, 0.15)}}, rgb(204, 48, 44), 0, kHeld);
    }
    brush.paint({limb(wrist, 0.023, hand, 0.03)}, outfit.skin);
    if (jacket) brush.paint({limb(shoulder, 0.042, elbow, 0.036), limb(elbow, 0.036, wrist, 0.032)}, outfit.sleeve);
    if (dress) {
      const Point across = turned(fore, 90);
      brush.paint({limb(shoulder, 0.036, elbow, 0.045),
                   {elbow - 0.045 * across, elbow + 0.045 * across, wrist + 0.075 * across, wrist - 0.075 * across}},
                  outfit.sleeve);
    }
  }
}

Brush stage_brush(const FlatScene& scene, const cv::Mat& picture) {
  const double height = kFine * std::min(0.66 * scene.size.height, 0.5 * scene.size.width);
  return {picture, {}, Point(0.5 * picture.cols, 0.93 * picture.rows), Point(height, -height)};
}

}  // namespace

double seconds_of_text(const std::string& text) { return kSignalBegins + kLetter * double(text.size() + 1); }

FlatPerformer::FlatPerformer(FlatScene scene) : scene_(std::move(scene)) {
  const bool known =
      scene_.script == "dance" || scene_.script == "wave" || scene_.script == "stand" || scene_.script == "signal";
  if (!known || scene_.look < 0 || scene_.look > 2) throw std::invalid_argument("no such flat performer");
  room_.create(scene_.size * kFine, CV_8UC3);
  paint_room({room_, {}, {}, Point(room_.cols, room_.rows)}, wall_colour(scene_.seed));
  const Brush stage = stage_brush(scene_, room_);
  const double edge = stage.origin.x / stage.unit.x;
  paint_chair(stage, -0.46 * edge, 0.1);
  room_with_chair_ = room_.clone();
  paint_chair(stage_brush(scene_, room_with_chair_), 0.84 * edge, 0.02);
  // Brightest at the window.
  light_.create(scene_.size, CV_32FC3);
  for (int y = 0; y < light_.rows; ++y) {
    for (int x = 0; x < light_.cols; ++x) {
      const double off = std::hypot(double(x) / light_.cols - 0.76, double(y) / light_.rows - 0.28);
      light_.at<cv::Vec3f>(y, x) = cv::Vec3f::all(float(1.06 - 0.24 * off));
    }
  }
}

FlatFrame FlatPerformer::frame(double time_s) const {
  const bool chair = scene_.chair_at_s >= 0 && time_s >= scene_.chair_at_s;
  const cv::Mat fine = (chair ? room_with_chair_ : room_).clone();
  Brush brush = stage_brush(scene_, fine);
  brush.labels = cv::Mat::zeros(fine.size(), CV_8UC1);
  const Outfit outfit = outfit_of(scene_);
  brush.outline = outfit.outline;
  const double away = brush.origin.x / brush.unit.x + 0.45;
  if (time_s >= scene_.empty_s) paint_performer(brush, outfit, scene_.look, pose_at(scene_, away, time_s));

  const auto mostly = [&](uchar label) {
    cv::Mat share;
    cv::resize(brush.labels == label, share, scene_.size, 0, 0, cv::INTER_AREA);
    return cv::Mat(share > 120);  // Half is 128, one of 16 samples less 112.
  };
  FlatFrame result{{}, mostly(kBody), mostly(kHeld)};
  cv::Mat clear, noise(scene_.size, CV_32FC3);
  cv::resize(fine, clear, scene_.size, 0, 0, cv::INTER_AREA);
  clear.convertTo(clear, CV_32F);
  const auto moment = std::uint64_t(std::llround(time_s * 1e6));
  cv::RNG chance((moment + 1) * 0x9e3779b97f4a7c15ULL ^ (scene_.seed + 1) * 0xbf58476d1ce4e5b9ULL);
  chance.fill(noise, cv::RNG::NORMAL, 0, 2);
  cv::Mat(clear.mul(light_) + noise).convertTo(result.picture, CV_8U);
  return result;
}

}  // namespace choreo::test

// SPDX-License-Identifier: Apache-2.0
#include "recognition/sign_cover.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "body/figure.hpp"

namespace choreo::recognition {
namespace {

namespace v = body::vitruvian;

// Lengths in face widths.
constexpr double kFace = v::kFaceWidth;
constexpr double kFaceHeight = 1 - 1.0 / 40 - 1.0 / 20;  // Of the face's middle: the hairline is at H/40 [Vitruvius].
constexpr double kBelow = (kFaceHeight - v::kShoulderHeight) / kFace;
constexpr double kWhole = (v::kUpperArm + v::kForearm) / kFace;
constexpr double kForearm = v::kForearm / kFace;
constexpr double kForearmArea = kForearm * v::kForearmWidth / kFace;

constexpr int kScale = 12;      // Pixels of a face width in the copy that is looked at.
constexpr double kAside = 6.2;  // From the face's middle, what is looked at of arms that reach as far as kWhole.
constexpr double kUp = 5.2;
constexpr double kDown = 6.2;  // Hanging arms and a taller body than the face says.
constexpr double kFar = 4.7;   // From the shoulder.
constexpr int kTurns = 72;     // Directions.
constexpr int kTurnSteps = 4;  // Off the sign's direction, to either side: 20 degrees.

constexpr float kLeastShown = 0.6F;  // Of a bar.

constexpr std::array<double, 3> kSizes = {0.86, 1, 1.16};
constexpr std::array<double, 3> kAsideShifts = {-0.35, 0, 0.35};
constexpr std::array<double, 3> kDownShifts = {-0.3, 0.05, 0.4};
constexpr std::array<double, 3> kStarts = {-0.35, 0, 0.35};   // Middle of the upper arm, elbow, a sleeve beyond it.
constexpr std::array<double, 3> kShortened = {0.85, 0.4, 0};  // Towards the camera, or away.

double penalty(double by, double deviation) { return -0.5 * (by / deviation) * (by / deviation); }

cv::Point2d direction_of(double turns) {
  const double angle = 2 * std::numbers::pi * turns;
  return {-std::sin(angle), std::cos(angle)};
}

// The lengths of the bars that are laid.
struct BarLengths {
  std::array<double, 3> from{}, tip{};  // From the shoulder.
  double width = 0;
  double aside = 0, below = 0;  // The shoulder, from the face's middle.
  double beyond = 0;            // How much farther than a bare arm's what is looked at reaches.
  int radii = 0;                // Pixels from the shoulder.

  explicit BarLengths(const SignCoverOptions& options) {
    const double length = std::min(kForearm, kForearm / kWhole * options.reach);
    for (std::size_t i = 0; i < from.size(); ++i) {
      from[i] = options.reach - length + kStarts[i] * length / kForearm;
      tip[i] = options.reach - kShortened[i] * length / kForearm;
    }
    width = options.typical_arm / length;
    aside = options.shoulder_aside;
    // The usual setting, which is lower than the figure's shoulder, stands for it.
    below = options.shoulder_below + (kBelow - SignCoverOptions{}.shoulder_below);
    beyond = std::max(0.0, kSizes.back() * (options.reach - kWhole) + 0.5 * (width - kForearmArea / kForearm) +
                               std::max(0.0, aside - SignCoverOptions{}.shoulder_aside));
    radii = int((kFar + beyond) * kScale);
  }

  [[nodiscard]] int half_width(double size) const { return std::max(1, cvRound(0.5 * width * size * kScale)); }
  [[nodiscard]] int radius_of(double face_widths, double size) const {
    return std::clamp(cvRound(face_widths * size * kScale), 0, radii);
  }
};

// The picture in a size in which a face is kScale wide: negative where nothing is known, as beyond the border.
struct ScaledCopy {
  cv::Mat seen;  // CV_32FC1
  cv::Point2d face;
  cv::Matx23d picture_from_copy;
  double sum = 0, squares = 0;  // Of what is seen.

  // Whether a place tells anything: not beyond the picture's edge, nor before the face.
  [[nodiscard]] bool tells(int x, int y) const {
    return x >= 0 && y >= 0 && x < seen.cols && y < seen.rows && seen.at<float>(y, x) >= 0;
  }
  [[nodiscard]] cv::Point2d in_picture(cv::Point2d at) const {
    return {picture_from_copy(0, 0) * at.x + picture_from_copy(0, 2),
            picture_from_copy(1, 1) * at.y + picture_from_copy(1, 2)};
  }
};

ScaledCopy scaled_copy(const cv::Mat& evidence, cv::Point2d face_centre, double face_width, double beyond,
                       bool mirrored) {
  ScaledCopy copy;
  const double shrink = kScale / face_width;
  const cv::Size size(2 * int((kAside + beyond) * kScale) + 1, int((kUp + kDown + 2 * beyond) * kScale) + 1);
  copy.face = {double(int((kAside + beyond) * kScale)), double(int((kUp + beyond) * kScale))};
  cv::Mat calm;
  const double blur = std::max(0.0, 0.4 / shrink);
  cv::Mat as_float;
  evidence.convertTo(as_float, CV_32F, 1.0 / 255);
  if (blur > 0.5) {
    cv::GaussianBlur(as_float, calm, {}, blur, blur, cv::BORDER_REPLICATE);
  } else {
    calm = as_float;
  }
  const double flip = mirrored ? -1 : 1;
  copy.picture_from_copy = {flip / shrink,
                            0,
                            face_centre.x - flip * copy.face.x / shrink,
                            0,
                            1 / shrink,
                            face_centre.y - copy.face.y / shrink};
  cv::warpAffine(calm, copy.seen, copy.picture_from_copy, size, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                 cv::BORDER_CONSTANT, cv::Scalar(-1));
  // Skin of face and neck is no arm, and an arm before them tells nothing there.
  cv::ellipse(copy.seen, cv::Point(int(copy.face.x), int(copy.face.y + 0.12 * kScale)),
              cv::Size(int(0.72 * kScale), int(0.95 * kScale)), 0, 0, 360, cv::Scalar(-1), cv::FILLED);
  for (int y = 0; y < copy.seen.rows; ++y) {
    const auto* line = copy.seen.ptr<float>(y);
    for (int x = 0; x < copy.seen.cols; ++x) {
      if (line[x] <= 0) continue;
      copy.squares += double(line[x]) * line[x];
      copy.sum += line[x];
    }
  }
  return copy;
}

// Evidence along an arm: sums over its width, added up from the shoulder outwards.
struct Ray {
  std::vector<float> sum, area;
};

// One way to lay an arm.
struct Bar {
  float sum = 0;
  float area = 0;
  float log_penalty = 0;
  std::int16_t turn = 0;
  std::uint8_t from = 0, tip = 0;
};

// A body: how large it is against its face, and where its shoulders are.
struct Stance {
  double size = 1;
  double log_penalty = 0;
  std::array<cv::Point2d, 2> shoulder;  // The signaller's left, which is on the right, then the right.
};

// Lays the arms of every sign over one picture.
class Covering {
 public:
  Covering(const ScaledCopy& copy, const BarLengths& lengths, bool one_hangs)
      : copy_(copy),
        lengths_(lengths),
        one_hangs_(one_hangs),
        stamps_(cv::Mat::zeros(copy.seen.size(), CV_32S)),
        root_(std::sqrt(copy.squares)) {
    best_.fill(-1);
  }

  // Tries every sign with a body that stands so.
  void try_stance(const Stance& stance) {
    std::array<std::array<std::vector<Bar>, 8>, 2> bars;
    for (std::size_t s = 0; s < 2; ++s) {
      std::vector<Ray> rays;
      for (int t = 0; t < kTurns; ++t) rays.push_back(ray_of(stance, s, double(t) / kTurns));
      for (int position = 0; position < 8; ++position) {
        bars[s][std::size_t(position)] = fullest_bars(rays, stance, position);
      }
    }
    if (one_hangs_) {
      for (auto& shoulders : bars) shoulders[0] = {Bar{}};
    }
    const auto signs = body::semaphore_signs();
    for (std::size_t k = 0; k < signs.size(); ++k) {
      if (one_hangs_ && (signs[k].left == 0) == (signs[k].right == 0)) continue;
      for (const bool swapped : {false, true}) {
        const auto& lefts = bars[0][std::size_t(swapped ? signs[k].right : signs[k].left)];
        const auto& rights = bars[1][std::size_t(swapped ? signs[k].left : signs[k].right)];
        for (const auto& a : lefts) {
          for (const auto& b : rights) try_bars(k, a, b, stance);
        }
      }
    }
  }

  [[nodiscard]] double best(std::size_t sign) const { return best_[sign]; }
  [[nodiscard]] const std::array<CoveringArm, 2>& arms(std::size_t sign) const { return arms_[sign]; }

 private:
  // Calls `visit(r, x, y)` for the places of an arm from `from` to `to` pixels off the shoulder that tell anything.
  template <typename Visit>
  void along_arm(const Stance& stance, std::size_t side, double turns, int from, int to, Visit visit) const {
    const auto along = direction_of(turns);
    const cv::Point2d across(-along.y, along.x);
    const int half = lengths_.half_width(stance.size);
    for (int r = from; r < to; ++r) {
      for (int w = -half; w <= half; ++w) {
        const cv::Point2d at = stance.shoulder[side] + along * (r + 0.5) + across * w;
        const int x = cvRound(at.x);
        const int y = cvRound(at.y);
        if (copy_.tells(x, y)) visit(r, x, y);
      }
    }
  }

  [[nodiscard]] Ray ray_of(const Stance& stance, std::size_t side, double turns) const {
    const auto radii = std::size_t(lengths_.radii);
    Ray ray{std::vector<float>(radii + 1), std::vector<float>(radii + 1)};
    along_arm(stance, side, turns, 0, lengths_.radii, [&](int r, int x, int y) {
      ray.sum[std::size_t(r) + 1] += copy_.seen.at<float>(y, x);
      ray.area[std::size_t(r) + 1] += 1;
    });
    for (std::size_t r = 0; r < radii; ++r) {
      ray.sum[r + 1] += ray.sum[r];
      ray.area[r + 1] += ray.area[r];
    }
    return ray;
  }

  // Of every beginning and end the best bar in a sign's direction: of those with alike areas only the fullest can win.
  [[nodiscard]] std::vector<Bar> fullest_bars(const std::vector<Ray>& rays, const Stance& stance, int position) const {
    std::vector<Bar> bars;
    const float full = 2 * float(lengths_.half_width(stance.size)) + 1;
    for (std::size_t f = 0; f < lengths_.from.size(); ++f) {
      for (std::size_t tip = 0; tip < lengths_.tip.size(); ++tip) {
        const auto from = std::size_t(lengths_.radius_of(lengths_.from[f], stance.size));
        const auto to = std::size_t(lengths_.radius_of(lengths_.tip[tip], stance.size));
        Bar fullest;
        double most = -1;
        for (int off = -kTurnSteps; off <= kTurnSteps; ++off) {
          const int turn = (position * kTurns / 8 + off + kTurns) % kTurns;
          const auto& ray = rays[std::size_t(turn)];
          Bar bar;
          bar.sum = ray.sum[to] - ray.sum[from];
          // What the face hides, or lies beyond the picture, may be there: but an arm that is nowhere to be seen is no
          // explanation.
          bar.area = std::max(ray.area[to] - ray.area[from], kLeastShown * full * float(to - from));
          bar.log_penalty = float(penalty(off * 360.0 / kTurns, 30));
          bar.turn = static_cast<std::int16_t>(turn);
          bar.from = static_cast<std::uint8_t>(f);
          bar.tip = static_cast<std::uint8_t>(tip);
          const double worth = bar.sum * std::exp(bar.log_penalty);
          if (worth > most) {
            most = worth;
            fullest = bar;
          }
        }
        bars.push_back(fullest);
      }
    }
    return bars;
  }

  struct Common {
    float sum = 0, area = 0;
  };

  // What both bars cover.
  [[nodiscard]] Common common(const Bar& a, const Bar& b, const Stance& stance) {
    Common both;
    if (a.area <= 0 || b.area <= 0) return both;
    ++stamp_;
    const auto lay = [&](const Bar& bar, std::size_t side, auto visit) {
      along_arm(stance, side, double(bar.turn) / kTurns, lengths_.radius_of(lengths_.from[bar.from], stance.size),
                lengths_.radius_of(lengths_.tip[bar.tip], stance.size), [&](int, int x, int y) { visit(x, y); });
    };
    lay(a, 0, [&](int x, int y) { stamps_.at<int>(y, x) = stamp_; });
    lay(b, 1, [&](int x, int y) {
      if (stamps_.at<int>(y, x) != stamp_) return;
      both.sum += copy_.seen.at<float>(y, x);
      both.area += 1;
    });
    return both;
  }

  // Takes two bars for a sign's arms where they cover more than what was tried before.
  void try_bars(std::size_t sign, const Bar& a, const Bar& b, const Stance& stance) {
    const double factor = std::exp(stance.log_penalty + a.log_penalty + b.log_penalty) / root_;
    const float area = std::max(1.0F, a.area + b.area);
    if ((a.sum + b.sum) * factor / std::sqrt(area) <= best_[sign]) return;
    // What both bars cover counts once.
    const auto twice = common(a, b, stance);
    const double overlap = (a.sum + b.sum - twice.sum) * factor / std::sqrt(std::max(1.0F, area - twice.area));
    if (overlap <= best_[sign]) return;
    best_[sign] = overlap;
    arms_[sign] = {arm_of(a, 0, stance), arm_of(b, 1, stance)};
  }

  [[nodiscard]] CoveringArm arm_of(const Bar& bar, std::size_t side, const Stance& stance) const {
    const auto along = direction_of(double(bar.turn) / kTurns);
    const auto place = [&](double radius) {
      return copy_.in_picture(stance.shoulder[side] + along * (radius * stance.size * kScale));
    };
    return {place(lengths_.from[bar.from]), place(lengths_.tip[bar.tip])};
  }

  const ScaledCopy& copy_;
  const BarLengths& lengths_;
  bool one_hangs_;
  cv::Mat stamps_;  // CV_32S, which pair of bars was laid there last.
  int stamp_ = 0;
  double root_;
  std::array<double, kSemaphoreSigns> best_{};
  std::array<std::array<CoveringArm, 2>, kSemaphoreSigns> arms_{};
};

}  // namespace

SignCover::SignCover(const SignCoverOptions& options) : options_(options) {}

SignCoverage SignCover::cover(const cv::Mat& evidence, cv::Point2d face_centre, double face_width,
                              bool one_hangs) const {
  assert(evidence.type() == CV_8UC1 && face_width > 0);
  const BarLengths lengths(options_);
  const auto copy = scaled_copy(evidence, face_centre, face_width, lengths.beyond, options_.mirrored);
  SignCoverage out;
  out.seen = copy.sum / (options_.typical_arm * kScale * kScale);
  if (copy.squares <= 0) return out;
  Covering covering(copy, lengths, one_hangs);
  for (const double size : kSizes) {
    for (const double aside : kAsideShifts) {
      for (const double down : kDownShifts) {
        Stance stance;
        stance.size = size;
        stance.log_penalty = penalty(std::log(size), 0.35) + penalty(aside, 0.8) + penalty(down, 0.8);
        for (std::size_t s = 0; s < 2; ++s) {
          const double side = s == 0 ? lengths.aside : -lengths.aside;
          stance.shoulder[s] = copy.face + cv::Point2d(side * size + aside, lengths.below * size + down) * kScale;
        }
        covering.try_stance(stance);
      }
    }
  }
  for (std::size_t k = 0; k < kSemaphoreSigns; ++k) {
    out.overlap[k] = std::clamp(covering.best(k), 0.0, 1.0);
    out.arms[k] = covering.arms(k);
  }
  return out;
}

}  // namespace choreo::recognition

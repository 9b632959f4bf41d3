// SPDX-License-Identifier: Apache-2.0
#include "recognition/sign_cover.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <opencv2/imgproc.hpp>

#include "body/figure.hpp"

namespace choreo::recognition {
namespace {

namespace v = body::vitruvian;

// Lengths in face widths.
constexpr double kFace = v::kFaceWidth;
constexpr double kAside = v::kShoulderHalf / kFace;
constexpr double kFaceHeight = 1 - 1.0 / 40 - 1.0 / 20;  // Of the face's middle: the hairline is at H/40 [Vitruvius].
constexpr double kBelow = (kFaceHeight - v::kShoulderHeight) / kFace;
constexpr double kWhole = (v::kUpperArm + v::kForearm) / kFace;
constexpr double kWide = v::kForearmWidth / kFace;

constexpr int kScale = 12;  // Pixels of a face width in the copy that is looked at.
constexpr double kReach = 6.2;
constexpr double kUp = 5.2;    // From the face's middle, what is looked at.
constexpr double kDown = 6.2;  // Hanging arms and a taller body than the face says.
constexpr int kTurns = 72;     // Directions.
constexpr int kTurnSteps = 4;  // Off the sign's direction, to either side: 20 degrees.
constexpr int kRadii = int(4.7 * kScale);

constexpr float kLeastShown = 0.6F;  // Of a bar.

constexpr std::array<double, 3> kSizes = {0.86, 1, 1.16};
constexpr std::array<double, 3> kAsideShifts = {-0.35, 0, 0.35};
constexpr std::array<double, 3> kDownShifts = {-0.3, 0.05, 0.4};
constexpr std::array<double, 3> kBareFrom = {0.9, 1.25, 1.6};  // Middle of the upper arm, elbow, a sleeve beyond it.
constexpr std::array<double, 3> kTips = {2.9, 3.35, kWhole};

double penalty(double by, double deviation) { return -0.5 * (by / deviation) * (by / deviation); }

// Evidence along an arm: sums over its width, added up from the shoulder outwards.
struct Ray {
  std::array<float, kRadii + 1> sum{};
  std::array<float, kRadii + 1> area{};
};

cv::Point2d direction_of(double turns) {
  const double angle = 2 * std::numbers::pi * turns;
  return {-std::sin(angle), std::cos(angle)};
}

int half_width(double size) { return std::max(1, cvRound(0.5 * kWide * size * kScale)); }

// Calls `visit(r, x, y)` for the places of an arm from `from` to `to` pixels off the shoulder.
template <typename Visit>
void along_arm(cv::Point2d shoulder, double turns, double size, int from, int to, Visit visit) {
  const auto along = direction_of(turns);
  const cv::Point2d across(-along.y, along.x);
  const int half = half_width(size);
  for (int r = from; r < to; ++r) {
    for (int w = -half; w <= half; ++w) {
      const cv::Point2d at = shoulder + along * (r + 0.5) + across * w;
      visit(r, cvRound(at.x), cvRound(at.y));
    }
  }
}

// Whether a place tells anything: not beyond the picture's edge, nor before the face.
bool tells(const cv::Mat& seen, int x, int y) {
  return x >= 0 && y >= 0 && x < seen.cols && y < seen.rows && seen.at<float>(y, x) >= 0;
}

Ray ray_of(const cv::Mat& seen, cv::Point2d shoulder, double turns, double size) {
  Ray ray;
  along_arm(shoulder, turns, size, 0, kRadii, [&](int r, int x, int y) {
    if (!tells(seen, x, y)) return;
    ray.sum[std::size_t(r) + 1] += seen.at<float>(y, x);
    ray.area[std::size_t(r) + 1] += 1;
  });
  for (std::size_t r = 0; r < kRadii; ++r) {
    ray.sum[r + 1] += ray.sum[r];
    ray.area[r + 1] += ray.area[r];
  }
  return ray;
}

// One way to lay an arm.
struct Bar {
  float sum = 0;
  float area = 0;
  float log_penalty = 0;
  std::int16_t turn = 0;
  std::uint8_t from = 0, tip = 0;
};

int radius_of(double face_widths, double size) { return std::clamp(cvRound(face_widths * size * kScale), 0, kRadii); }

}  // namespace

SignCover::SignCover(bool mirrored) : mirrored_(mirrored) {}

SignCoverage SignCover::cover(const cv::Mat& evidence, cv::Point2d face_centre, double face_width,
                              bool one_hangs) const {
  assert(evidence.type() == CV_8UC1 && face_width > 0);
  // A copy in which a face is kScale wide: negative where nothing is known, as beyond the border.
  const double shrink = kScale / face_width;
  const cv::Size size(2 * int(kReach * kScale) + 1, int((kUp + kDown) * kScale) + 1);
  const cv::Point2d face(int(kReach * kScale), int(kUp * kScale));
  cv::Mat calm;
  const double blur = std::max(0.0, 0.4 / shrink);
  cv::Mat as_float;
  evidence.convertTo(as_float, CV_32F, 1.0 / 255);
  if (blur > 0.5) {
    cv::GaussianBlur(as_float, calm, {}, blur, blur, cv::BORDER_REPLICATE);
  } else {
    calm = as_float;
  }
  const double flip = mirrored_ ? -1 : 1;
  const cv::Matx23d picture_from_copy(flip / shrink, 0, face_centre.x - flip * face.x / shrink,  //
                                      0, 1 / shrink, face_centre.y - face.y / shrink);
  cv::Mat seen;
  cv::warpAffine(calm, seen, picture_from_copy, size, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_CONSTANT,
                 cv::Scalar(-1));
  // Skin of face and neck is no arm, and an arm before them tells nothing there.
  cv::ellipse(seen, cv::Point(int(face.x), int(face.y + 0.12 * kScale)),
              cv::Size(int(0.72 * kScale), int(0.95 * kScale)), 0, 0, 360, cv::Scalar(-1), cv::FILLED);
  double squares = 0;
  double all = 0;
  for (int y = 0; y < seen.rows; ++y) {
    const auto* line = seen.ptr<float>(y);
    for (int x = 0; x < seen.cols; ++x) {
      if (line[x] <= 0) continue;
      squares += double(line[x]) * line[x];
      all += line[x];
    }
  }
  SignCoverage out;
  out.seen = all / (v::kForearm / kFace * kWide * kScale * kScale);
  if (squares <= 0) return out;
  cv::Mat stamps = cv::Mat::zeros(seen.size(), CV_32S);  // Which bar was laid there last.
  int stamp = 0;
  std::array<double, kSemaphoreSigns> best{};
  best.fill(-1);
  const auto signs = body::semaphore_signs();
  std::array<std::vector<Ray>, 2> rays;  // By shoulder: the signaller's left, which is on the right, then the right.
  for (const double body : kSizes) {
    for (const double aside : kAsideShifts) {
      for (const double down : kDownShifts) {
        const double log_place = penalty(std::log(body), 0.35) + penalty(aside, 0.8) + penalty(down, 0.8);
        std::array<cv::Point2d, 2> shoulder;
        for (std::size_t s = 0; s < 2; ++s) {
          shoulder[s] = face + cv::Point2d((s == 0 ? kAside : -kAside) * body + aside, kBelow * body + down) * kScale;
          rays[s].clear();
          for (int t = 0; t < kTurns; ++t) rays[s].push_back(ray_of(seen, shoulder[s], double(t) / kTurns, body));
        }
        // The best bars of each shoulder and position; of those with alike areas only the fullest can win.
        std::array<std::array<std::vector<Bar>, 8>, 2> bars;
        for (std::size_t s = 0; s < 2; ++s) {
          for (int position = 0; position < 8; ++position) {
            auto& list = bars[s][std::size_t(position)];
            for (std::size_t f = 0; f < kBareFrom.size(); ++f) {
              for (std::size_t tip = 0; tip < kTips.size(); ++tip) {
                const auto from = std::size_t(radius_of(kBareFrom[f], body));
                const auto to = std::size_t(radius_of(kTips[tip], body));
                const float full = 2 * float(half_width(body)) + 1;
                Bar fullest;
                double most = -1;
                for (int off = -kTurnSteps; off <= kTurnSteps; ++off) {
                  const int turn = (position * kTurns / 8 + off + kTurns) % kTurns;
                  const auto& ray = rays[s][std::size_t(turn)];
                  Bar bar;
                  bar.sum = ray.sum[to] - ray.sum[from];
                  // What the face hides, or lies beyond the picture, may be there: but an arm that is nowhere to be
                  // seen is no explanation.
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
                list.push_back(fullest);
              }
            }
          }
        }
        struct Common {
          float sum = 0, area = 0;
        };
        const auto common = [&](const Bar& a, const Bar& b) {
          Common both;
          if (a.area <= 0 || b.area <= 0) return both;
          ++stamp;
          const auto lay = [&](const Bar& bar, std::size_t s, auto visit) {
            along_arm(shoulder[s], double(bar.turn) / kTurns, body, radius_of(kBareFrom[bar.from], body),
                      radius_of(kTips[bar.tip], body), [&](int, int x, int y) {
                        if (tells(seen, x, y)) visit(x, y);
                      });
          };
          lay(a, 0, [&](int x, int y) { stamps.at<int>(y, x) = stamp; });
          lay(b, 1, [&](int x, int y) {
            if (stamps.at<int>(y, x) != stamp) return;
            both.sum += seen.at<float>(y, x);
            both.area += 1;
          });
          return both;
        };
        if (one_hangs) {
          for (auto& shoulders : bars) shoulders[0] = {Bar{}};
        }
        for (std::size_t k = 0; k < signs.size(); ++k) {
          if (one_hangs && (signs[k].left == 0) == (signs[k].right == 0)) continue;
          for (const bool swapped : {false, true}) {
            const auto& lefts = bars[0][std::size_t(swapped ? signs[k].right : signs[k].left)];
            const auto& rights = bars[1][std::size_t(swapped ? signs[k].left : signs[k].right)];
            for (const auto& a : lefts) {
              for (const auto& b : rights) {
                const double factor = std::exp(log_place + a.log_penalty + b.log_penalty) / std::sqrt(squares);
                const float area = std::max(1.0F, a.area + b.area);
                if ((a.sum + b.sum) * factor / std::sqrt(area) <= best[k]) continue;
                // What both bars cover counts once.
                const auto twice = common(a, b);
                const double overlap =
                    (a.sum + b.sum - twice.sum) * factor / std::sqrt(std::max(1.0F, area - twice.area));
                if (overlap <= best[k]) continue;
                best[k] = overlap;
                const std::array<const Bar*, 2> chosen = {&a, &b};
                for (std::size_t s = 0; s < 2; ++s) {
                  const auto along = direction_of(double(chosen[s]->turn) / kTurns);
                  const auto place = [&](double radius) {
                    const cv::Point2d at = shoulder[s] + along * (radius * body * kScale);
                    return cv::Point2d(picture_from_copy(0, 0) * at.x + picture_from_copy(0, 2),
                                       picture_from_copy(1, 1) * at.y + picture_from_copy(1, 2));
                  };
                  out.arms[k][s] = {place(kBareFrom[chosen[s]->from]), place(kTips[chosen[s]->tip])};
                }
              }
            }
          }
        }
      }
    }
  }
  for (std::size_t k = 0; k < kSemaphoreSigns; ++k) out.overlap[k] = std::clamp(best[k], 0.0, 1.0);
  return out;
}

}  // namespace choreo::recognition

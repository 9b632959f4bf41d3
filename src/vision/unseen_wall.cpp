// SPDX-License-Identifier: Apache-2.0
#include "vision/unseen_wall.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "vision/colour_modes.hpp"
#include "vision/colour_odds.hpp"
#include "vision/difference.hpp"
#include "vision/min_cut.hpp"
#include "vision/soft_light.hpp"

namespace choreo::vision {
namespace {

constexpr int kModes = ColourModes::kMost;
constexpr int kTurns = 7;
constexpr float kMostOdds = 3.0F;     // Of one pixel's colour: no single one decides against all around it.
constexpr float kSmooth = 6.0F;       // What it costs to part two alike neighbours, in the units of log odds.
constexpr float kSmoothLeast = 0.3F;  // And two that are not alike.
constexpr float kMostOutside = 8.0F;  // Against what the moving body is never around.
constexpr float kSecondWall = 4.0F;   // Against a second colour being the wall too.
constexpr float kShade = 0.92F;  // A darker colour of the wall's hue may be clothes; a soft shadow goes from each mask.
constexpr float kUnit = 1000.0F;  // Of the cut's whole numbers.

float colour_distance(const cv::Vec3b& a, const cv::Vec3b& b) {
  return static_cast<float>(0.114 * std::abs(a[0] - b[0]) + 0.587 * std::abs(a[1] - b[1]) +
                            0.299 * std::abs(a[2] - b[2]));
}

// Where the commonest colour does not stand alone, without specks and whatever else moves in the room.
cv::Mat moving_part(const ColourModes& modes) {
  cv::Mat moving = cv::Mat::zeros(modes.size, CV_8UC1);
  const int quiet = modes.pictures - std::max(2, modes.pictures / 20);
  for (int p = 0; p < modes.size.area(); ++p) {
    if (modes.at(p)[0].count < quiet) moving.data[p] = 255;
  }
  cv::morphologyEx(moving, moving, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  moving = annealed(moving, 2);
  return without_small_parts(moving, 5);
}

// Fills `where` smoothly from what is around: the mean of what is known in ever wider windows.
void fill_smoothly(cv::Mat& picture, const cv::Mat& where) {
  cv::Mat colours, weights;
  picture.convertTo(colours, CV_32F);
  cv::Mat known = ~where;
  known.convertTo(weights, CV_32F, 1.0 / 255.0);
  cv::Mat three;
  cv::merge(std::vector<cv::Mat>{weights, weights, weights}, three);
  colours = colours.mul(three);
  cv::Mat left = where.clone();
  for (int width = 5; cv::countNonZero(left) > 0 && width < 4 * std::max(picture.cols, picture.rows);
       width = 2 * width + 1) {
    const int w = std::min({width, 2 * ((picture.cols - 1) / 2) + 1 + 2 * picture.cols, 4097});
    cv::Mat sums, total;
    cv::boxFilter(colours, sums, -1, {w, w}, {-1, -1}, false, cv::BORDER_CONSTANT);
    cv::boxFilter(weights, total, -1, {w, w}, {-1, -1}, false, cv::BORDER_CONSTANT);
    for (int y = 0; y < picture.rows; ++y) {
      for (int x = 0; x < picture.cols; ++x) {
        const float t = total.at<float>(y, x);
        if (left.at<std::uint8_t>(y, x) == 0 || t < 0.5F) continue;
        const auto& s = sums.at<cv::Vec3f>(y, x);
        for (int c = 0; c < 3; ++c) picture.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(s[c] / t);
        left.at<std::uint8_t>(y, x) = 0;
      }
    }
  }
}

struct Link {
  int a, b;
  float weight;
};

}  // namespace

class WallInference::Impl {
 public:
  Impl(std::vector<cv::Mat> pictures, double noise)
      : noise_(static_cast<float>(noise)), pictures_(std::move(pictures)) {
    assert(!pictures_.empty());
  }

  bool advance();
  [[nodiscard]] const InferredWall& wall() const { return out_; }

 private:
  enum class Step { kModes, kNodes, kLinks, kCut, kParts, kAround, kOdds, kAnswer, kDone };

  void find_modes();
  void choose_nodes();
  void link_neighbours();
  void first_odds();
  void cut(int turn);
  void odds_of_answers();
  void find_parts();
  void look_around();
  void answer();
  [[nodiscard]] int wall_mode(int pixel) const;

  float noise_;
  Step next_ = Step::kModes;
  int turn_ = 0;
  InferredWall out_;
  std::vector<cv::Mat> pictures_;
  ColourModes modes_;
  cv::Mat moving_, hull_, zone_, prior_, reach_;
  std::vector<int> node_;  // Of pixel and mode, or -1: outside the zone, where the commonest is the wall.
  std::vector<std::array<int, 2>> what_;  // Pixel and mode of each node.
  std::vector<Link> links_;
  std::vector<std::uint8_t> body_;  // The answer of each node.
  std::vector<float> enclosed_;     // Of each node: in what share of its pictures the moving body is around it, 0 to 1.
  ColourOdds odds_;
  std::vector<cv::Mat> parts_;  // Of the body, before wall that is known, in each picture.
  cv::Mat rest_;                // The largest part of which all colours are the body's.
  double area_ = 0;             // Mean of the parts, pixels.
};

void WallInference::Impl::choose_nodes() {
  const auto box = cv::boundingRect(moving_);
  const int margin = 2 + modes_.size.height / 5;
  const auto zone =
      cv::Rect(box.x - margin, 0, box.width + 2 * margin, modes_.size.height) & cv::Rect({0, 0}, modes_.size);
  zone_ = cv::Mat::zeros(modes_.size, CV_8UC1);
  zone_(zone) = 255;
  node_.assign(modes_.modes.size(), -1);
  for (int p = 0; p < modes_.size.area(); ++p) {
    if (zone_.data[p] == 0) continue;
    for (int m = 0; m < kModes; ++m) {
      if (modes_.at(p)[m].count == 0) continue;
      node_[std::size_t(p * kModes + m)] = static_cast<int>(what_.size());
      what_.push_back({p, m});
    }
  }
  // Beyond what the movement encloses a body is the less likely the farther away.
  cv::Mat outside = ~hull_;
  cv::distanceTransform(outside, prior_, cv::DIST_L2, 3);
  for (int p = 0; p < modes_.size.area(); ++p) {
    auto& prior = prior_.ptr<float>()[p];
    prior = prior == 0 ? 0.3F : -0.3F - 3.0F * prior / static_cast<float>(modes_.size.height);
  }
}

// Neighbouring nodes that are seen together, weighed by how often and how alike they are.
void WallInference::Impl::link_neighbours() {
  const float scale = 6.0F + 2.0F * noise_;
  const int cols = modes_.size.width;
  for (int y = 0; y < modes_.size.height; ++y) {
    for (int x = 0; x < cols; ++x) {
      const int p = y * cols + x;
      for (const int q : {x + 1 < cols ? p + 1 : -1, y + 1 < modes_.size.height ? p + cols : -1}) {
        if (q < 0 || zone_.data[p] == 0 || zone_.data[q] == 0) continue;
        std::array<std::array<int, kModes>, kModes> together{};
        if (modes_.at(p)[1].count == 0 && modes_.at(q)[1].count == 0) {
          together[0][0] = std::min(modes_.at(p)[0].count, modes_.at(q)[0].count);
        } else {
          for (const auto& of : modes_.of) {
            const auto a = of.data[p];
            const auto b = of.data[q];
            if (a != ColourModes::kNone && b != ColourModes::kNone) ++together[a][b];
          }
        }
        for (int a = 0; a < kModes; ++a) {
          for (int b = 0; b < kModes; ++b) {
            const int n = together[std::size_t(a)][std::size_t(b)];
            if (n == 0) continue;
            const float d = colour_distance(modes_.at(p)[a].colour, modes_.at(q)[b].colour) / scale;
            const float weight = kSmoothLeast + kSmooth * std::exp(-0.5F * d * d);
            links_.push_back({node_[std::size_t(p * kModes + a)], node_[std::size_t(q * kModes + b)],
                              weight * static_cast<float>(n) / static_cast<float>(modes_.pictures)});
          }
        }
      }
    }
  }
}

// What is certain at first: wall is what never moves beside the body's reach. Of the colours of a pixel the one that is
// most like that wall is the wall, and the others are the body's, unless they are the same surface lightly shaded or
// lit.
void WallInference::Impl::first_odds() {
  const float in_zone = 10 * cv::countNonZero(zone_) > 9 * modes_.size.area() ? 0.3F : 0.0F;
  ColourOdds of_wall;
  odds_ = ColourOdds();
  for (int p = 0; p < modes_.size.area(); ++p) {
    if (hull_.data[p] != 0) continue;
    const float weight = zone_.data[p] == 0 ? 1.0F : in_zone;
    of_wall.add_wall(modes_.at(p)[0].colour, weight);
    odds_.add_wall(modes_.at(p)[0].colour, weight);
  }
  of_wall.finish();
  for (int p = 0; p < modes_.size.area(); ++p) {
    if (moving_.data[p] == 0) continue;
    const auto* modes = modes_.at(p);
    const auto score = [&](int m) {
      return 2.5F * std::log(static_cast<float>(modes[m].count)) -
             std::clamp(of_wall.log_odds(modes[m].colour), -4.0F, 2.0F);
    };
    int wall = 0;
    for (int m = 1; m < kModes; ++m) {
      if (modes[m].count > 0 && score(m) > score(wall)) wall = m;
    }
    if (3 * modes[wall].count >= 2 * modes_.pictures) odds_.add_wall(modes[wall].colour, 1.0F);
    for (int m = 0; m < kModes; ++m) {
      if (modes[m].count > 0 && score(m) < score(wall) - 2.0F &&
          !same_surface(modes[m].colour, modes[wall].colour, kShade)) {
        odds_.add_body(modes[m].colour, static_cast<float>(modes[m].count));
      }
    }
  }
  odds_.finish();
}

// The node that is the wall's at a pixel, or -1 where all are the body's.
int WallInference::Impl::wall_mode(int pixel) const {
  int best = -1;
  float best_score = 0;
  for (int m = 0; m < kModes; ++m) {
    const int n = node_[std::size_t(pixel * kModes + m)];
    if (n < 0 || body_[std::size_t(n)] != 0) continue;
    const auto& mode = modes_.at(pixel)[m];
    const float score =
        std::log(static_cast<float>(mode.count)) - std::clamp(odds_.log_odds(mode.colour), -kMostOdds, kMostOdds);
    if (best < 0 || score > best_score) {
      best = m;
      best_score = score;
    }
  }
  return best;
}

void WallInference::Impl::cut(int turn) {
  MinCut graph(static_cast<int>(what_.size()));
  for (std::size_t n = 0; n < what_.size(); ++n) {
    const auto [p, m] = what_[n];
    const auto& mode = modes_.at(p)[m];
    const float share = static_cast<float>(mode.count) / static_cast<float>(modes_.pictures);
    float odds = std::clamp(odds_.log_odds(mode.colour), -kMostOdds, kMostOdds) + prior_.ptr<float>()[p];
    if (turn > 0) {
      odds -= kMostOutside * std::clamp((0.9F - enclosed_[n]) / 0.4F, 0.0F, 1.0F);
      // There is one wall at a pixel: where another colour was found to be it, this one is the body's, or its shadow.
      const int wall = wall_mode(p);
      if (wall >= 0 && wall != m) odds += kSecondWall;
    }
    const int cost = static_cast<int>(std::lround(kUnit * share * odds));
    const int x = p % modes_.size.width;
    const bool beside = zone_.data[p] != 0 &&
                        ((x > 0 && zone_.data[p - 1] == 0) || (x + 1 < modes_.size.width && zone_.data[p + 1] == 0));
    graph.add_cost(static_cast<int>(n), std::max(0, cost), std::max(0, -cost));
    if (beside) graph.add_cost(static_cast<int>(n), 0, static_cast<int>(10 * kUnit));
  }
  for (const auto& link : links_) graph.join(link.a, link.b, static_cast<int>(std::lround(kUnit * link.weight)));
  graph.solve();
  for (std::size_t n = 0; n < what_.size(); ++n) body_[n] = graph.with_source(static_cast<int>(n)) ? 1 : 0;
}

void WallInference::Impl::odds_of_answers() {
  odds_ = ColourOdds();
  for (int p = 0; p < modes_.size.area(); ++p) {
    if (zone_.data[p] == 0) {
      odds_.add_wall(modes_.at(p)[0].colour, static_cast<float>(modes_.at(p)[0].count));
      continue;
    }
    const int wall = wall_mode(p);
    for (int m = 0; m < kModes; ++m) {
      const auto& mode = modes_.at(p)[m];
      if (mode.count == 0) continue;
      if (m == wall) {
        // A wall that is seen now and then counts as one that is seen all the time: it is there all the time.
        odds_.add_wall(mode.colour, static_cast<float>(modes_.pictures));
      } else if (body_[std::size_t(node_[std::size_t(p * kModes + m)])] != 0) {
        if (wall >= 0 && same_surface(mode.colour, modes_.at(p)[wall].colour, kShade)) continue;
        odds_.add_body(mode.colour, (wall >= 0 ? 1.0F : 0.2F) * static_cast<float>(mode.count));
      }
    }
  }
  odds_.finish();
}

// What of the body moves, picture by picture.
void WallInference::Impl::find_parts() {
  const int pixels = modes_.size.area();
  std::vector<int> wall(std::size_t(pixels), -1);
  cv::Mat still = cv::Mat::zeros(modes_.size, CV_8UC1);  // All of its colours are the body's.
  for (int p = 0; p < pixels; ++p) {
    if (zone_.data[p] == 0) continue;
    wall[std::size_t(p)] = wall_mode(p);
    if (wall[std::size_t(p)] < 0) still.data[p] = 255;
  }
  parts_.clear();
  area_ = 0;
  for (const auto& of : modes_.of) {
    cv::Mat part = cv::Mat::zeros(modes_.size, CV_8UC1);
    for (int p = 0; p < pixels; ++p) {
      const auto m = of.data[p];
      if (wall[std::size_t(p)] < 0 || m == ColourModes::kNone || m == wall[std::size_t(p)]) continue;
      if (body_[std::size_t(node_[std::size_t(p * kModes + m)])] != 0) part.data[p] = 255;
    }
    parts_.push_back(without_small_parts(annealed(part, 1), 10));
    area_ += cv::countNonZero(parts_.back());
  }
  area_ /= modes_.pictures;
  reach_ = cv::Mat::zeros(modes_.size, CV_8UC1);
  for (const auto& part : parts_) reach_ |= without_small_parts(part, 4);
  rest_ = without_specks(annealed(still, 1), 1, true);
}

// A body is around its trunk: what shows while the moving parts are elsewhere is the wall, or a thing in the room.
// Where little moves, such as the arms of somebody who signals, the one part that does not move is taken for the rest
// of it.
void WallInference::Impl::look_around() {
  const int pixels = modes_.size.area();
  std::vector<int> inside(what_.size(), 0);
  // Half the width of a trunk.
  const double reach = std::max(2.0, 0.4 * std::sqrt(area_ + std::min(area_, double(cv::countNonZero(rest_)))));
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const auto filled = closed_by_disc(parts_[k], reach);
    for (int p = 0; p < pixels; ++p) {
      const auto m = modes_.of[k].data[p];
      if (filled.data[p] == 0 || zone_.data[p] == 0 || m == ColourModes::kNone) continue;
      ++inside[std::size_t(node_[std::size_t(p * kModes + m)])];
    }
  }
  enclosed_.resize(what_.size());
  for (std::size_t n = 0; n < what_.size(); ++n) {
    enclosed_[n] = static_cast<float>(inside[n]) / static_cast<float>(modes_.at(what_[n][0])[what_[n][1]].count);
  }
  if (cv::countNonZero(rest_) > 3 * area_) {
    for (std::size_t n = 0; n < what_.size(); ++n) {
      if (rest_.data[what_[n][0]] != 0) enclosed_[n] = 1;
    }
  }
}

void WallInference::Impl::find_modes() {
  modes_ = colour_modes(pictures_, static_cast<int>(std::lround(std::max(10.0F, 4.0F * noise_))));
  pictures_.clear();
  out_.plate.create(modes_.size, CV_8UC3);
  out_.unseen = cv::Mat::zeros(modes_.size, CV_8UC1);
  out_.ghost = cv::Mat::zeros(modes_.size, CV_8UC3);
  out_.reach = cv::Mat::zeros(modes_.size, CV_8UC1);
  for (int p = 0; p < modes_.size.area(); ++p) out_.plate.ptr<cv::Vec3b>()[p] = modes_.at(p)[0].colour;
  moving_ = moving_part(modes_);
}

bool WallInference::Impl::advance() {
  switch (next_) {
    case Step::kModes:
      find_modes();
      next_ = cv::countNonZero(moving_) == 0 ? Step::kDone : Step::kNodes;
      break;
    case Step::kNodes:
      hull_ = hull_of(moving_);
      choose_nodes();
      body_.assign(what_.size(), 0);
      first_odds();
      next_ = Step::kLinks;
      break;
    case Step::kLinks:
      link_neighbours();
      next_ = Step::kCut;
      break;
    case Step::kCut:
      cut(turn_);
      next_ = Step::kParts;
      break;
    case Step::kParts:
      find_parts();
      next_ = Step::kAround;
      break;
    case Step::kAround:
      look_around();
      next_ = Step::kOdds;
      break;
    case Step::kOdds:
      odds_of_answers();
      next_ = ++turn_ < kTurns ? Step::kCut : Step::kAnswer;
      break;
    case Step::kAnswer:
      answer();
      next_ = Step::kDone;
      break;
    case Step::kDone:
      break;
  }
  return next_ == Step::kDone;
}

void WallInference::Impl::answer() {
  for (int p = 0; p < modes_.size.area(); ++p) {
    if (zone_.data[p] == 0) continue;
    const int wall = wall_mode(p);
    if (wall >= 0) {
      out_.plate.ptr<cv::Vec3b>()[p] = modes_.at(p)[wall].colour;
    } else {
      out_.unseen.data[p] = 255;
    }
  }
  // What stands alone far from the rest is a thing in the room.
  const cv::Mat main = without_specks(annealed(out_.unseen, 3), std::max(2, modes_.size.area() / 2000), false);
  out_.unseen &= main;
  for (int p = 0; p < modes_.size.area(); ++p) {
    if (out_.unseen.data[p] != 0) out_.ghost.ptr<cv::Vec3b>()[p] = modes_.at(p)[0].colour;
  }
  fill_smoothly(out_.plate, out_.unseen);
  const int near = 1 + modes_.size.height / 20;
  cv::dilate(reach_ | out_.unseen, out_.reach, cv::getStructuringElement(cv::MORPH_RECT, {2 * near + 1, 2 * near + 1}));
}

WallInference::WallInference(std::vector<cv::Mat> pictures, double noise)
    : impl_(std::make_unique<Impl>(std::move(pictures), noise)) {}
WallInference::~WallInference() = default;
WallInference::WallInference(WallInference&&) noexcept = default;
WallInference& WallInference::operator=(WallInference&&) noexcept = default;
bool WallInference::advance() { return impl_->advance(); }
const InferredWall& WallInference::wall() const { return impl_->wall(); }

InferredWall infer_wall(std::span<const cv::Mat> pictures, double noise) {
  WallInference inference({pictures.begin(), pictures.end()}, noise);
  while (!inference.advance()) {
  }
  return inference.wall();
}

}  // namespace choreo::vision

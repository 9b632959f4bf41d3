// SPDX-License-Identifier: Apache-2.0
#include "vision/shared_wall.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <opencv2/imgproc.hpp>

#include "vision/difference.hpp"
#include "vision/scene_alignment.hpp"
#include "vision/tone_curve.hpp"

namespace choreo::vision {
namespace {

constexpr std::size_t kTries = 4;           // Pictures that the others are laid on, to find one that most lie on.
constexpr std::size_t kMostFruitless = 64;  // Pictures tried in a row to no end, where that cost alignments.
constexpr std::size_t kFew = 32;            // Pictures of which every pair may be aligned.
constexpr std::size_t kPatch = 32;          // Pictures aligned between two reports.
constexpr double kMostMargin = 0.08;        // Of the picture's side, that the canvas reaches beyond the reference.
constexpr double kNoiseFactor = 4;          // Threshold over noise.
constexpr double kUnrestFactor = 3;         // Threshold over what the pictures commonly differ at a pixel,
constexpr double kMostUnrest = 2.5;         // at most so many times the threshold elsewhere.
constexpr double kBlur = 1.1;               // px: an arm is wider, noise is not.
constexpr double kSureFactor = 2.5;         // Difference that is certain, over the threshold.
constexpr int kSpread = 48;                 // Grey levels: pictures of a set are taken minutes apart.
constexpr double kOverWall = 14;            // D above which a pixel is left out when exposures are brought together.

cv::Matx33d square(const cv::Matx23d& m) { return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), 0, 0, 1}; }

cv::Point2d middle_of(const cv::Matx23d& m, cv::Size size) {
  const double x = 0.5 * (size.width - 1);
  const double y = 0.5 * (size.height - 1);
  return {m(0, 0) * x + m(0, 1) * y + m(0, 2), m(1, 0) * x + m(1, 1) * y + m(1, 2)};
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The canvas: the reference and what the others show beyond it.
SharedScene on_canvas(std::vector<std::size_t> members, const std::vector<cv::Matx23d>& picture_from_reference,
                      cv::Size size) {
  double left = 0, top = 0, right = size.width - 1, bottom = size.height - 1;
  for (const auto& m : picture_from_reference) {
    const auto back = square(m).inv();
    for (const auto& [x, y] :
         {std::pair(0, 0), {size.width - 1, 0}, {0, size.height - 1}, {size.width - 1, size.height - 1}}) {
      const double px = back(0, 0) * x + back(0, 1) * y + back(0, 2);
      const double py = back(1, 0) * x + back(1, 1) * y + back(1, 2);
      left = std::min(left, px);
      right = std::max(right, px);
      top = std::min(top, py);
      bottom = std::max(bottom, py);
    }
  }
  const auto margin = [](double beyond, int side) {
    return int(std::ceil(std::clamp(beyond, 0.0, kMostMargin * side) - 1e-6));
  };
  const int x0 = margin(-left, size.width);
  const int y0 = margin(-top, size.height);
  SharedScene scene;
  scene.canvas = {size.width + x0 + margin(right - (size.width - 1), size.width),
                  size.height + y0 + margin(bottom - (size.height - 1), size.height)};
  const cv::Matx33d reference_from_canvas(1, 0, -x0, 0, 1, -y0, 0, 0, 1);
  for (const auto& m : picture_from_reference) scene.picture_from_canvas.push_back(m * reference_from_canvas);
  scene.members = std::move(members);
  return scene;
}

cv::Mat on(const cv::Mat& picture, const cv::Matx23d& picture_from_canvas, cv::Size canvas, int interpolation) {
  cv::Mat out;
  cv::warpAffine(picture, out, picture_from_canvas, canvas, interpolation | cv::WARP_INVERSE_MAP, cv::BORDER_CONSTANT,
                 cv::Scalar::all(0));
  return out;
}

cv::Mat coverage(cv::Size picture, const cv::Matx23d& picture_from_canvas, cv::Size canvas) {
  return on(cv::Mat(picture, CV_8UC1, cv::Scalar(255)), picture_from_canvas, canvas, cv::INTER_LINEAR) == 255;
}

// Per pixel and channel the median over those pictures that cover it.
cv::Mat covered_median(const std::vector<cv::Mat>& pictures, const std::vector<cv::Mat>& covered) {
  cv::Mat out = cv::Mat::zeros(pictures.front().size(), CV_8UC3);
  tbb::parallel_for(tbb::blocked_range<int>(0, out.rows), [&](const tbb::blocked_range<int>& rows) {
    std::array<std::vector<std::uint8_t>, 3> seen;
    for (int y = rows.begin(); y < rows.end(); ++y) {
      for (int x = 0; x < out.cols; ++x) {
        for (auto& channel : seen) channel.clear();
        for (std::size_t i = 0; i < pictures.size(); ++i) {
          if (covered[i].at<std::uint8_t>(y, x) == 0) continue;
          const auto& pixel = pictures[i].at<cv::Vec3b>(y, x);
          for (int c = 0; c < 3; ++c) seen[std::size_t(c)].push_back(pixel[c]);
        }
        if (seen[0].empty()) continue;
        for (int c = 0; c < 3; ++c) {
          auto& channel = seen[std::size_t(c)];
          const auto middle = channel.begin() + std::ptrdiff_t(channel.size() / 2);
          std::nth_element(channel.begin(), middle, channel.end());
          int value = *middle;
          if (channel.size() % 2 == 0) value = (value + *std::max_element(channel.begin(), middle) + 1) / 2;
          out.at<cv::Vec3b>(y, x)[c] = static_cast<std::uint8_t>(value);
        }
      }
    }
  });
  return out;
}

cv::Mat smoothed(const cv::Mat& picture) {
  cv::Mat out;
  cv::GaussianBlur(picture, out, {}, kBlur, kBlur, cv::BORDER_REPLICATE);
  return out;
}

cv::Mat except_of(const cv::Mat& difference, const cv::Mat& covered) {
  cv::Mat out = difference > kOverWall;
  cv::dilate(out, out, cv::getStructuringElement(cv::MORPH_RECT, {5, 5}));
  out |= ~covered;
  return out;
}

}  // namespace

namespace {

// What lies on one picture.
struct Group {
  std::size_t reference = 0;
  std::vector<std::size_t> members;  // With the reference.
  std::vector<cv::Matx23d> transforms;
};

// Lays pictures on one another, and says how far that is.
class Aligner {
 public:
  Aligner(std::span<const cv::Mat> pictures, const std::function<void(double)>& progress, std::stop_token stop)
      : pictures_(pictures), progress_(progress), stop_(std::move(stop)) {
    if (pictures.size() <= kFew) return;
    for (const auto& picture : pictures) sketches_.emplace_back(picture);
  }

  // Those of `left` that lie on the reference; not all of them where it is stopped.
  [[nodiscard]] Group group_of(std::size_t reference, std::span<const std::size_t> left) {
    std::vector<std::size_t> others;
    for (const auto i : left) {
      if (stopped()) break;
      if (i == reference || pictures_[i].size() != pictures_[reference].size()) continue;
      if (sketches_.empty() || sketches_[reference].may_share(sketches_[i])) others.push_back(i);
    }
    std::vector<SceneAlignment> found(others.size());
    for (std::size_t begin = 0; begin < others.size(); begin += kPatch) {
      const auto end = std::min(others.size(), begin + kPatch);
      tbb::parallel_for(begin, end, [&](std::size_t i) {
        if (!stopped()) found[i] = align_scene(pictures_[reference], pictures_[others[i]]);
      });
      aligned_ += end - begin;
      report();
    }
    Group group{reference, {reference}, {cv::Matx23d(1, 0, 0, 0, 1, 0)}};
    for (std::size_t i = 0; i < others.size(); ++i) {
      if (!found[i].aligned) continue;
      group.members.push_back(others[i]);
      group.transforms.push_back(found[i].picture_from_reference);
    }
    return group;
  }

  [[nodiscard]] bool stopped() const { return stop_.stop_requested(); }
  [[nodiscard]] std::size_t aligned() const { return aligned_; }  // So far, pairs.

 private:
  // A set of one scene takes two alignments a picture; of others nobody knows.
  void report() const {
    if (progress_) progress_(double(aligned_) / double(aligned_ + pictures_.size()));
  }

  std::span<const cv::Mat> pictures_;
  const std::function<void(double)>& progress_;
  std::stop_token stop_;
  std::vector<SceneSketch> sketches_;
  std::size_t aligned_ = 0;
};

// The member whose camera stood in the middle of all: the one that most others lie on with the least change.
std::size_t typical_of(const Group& group, cv::Size size) {
  std::vector<cv::Point2d> middles;
  std::vector<double> xs, ys;
  for (const auto& transform : group.transforms) {
    middles.push_back(middle_of(transform, size));
    xs.push_back(middles.back().x);
    ys.push_back(middles.back().y);
  }
  const cv::Point2d middle(median_of(xs), median_of(ys));
  std::size_t best = 0;
  for (std::size_t i = 1; i < middles.size(); ++i) {
    if (cv::norm(middles[i] - middle) < cv::norm(middles[best] - middle)) best = i;
  }
  return group.members[best];
}

void take_out(const std::vector<std::size_t>& taken, std::vector<std::size_t>& left) {
  std::erase_if(left, [&](std::size_t i) { return std::find(taken.begin(), taken.end(), i) != taken.end(); });
}

}  // namespace

std::optional<std::vector<SharedScene>> shared_scenes(std::span<const cv::Mat> pictures,
                                                      const std::function<void(double)>& progress,
                                                      std::stop_token stop) {
  std::vector<SharedScene> scenes;
  Aligner aligner(pictures, progress, std::move(stop));
  std::vector<std::size_t> left(pictures.size());
  std::iota(left.begin(), left.end(), std::size_t(0));
  std::size_t fruitless = 0;
  while (left.size() > 1 && fruitless < kMostFruitless) {
    Group best;
    const auto aligned_before = aligner.aligned();
    std::vector<std::size_t> tried;
    const auto tries = std::min(kTries, left.size());
    for (std::size_t k = 0; k < tries && 2 * best.members.size() <= left.size(); ++k) {
      tried.push_back(left[k * left.size() / tries]);
      auto group = aligner.group_of(tried.back(), left);
      if (aligner.stopped()) return std::nullopt;
      if (group.members.size() > best.members.size()) best = std::move(group);
    }
    if (best.members.size() < 2) {
      take_out(tried, left);
      fruitless += aligner.aligned() > aligned_before ? tried.size() : 0;
      continue;
    }
    fruitless = 0;
    const auto typical = typical_of(best, pictures[best.reference].size());
    if (typical != best.reference) {
      auto group = aligner.group_of(typical, left);
      if (aligner.stopped()) return std::nullopt;
      if (group.members.size() >= best.members.size()) best = std::move(group);
    }
    take_out(best.members, left);
    std::vector<std::size_t> order(best.members.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return best.members[a] < best.members[b]; });
    Group sorted{best.reference, {}, {}};
    for (const auto i : order) {
      sorted.members.push_back(best.members[i]);
      sorted.transforms.push_back(best.transforms[i]);
    }
    scenes.push_back(on_canvas(std::move(sorted.members), sorted.transforms, pictures[best.reference].size()));
  }
  std::stable_sort(scenes.begin(), scenes.end(),
                   [](const auto& a, const auto& b) { return a.members.size() > b.members.size(); });
  return scenes;
}

SharedWall::SharedWall(std::span<const cv::Mat> pictures, const SharedScene& scene) {
  assert(!scene.members.empty());
  const auto count = std::min(kMostPictures, scene.members.size());
  std::vector<cv::Mat> shown, covered;
  for (std::size_t k = 0; k < count; ++k) {
    const auto member = k * scene.members.size() / count;
    const auto& picture = pictures[scene.members[member]];
    const auto& matrix = scene.picture_from_canvas[member];
    shown.push_back(on(picture, matrix, scene.canvas, cv::INTER_LINEAR));
    covered.push_back(coverage(picture.size(), matrix, scene.canvas));
  }
  // All in the light of one that is neither the brightest nor the darkest.
  std::vector<std::pair<double, std::size_t>> light;
  for (std::size_t k = 0; k < count; ++k) {
    const auto mean = cv::mean(shown[k], covered[k]);
    light.emplace_back(0.114 * mean[0] + 0.587 * mean[1] + 0.299 * mean[2], k);
  }
  std::nth_element(light.begin(), light.begin() + std::ptrdiff_t(count / 2), light.end());
  const cv::Mat middle = shown[light[count / 2].second].clone();
  const cv::Mat middle_covered = covered[light[count / 2].second];
  const auto lit = [&](const cv::Mat& target, const cv::Mat& target_covered, bool against_plate) {
    std::vector<cv::Mat> out(count);
    tbb::parallel_for(std::size_t(0), count, [&](std::size_t k) {
      cv::Mat except = ~(covered[k] & target_covered);
      if (against_plate) {
        const cv::Mat once = ToneCurve(shown[k], target, except, kSpread).apply(shown[k]);
        except |= except_of(difference_from(once), covered[k]);
      }
      out[k] = ToneCurve(shown[k], target, except, kSpread).apply(shown[k]);
    });
    return out;
  };
  const auto take_plate = [&](const std::vector<cv::Mat>& pictures_lit) {
    plate_ = covered_median(pictures_lit, covered);
    const cv::Mat around = cv::getStructuringElement(cv::MORPH_RECT, {3, 3});
    smooth_ = smoothed(plate_);
    cv::erode(smooth_, darkest_, around);
    cv::dilate(smooth_, brightest_, around);
  };
  take_plate(lit(middle, middle_covered, false));
  cv::Mat any = covered.front().clone();
  for (const auto& c : covered) any |= c;
  const auto all = lit(plate_, any, true);
  take_plate(all);
  std::vector<cv::Mat> differences(count);
  std::vector<double> medians(count);
  tbb::parallel_for(std::size_t(0), count, [&](std::size_t k) {
    differences[k] = difference_from(all[k]);
    differences[k].setTo(0, ~covered[k]);
    medians[k] = interpolated_median(difference_luminance(smoothed(all[k]), smooth_));
  });
  // The plate has hardly any noise of its own; D of one picture is the mean of |normal|, of which 0.6745 is the median.
  noise_ = median_of(medians) / 0.6745;
  unrest_ = cv::Mat::zeros(plate_.size(), CV_8UC1);
  std::vector<std::uint8_t> seen(count);
  for (int y = 0; y < unrest_.rows; ++y) {
    for (int x = 0; x < unrest_.cols; ++x) {
      for (std::size_t k = 0; k < count; ++k) seen[k] = differences[k].at<std::uint8_t>(y, x);
      const auto middle_place = seen.begin() + std::ptrdiff_t(count / 2);
      std::nth_element(seen.begin(), middle_place, seen.end());
      unrest_.at<std::uint8_t>(y, x) = *middle_place;
    }
  }
}

cv::Mat SharedWall::difference_from(const cv::Mat& picture) const {
  cv::Mat below, above;
  const cv::Mat smooth = smoothed(picture);
  cv::subtract(darkest_, smooth, below);  // Saturated: 0 where the picture is inside the range.
  cv::subtract(smooth, brightest_, above);
  below += above;
  cv::Mat out;
  cv::cvtColor(below, out, cv::COLOR_BGR2GRAY);
  return out;
}

AgainstWall SharedWall::compare(const cv::Mat& picture, const cv::Matx23d& picture_from_canvas,
                                double least_threshold) const {
  AgainstWall out;
  const cv::Mat raw = on(picture, picture_from_canvas, plate_.size(), cv::INTER_LINEAR);
  out.covered = coverage(picture.size(), picture_from_canvas, plate_.size());
  cv::Mat except = ~out.covered;
  const cv::Mat once = ToneCurve(raw, plate_, except, kSpread).apply(raw);
  except |= except_of(difference_from(once), out.covered);
  out.bgr = ToneCurve(raw, plate_, except, kSpread).apply(raw);
  out.bgr.setTo(cv::Scalar::all(0), ~out.covered);
  out.difference = difference_from(out.bgr);
  out.difference.setTo(0, ~out.covered);
  const double base = std::max(least_threshold, kNoiseFactor * noise_);
  cv::Mat threshold;
  unrest_.convertTo(threshold, CV_32F, kUnrestFactor);
  cv::min(cv::max(threshold, base), kMostUnrest * base, threshold);
  cv::Mat difference;
  out.difference.convertTo(difference, CV_32F);
  out.differs = difference > threshold;
  // From 0 at the threshold to 255.
  cv::Mat sure;
  cv::divide(difference - threshold, threshold * (kSureFactor - 1), sure, 255);
  sure.convertTo(out.certainty, CV_8U);
  return out;
}

}  // namespace choreo::vision

// SPDX-License-Identifier: Apache-2.0
#include "support/outdoors.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace choreo::test {
namespace {

void draw_leaves(cv::Mat& picture, const cv::Rect& tree, int count) {
  picture(tree).setTo(cv::Scalar(235, 220, 200));
  cv::RNG random(3);
  for (int k = 0; k < count; ++k) {
    const cv::Point at(random.uniform(tree.x + 6, tree.br().x), random.uniform(tree.y, tree.br().y - 6));
    const auto green = k % 2 == 0 ? cv::Scalar(40, 90, 50) : cv::Scalar(60, 140, 80);
    cv::ellipse(picture, at, {random.uniform(2, 5), random.uniform(1, 3)}, random.uniform(0.0, 180.0), 0, 360, green,
                cv::FILLED, cv::LINE_AA);
  }
}

// The boughs in `tree`, displaced.
cv::Mat in_the_wind(const cv::Mat& still, const cv::Rect& tree, double time_s, double sway) {
  cv::Mat x(still.size(), CV_32F), y(still.size(), CV_32F);
  for (int v = 0; v < still.rows; ++v) {
    for (int u = 0; u < still.cols; ++u) {
      const bool moves = tree.contains({u, v});
      const double phase = 0.13 * u + 0.09 * v;
      x.at<float>(v, u) = float(u + (moves ? sway * std::sin(7 * time_s + phase) : 0));
      y.at<float>(v, u) = float(v + (moves ? 0.6 * sway * std::sin(9 * time_s + 1.7 * phase) : 0));
    }
  }
  cv::Mat picture;
  cv::remap(still, picture, x, y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return picture;
}

cv::Mat with_noise(const cv::Mat& picture, unsigned seed) {
  cv::Mat noise(picture.size(), CV_16SC3), out;
  cv::RNG random(seed);
  random.fill(noise, cv::RNG::NORMAL, cv::Scalar::all(0), cv::Scalar::all(2));
  cv::add(picture, noise, out, {}, CV_8U);
  return out;
}

// Sets what is inside of the picture.
void draw(cv::Mat& picture, cv::Mat& truth, cv::Rect where, const cv::Scalar& colour) {
  where &= cv::Rect({0, 0}, picture.size());
  if (where.empty()) return;
  picture(where).setTo(colour);
  truth(where).setTo(255);
}

void darken(cv::Mat& picture, cv::Mat& truth, cv::Rect where) {
  where &= cv::Rect({0, 0}, picture.size());
  if (where.empty()) return;
  cv::Mat part = picture(where);
  part.convertTo(part, -1, 0.6);
  truth(where).setTo(128);
}

}  // namespace

Scene garden(double sway_px, double seconds) {
  cv::Mat still(kOutdoorsSize, CV_8UC3, cv::Scalar(150, 160, 170));
  draw_leaves(still, kTree, 500);
  Scene scene;
  for (int k = 0; k < seconds * kOutdoorsFps; ++k) {
    const double time_s = double(k) / kOutdoorsFps;
    auto picture = with_noise(in_the_wind(still, kTree, time_s, sway_px), unsigned(k));
    cv::Mat truth = cv::Mat::zeros(kOutdoorsSize, CV_8UC1);
    const cv::Point at(cvRound(-20 + 30 * (time_s - 6)), 30);
    draw(picture, truth, cv::Rect(6, 0, 10, 12) + at, {130, 160, 210});
    draw(picture, truth, cv::Rect(0, 12, 22, 35) + at, {50, 40, 180});
    draw(picture, truth, cv::Rect(3, 47, 16, 40) + at, {120, 50, 40});
    scene.pictures.push_back(picture);
    scene.truths.push_back(truth);
  }
  return scene;
}

Scene road(double seconds) {
  const cv::Rect tree(0, 0, 60, 30);
  cv::Mat still(kOutdoorsSize, CV_8UC3, cv::Scalar(120, 122, 124));
  still(cv::Rect(0, 0, 160, 30)).setTo(cv::Scalar(70, 120, 90));
  draw_leaves(still, tree, 200);
  for (int x = 0; x < 160; x += 24) cv::rectangle(still, cv::Rect(x, 73, 12, 2), {220, 225, 225}, cv::FILLED);
  const std::vector<cv::Scalar> colours = {{40, 40, 45},    {235, 235, 235}, {40, 30, 160}, {140, 80, 30},
                                           {160, 165, 170}, {30, 90, 40},    {60, 160, 200}};
  constexpr double kEvery_s = 1.5;
  Scene scene;
  for (int k = 0; k < seconds * kOutdoorsFps; ++k) {
    const double time_s = double(k) / kOutdoorsFps;
    auto picture = in_the_wind(still, tree, time_s, 2);
    cv::Mat truth = cv::Mat::zeros(kOutdoorsSize, CV_8UC1);
    for (int lane = 0; lane < 2; ++lane) {
      const double speed = lane == 0 ? 60 : -75;
      const int top = lane == 0 ? 42 : 84;
      const int last = int(time_s / kEvery_s);
      for (int car = std::max(0, last - 3); car <= last; ++car) {
        const double way = speed * (time_s - car * kEvery_s - 0.4 * lane);
        const cv::Point at(cvRound(lane == 0 ? way - 50 : 165 + way), top);
        darken(picture, truth, cv::Rect(2, 16, 44, 6) + at);
        draw(picture, truth, cv::Rect(0, 6, 46, 11) + at, colours[std::size_t(car + 3 * lane) % colours.size()]);
        draw(picture, truth, cv::Rect(9, 0, 26, 7) + at, {90, 80, 70});
      }
    }
    scene.pictures.push_back(with_noise(picture, unsigned(k)));
    scene.truths.push_back(truth);
  }
  return scene;
}

double f_measure(std::span<const cv::Mat> masks, std::span<const cv::Mat> truths) {
  double both = 0, found = 0, there = 0;
  for (std::size_t k = 0; k < masks.size(); ++k) {
    const cv::Mat counts = truths[k] != 128, is = truths[k] == 255;
    both += cv::countNonZero(masks[k] & is);
    found += cv::countNonZero(masks[k] & counts);
    there += cv::countNonZero(is);
  }
  return 2 * both / (found + there);
}

}  // namespace choreo::test

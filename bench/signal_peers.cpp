// SPDX-License-Identifier: Apache-2.0
#include "signal_peers.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "pipeline/face_models.hpp"

namespace choreo::bench {
namespace {

const cv::Mat& small_square() {
  static const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {3, 3});
  return square;
}

// The middle of a face, without hair.
cv::Rect skin_of(const vision::TrackedFace& face, cv::Size size) {
  const auto side = static_cast<int>(face.width / 2);
  return cv::Rect(static_cast<int>(face.centre.x) - side / 2, static_cast<int>(face.centre.y) - side / 2, side, side) &
         cv::Rect({0, 0}, size);
}

// Components by their areas, the largest first, without the background.
std::vector<int> by_area(const cv::Mat& statistics) {
  std::vector<int> order;
  for (int i = 1; i < statistics.rows; ++i) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return statistics.at<int>(a, cv::CC_STAT_AREA) > statistics.at<int>(b, cv::CC_STAT_AREA);
  });
  return order;
}

// (s cos 2 pi h, s sin 2 pi h) of every pixel, as two planes.
void colour_plane(const cv::Mat& picture, cv::Mat& x, cv::Mat& y) {
  cv::Mat scaled;
  picture.convertTo(scaled, CV_32F, 1.0 / 255);
  cv::Mat hsv;
  cv::cvtColor(scaled, hsv, cv::COLOR_BGR2HSV);
  std::array<cv::Mat, 3> planes;
  cv::split(hsv, planes.data());
  cv::polarToCart(planes[1], planes[0], x, y, true);
}

}  // namespace

cv::Mat PeerMask::operator()(const cv::Mat& picture) const {
  cv::Mat difference;
  cv::absdiff(picture, room_, difference);
  cv::Mat grey;
  cv::cvtColor(difference, grey, cv::COLOR_BGR2GRAY);
  cv::Mat mask;
  cv::threshold(grey, mask, threshold_, 255, cv::THRESH_BINARY);
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, small_square());
  cv::Mat labels;
  cv::Mat statistics;
  cv::Mat centroids;
  cv::connectedComponentsWithStats(mask, labels, statistics, centroids);
  const auto order = by_area(statistics);
  if (order.empty()) return mask;
  return labels == order.front();
}

PeerFaces::PeerFaces(int least_px, int most_px) : least_px_(least_px), most_px_(most_px) {
  const auto path = std::string(pipeline::kCascadeFolder) + "/haarcascade_frontalface_alt.xml";
  if (!cascade_.load(path)) throw failure("\"" + path + "\" cannot be read");
}

std::vector<cv::Rect> PeerFaces::operator()(const cv::Mat& picture) {
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  std::vector<cv::Rect> faces;
  cascade_.detectMultiScale(grey, faces, 1.1, 3, 0, {least_px_, least_px_}, {most_px_, most_px_});
  return faces;
}

PeerBackProjection::PeerBackProjection(const cv::Mat& picture, const vision::TrackedFace& face) {
  cv::Mat hsv;
  cv::cvtColor(picture(skin_of(face, picture.size())), hsv, cv::COLOR_BGR2HSV);
  cv::calcHist(std::vector<cv::Mat>{hsv}, {0, 1}, {}, histogram_, {30, 32}, {0, 180, 0, 256});
  cv::normalize(histogram_, histogram_, 0, 255, cv::NORM_MINMAX);
}

cv::Mat PeerBackProjection::operator()(const cv::Mat& picture, const cv::Mat& mask) const {
  cv::Mat hsv;
  cv::cvtColor(picture, hsv, cv::COLOR_BGR2HSV);
  cv::Mat likelihood;
  cv::calcBackProject(std::vector<cv::Mat>{hsv}, {0, 1}, histogram_, likelihood, {0, 180, 0, 256}, 1);
  cv::bitwise_and(likelihood, mask, likelihood);
  return likelihood;
}

PeerGaussian::PeerGaussian(const cv::Mat& picture, const vision::TrackedFace& face) {
  cv::Mat x;
  cv::Mat y;
  colour_plane(picture(skin_of(face, picture.size())), x, y);
  cv::Mat samples(static_cast<int>(x.total()), 2, CV_32F);
  x.clone().reshape(1, samples.rows).copyTo(samples.col(0));
  y.clone().reshape(1, samples.rows).copyTo(samples.col(1));
  cv::Mat covariance;
  cv::Mat mean;
  cv::calcCovarMatrix(samples, covariance, mean, cv::COVAR_NORMAL | cv::COVAR_ROWS | cv::COVAR_SCALE, CV_32F);
  covariance += 0.003 * cv::Mat::eye(2, 2, CV_32F);
  mean_ = {mean.at<float>(0), mean.at<float>(1)};
  const cv::Mat inverse = covariance.inv();
  inverse.copyTo(cv::Mat(inverse_, false));
  peak_ = static_cast<float>(1 / (2 * std::numbers::pi * std::sqrt(cv::determinant(covariance))));
}

cv::Mat PeerGaussian::operator()(const cv::Mat& picture, const cv::Mat& mask) const {
  cv::Mat x;
  cv::Mat y;
  colour_plane(picture, x, y);
  x -= mean_[0];
  y -= mean_[1];
  const cv::Mat exponent = -0.5 * (inverse_(0, 0) * x.mul(x) + inverse_(1, 1) * y.mul(y)) - inverse_(0, 1) * x.mul(y);
  cv::Mat skin;
  cv::exp(exponent, skin);
  skin *= 0.3 * double(peak_);
  const cv::Mat posterior = skin / (skin + 0.5 / std::numbers::pi);
  cv::Mat out;
  posterior.convertTo(out, CV_8U, 255);
  cv::bitwise_and(out, mask, out);
  return out;
}

std::array<cv::Moments, 2> peer_arms(const cv::Mat& posterior, const cv::Mat& mask, const vision::TrackedFace& face) {
  cv::Mat arms;
  cv::threshold(posterior, arms, 127, 255, cv::THRESH_BINARY);
  cv::bitwise_and(arms, mask, arms);
  cv::morphologyEx(arms, arms, cv::MORPH_CLOSE, small_square());
  const cv::Size half(static_cast<int>(0.72 * face.width), static_cast<int>(face.width));
  cv::ellipse(arms, cv::Point(face.centre), half, 0, 0, 360, 0, cv::FILLED);
  cv::Mat labels;
  cv::Mat statistics;
  cv::Mat centroids;
  cv::connectedComponentsWithStats(arms, labels, statistics, centroids);
  const auto order = by_area(statistics);
  std::array<cv::Moments, 2> found;
  for (std::size_t k = 0; k < std::min(found.size(), order.size()); ++k) {
    found[k] = cv::moments(labels == order[k], true);
  }
  return found;
}

PeerRow::PeerRow(const std::vector<body::ParticleState>& states, std::size_t rows)
    : psi_(static_cast<int>(rows), body::kParticleValues, CV_32F), query_(body::kParticleValues, 2, CV_32F) {
  for (int i = 0; i < psi_.rows; ++i) {
    auto row = psi_.row(i);
    for (int k = 0; k < psi_.cols; ++k) {
      row.at<float>(k) = static_cast<float>(states[std::size_t(i) % states.size()].psi()[std::size_t(k)]);
    }
    row /= cv::norm(row);
  }
}

const cv::Mat& PeerRow::operator()(const body::ParticleState& state) {
  for (int k = 0; k < psi_.cols; ++k) {
    const auto value = static_cast<float>(state.psi()[std::size_t(k)]);
    query_.at<float>(k, 0) = value;
    query_.at<float>(k, 1) = static_cast<float>(body::kParticleMirrorSigns[std::size_t(k)]) * value;
  }
  query_ /= cv::norm(query_.col(0));
  cv::gemm(psi_, query_, 1, {}, 0, product_);
  cv::max(product_, 0, product_);
  cv::min(product_, 1, product_);
  return product_;
}

}  // namespace choreo::bench

// SPDX-License-Identifier: Apache-2.0
// What a signaller's stages do, done by plain OpenCV calls in the obvious way: the peers of the benchmark `signals`.
#pragma once

#include <array>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/objdetect.hpp>

#include "body/particle_state.hpp"
#include "vision/face.hpp"

namespace choreo::bench {

/// Difference from the empty room, grey, threshold, a closing, the largest component.
class PeerMask {
 public:
  PeerMask(cv::Mat room, double threshold) : room_(std::move(room)), threshold_(threshold) {}
  [[nodiscard]] cv::Mat operator()(const cv::Mat& picture) const;

 private:
  cv::Mat room_;
  double threshold_;
};

/// CascadeClassifier::detectMultiScale with OpenCV's defaults over the whole picture, of the same widths of faces and
/// with the same cascade.
class PeerFaces {
 public:
  /// @param least_px, most_px  of the cascade's windows.
  PeerFaces(int least_px, int most_px);
  [[nodiscard]] std::vector<cv::Rect> operator()(const cv::Mat& picture);

 private:
  cv::CascadeClassifier cascade_;
  int least_px_, most_px_;
};

/// Skin as a histogram of hue and saturation, cv::calcBackProject.
class PeerBackProjection {
 public:
  /// @param face  in the picture whose skin is learned.
  PeerBackProjection(const cv::Mat& picture, const vision::TrackedFace& face);
  [[nodiscard]] cv::Mat operator()(const cv::Mat& picture, const cv::Mat& mask) const;

 private:
  cv::Mat histogram_;
};

/// Skin as a Gaussian in the plane of hue and saturation against an even outlier class, reckoned at every pixel:
/// cvtColor, polarToCart, arithmetic on matrices, cv::exp.
class PeerGaussian {
 public:
  PeerGaussian(const cv::Mat& picture, const vision::TrackedFace& face);
  [[nodiscard]] cv::Mat operator()(const cv::Mat& picture, const cv::Mat& mask) const;

 private:
  cv::Vec2f mean_;
  cv::Matx22f inverse_;
  float peak_ = 0;
};

/// The moments of the two largest components beside the face: threshold, closing, connectedComponentsWithStats, and
/// cv::moments of each.
[[nodiscard]] std::array<cv::Moments, 2> peer_arms(const cv::Mat& posterior, const cv::Mat& mask,
                                                   const vision::TrackedFace& face);

/// A state against a matrix of states, for Z and Z*: cv::gemm, norms, limits.
class PeerRow {
 public:
  /// @param states  as many rows, from the beginning again where there are fewer.
  PeerRow(const std::vector<body::ParticleState>& states, std::size_t rows);
  /// @return rows x 2: Z, Z*.
  [[nodiscard]] const cv::Mat& operator()(const body::ParticleState& state);

 private:
  cv::Mat psi_;      // CV_32F, rows x 15, of unit length.
  cv::Mat query_;    // 15 x 2
  cv::Mat product_;  // rows x 2
};

}  // namespace choreo::bench

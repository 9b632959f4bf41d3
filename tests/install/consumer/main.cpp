// SPDX-License-Identifier: Apache-2.0
// The mathematics as a library: two silhouettes, one the other's mirror image.
#include <body/mask_state.hpp>

int main() {
  const cv::Mat left = (cv::Mat_<unsigned char>(2, 3) << 1, 1, 1, 1, 0, 0);
  const cv::Mat right = (cv::Mat_<unsigned char>(2, 3) << 1, 1, 1, 0, 0, 1);
  const choreo::body::MaskState a(left);
  const choreo::body::MaskState b(right);
  return mirror_similarity(a, b) == 1.0 && similarity(a, b) < 1.0 ? 0 : 1;
}

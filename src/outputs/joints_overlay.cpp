// SPDX-License-Identifier: Apache-2.0
#include "outputs/joints_overlay.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "outputs/plot_canvas.hpp"

namespace choreo::outputs {
namespace {

using Name = vision::PersonPointName;

// The person's own left is drawn in another colour than the right: which way they face shows at a glance.
constexpr Rgb kLeft{0.25, 0.85, 1.0};
constexpr Rgb kRight{1.0, 0.62, 0.15};
constexpr Rgb kMiddle{0.96, 0.96, 0.95};

struct Bone {
  Name from, to;
  Rgb colour;
};
constexpr std::array kBones = {Bone{Name::kLeftShoulder, Name::kRightShoulder, kMiddle},
                               Bone{Name::kLeftHip, Name::kRightHip, kMiddle},
                               Bone{Name::kLeftEar, Name::kNose, kLeft},
                               Bone{Name::kRightEar, Name::kNose, kRight},
                               Bone{Name::kLeftShoulder, Name::kLeftHip, kLeft},
                               Bone{Name::kRightShoulder, Name::kRightHip, kRight},
                               Bone{Name::kLeftShoulder, Name::kLeftElbow, kLeft},
                               Bone{Name::kRightShoulder, Name::kRightElbow, kRight},
                               Bone{Name::kLeftElbow, Name::kLeftWrist, kLeft},
                               Bone{Name::kRightElbow, Name::kRightWrist, kRight},
                               Bone{Name::kLeftHip, Name::kLeftKnee, kLeft},
                               Bone{Name::kRightHip, Name::kRightKnee, kRight},
                               Bone{Name::kLeftKnee, Name::kLeftAnkle, kLeft},
                               Bone{Name::kRightKnee, Name::kRightAnkle, kRight}};

}  // namespace

cv::Mat joints_drawn_over(const cv::Mat& picture, const vision::PersonLook& look, double scale) {
  constexpr double kSeen = 0.5;
  PixelCanvas canvas(picture.cols, picture.rows);
  canvas.image(picture, {0, 0, double(picture.cols), double(picture.rows)}, Scaling::kCrisp, {});
  const double pen = std::max(1.5, picture.rows / 160.0);
  const auto place = [&](Name name) {
    const auto at = scale * (look[name].at + cv::Point2d(0.5, 0.5));  // Cairo counts from the first pixel's border.
    return Point{at.x, at.y};
  };
  for (const auto& bone : kBones) {
    if (look[bone.from].visibility < kSeen || look[bone.to].visibility < kSeen) continue;
    canvas.stroke(std::array{place(bone.from), place(bone.to)}, false, pen, bone.colour);
  }
  return canvas.bgr();
}

}  // namespace choreo::outputs

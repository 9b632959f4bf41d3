// SPDX-License-Identifier: Apache-2.0
#include "outputs/particles_csv.hpp"

#include <array>
#include <iterator>

#include <fmt/format.h>

namespace choreo::outputs {
namespace {

constexpr std::array<const char*, 11> kArmColumns = {
    "area_px", "x_px", "y_px", "cov_xx_px2", "cov_xy_px2", "cov_yy_px2", "c_x", "c_y", "zeta_0", "zeta_1", "zeta_2"};

class Line {
 public:
  explicit Line(std::string& csv) : csv_(csv) {}

  void pixels(double value) { fmt::format_to(std::back_inserter(csv_), ",{:.3f}", value); }
  void number(double value) {
    // Minus nothing is nothing.
    fmt::format_to(std::back_inserter(csv_), ",{:.9g}", value + 0.0);
  }
  void numbers(const auto& values) {
    for (const double value : values) number(value);
  }
  void nothing(std::size_t fields) { csv_.append(fields, ','); }

 private:
  std::string& csv_;
};

std::string header() {
  std::string csv = "frame,time_s,face_x_px,face_y_px,face_width_px,face_height_px,arms,at_face,pieced";
  for (const char* arm : {"arm1", "arm2"}) {
    for (const char* column : kArmColumns) csv += fmt::format(",{}_{}", arm, column);
  }
  csv += ",alpha_x,alpha_y,nu_0,nu_1,nu_2,eta_x,eta_y,u_0,u_1,u_2";
  for (int k = 0; k < body::kParticleValues; ++k) csv += fmt::format(",psi_{}", k);
  return csv + "\n";
}

std::size_t arms_of(vision::ArmCase found) {
  if (found == vision::ArmCase::kTwoArms) return 2;
  return found == vision::ArmCase::kOneArm || found == vision::ArmCase::kJoined ? 1 : 0;
}

}  // namespace

std::string particles_csv(std::span<const ParticleRow> rows) {
  std::string csv = header();
  for (const auto& r : rows) {
    Line line(csv);
    fmt::format_to(std::back_inserter(csv), "{},{:.6f}", r.frame, r.time_s);
    if (r.face) {
      line.pixels(r.face->centre.x - r.face->width / 2);
      line.pixels(r.face->centre.y - r.face->width / 2);
      line.pixels(r.face->width);
      line.pixels(r.face->width);
    } else {
      line.nothing(4);
    }
    fmt::format_to(std::back_inserter(csv), ",{},{:d},{:d}", vision::name_of(r.arms.found), r.arms.at_face,
                   r.arms.pieced);
    for (std::size_t arm = 0; arm < 2; ++arm) {
      if (arm >= arms_of(r.arms.found)) {
        line.nothing(kArmColumns.size());
        continue;
      }
      const auto& m = r.arms.blob[arm].moments;
      fmt::format_to(std::back_inserter(csv), ",{:.0f}", m.m00);
      line.pixels(m.centroid.x);
      line.pixels(m.centroid.y);
      line.numbers(std::array{m.mu20 / m.m00, m.mu11 / m.m00, m.mu02 / m.m00});
      if (r.state) {
        line.numbers(r.state->parts().c[arm]);
        line.numbers(r.state->parts().zeta[arm]);
      } else {
        line.nothing(5);
      }
    }
    if (r.state) {
      const auto& p = r.state->parts();
      line.numbers(p.alpha);
      line.numbers(p.nu);
      line.numbers(p.eta);
      line.numbers(p.u);
      line.numbers(r.state->psi());
    } else {
      line.nothing(10 + std::size_t(body::kParticleValues));
    }
    csv += '\n';
  }
  return csv;
}

}  // namespace choreo::outputs

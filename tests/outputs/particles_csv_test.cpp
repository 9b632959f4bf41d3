// SPDX-License-Identifier: Apache-2.0
// The table of the particles, character by character.
#include "outputs/particles_csv.hpp"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace choreo::outputs {
namespace {

using vision::ArmCase;

std::vector<std::string> lines_of(const std::string& csv) {
  std::vector<std::string> lines;
  std::size_t at = 0;
  while (at < csv.size()) {
    const auto end = csv.find('\n', at);
    lines.push_back(csv.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',') {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

// The field of that column, of the only row.
std::string field(const ParticleRow& row, const std::string& column) {
  const auto lines = lines_of(particles_csv(std::vector{row}));
  const auto names = fields_of(lines.at(0));
  const auto found = std::find(names.begin(), names.end(), column);
  if (found == names.end()) return "no such column";
  return fields_of(lines.at(1)).at(std::size_t(found - names.begin()));
}

ParticleRow row_of(ArmCase found) {
  ParticleRow row;
  row.frame = 7;
  row.time_s = 0.2;
  row.face.emplace();
  row.face->centre = {100, 50};
  row.face->width = 20;
  row.arms.found = found;
  const auto blob = [](double x) {
    vision::Blob b;
    b.moments.m00 = 10;
    b.moments.centroid = {x, 70};
    b.moments.mu20 = 400;
    b.moments.mu11 = 50;
    b.moments.mu02 = 100;
    return b;
  };
  row.arms.blob = {blob(40), blob(160)};
  row.state = body::particle_state_of(row.arms, row.face);
  return row;
}

TEST(ParticlesCsv, OfNoFramesIsTheHeaderAlone) {
  EXPECT_EQ(particles_csv({}),
            "frame,time_s,face_x_px,face_y_px,face_width_px,face_height_px,arms,at_face,pieced,"
            "arm1_area_px,arm1_x_px,arm1_y_px,arm1_cov_xx_px2,arm1_cov_xy_px2,arm1_cov_yy_px2,arm1_c_x,arm1_c_y,"
            "arm1_zeta_0,arm1_zeta_1,arm1_zeta_2,"
            "arm2_area_px,arm2_x_px,arm2_y_px,arm2_cov_xx_px2,arm2_cov_xy_px2,arm2_cov_yy_px2,arm2_c_x,arm2_c_y,"
            "arm2_zeta_0,arm2_zeta_1,arm2_zeta_2,"
            "alpha_x,alpha_y,nu_0,nu_1,nu_2,eta_x,eta_y,u_0,u_1,u_2,"
            "psi_0,psi_1,psi_2,psi_3,psi_4,psi_5,psi_6,psi_7,psi_8,psi_9,psi_10,psi_11,psi_12,psi_13,psi_14\n");
}

TEST(ParticlesCsv, TwoArmsHaveEveryNumber) {
  const auto row = row_of(ArmCase::kTwoArms);
  const auto line = lines_of(particles_csv(std::vector{row})).at(1);
  EXPECT_EQ(line.substr(0, line.find(",0.0375,")),
            "7,0.200000,90.000,40.000,20.000,20.000,two_arms,0,0,10,40.000,70.000,40,5,10");
  EXPECT_EQ(field(row, "arm1_c_x"), "0.0375");   // (40 - 10) / 2 / 400
  EXPECT_EQ(field(row, "arm1_c_y"), "-0.0125");  // 5 / 400, y up
  EXPECT_EQ(field(row, "arm2_x_px"), "160.000");
  EXPECT_EQ(field(row, "alpha_x"), "-3");
  EXPECT_EQ(field(row, "alpha_y"), "0");
  EXPECT_EQ(field(row, "nu_1"), "-0.8");
  EXPECT_EQ(field(row, "eta_y"), "-1");
  for (const auto& text : fields_of(line)) EXPECT_NE(text, "");
}

TEST(ParticlesCsv, JoinedArmsAreTheFirstAloneAndHaveAState) {
  const auto row = row_of(ArmCase::kJoined);
  EXPECT_EQ(field(row, "arms"), "joined");
  EXPECT_EQ(field(row, "arm1_area_px"), "10");
  EXPECT_EQ(field(row, "arm2_area_px"), "");
  EXPECT_EQ(field(row, "arm2_zeta_2"), "");
  EXPECT_EQ(field(row, "alpha_x"), "0");
  EXPECT_EQ(field(row, "nu_0"), "1");
  EXPECT_EQ(field(row, "psi_14"), "0");
}

TEST(ParticlesCsv, OneArmHasItsPlaceButNoState) {
  auto row = row_of(ArmCase::kOneArm);
  row.arms.at_face = true;
  EXPECT_EQ(field(row, "arms"), "one_arm");
  EXPECT_EQ(field(row, "at_face"), "1");
  EXPECT_EQ(field(row, "arm1_y_px"), "70.000");
  for (const auto* column : {"arm1_c_x", "arm2_area_px", "alpha_x", "psi_0"}) EXPECT_EQ(field(row, column), "");
}

TEST(ParticlesCsv, WithoutAFaceOnlyTheTimeIsKnownEvenWhereNumbersAreLeftOver) {
  auto row = row_of(ArmCase::kNoFace);
  row.face.reset();
  const auto lines = lines_of(particles_csv(std::vector{row, row}));
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[1], "7,0.200000,,,,,no_face,0,0" + std::string(2 * 11 + 25, ','));
  EXPECT_EQ(fields_of(lines[1]).size(), fields_of(lines[0]).size());
}

}  // namespace
}  // namespace choreo::outputs

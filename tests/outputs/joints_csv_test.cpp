// SPDX-License-Identifier: Apache-2.0
#include "outputs/joints_csv.hpp"

#include <sstream>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace choreo::outputs {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream in(text + at);
  for (std::string part; std::getline(in, part, at);) parts.push_back(part);
  return parts;
}

vision::PersonLook look_with(double wrist_x) {
  vision::PersonLook look;
  look.score = 0.9;
  look.points[15] = {{wrist_x, 20}, 1, 0.5, 1};
  look.metres[15] = {0.1, -0.2, 0.3};
  return look;
}

TEST(JointsCsv, HasEveryPointOfEveryFrameAndLinearOnesBetweenLooks) {
  const auto first = look_with(10);
  const auto second = look_with(14);
  const std::vector<JointsLook> looks = {{0.1, &first}, {0.3, &second}, {0.5, nullptr}};
  const std::vector<JointsFrame> frames = {{1, 0.0}, {2, 0.1}, {3, 0.15}, {4, 0.3}, {5, 0.4}, {6, 0.5}, {7, 0.6}};
  const auto csv = joints_csv(frames, looks);
  auto lines = split(csv.substr(0, csv.size() - 1), '\n');
  ASSERT_THAT(lines, SizeIs(8));
  const auto header = split(lines[0], ',');
  ASSERT_THAT(header, SizeIs(4 + 6 * 33));
  const auto at = std::size_t(std::find(header.begin(), header.end(), "left_wrist_x_px") - header.begin());
  ASSERT_LT(at + 5, header.size());
  EXPECT_EQ(header[at + 5], "left_wrist_z_m");
  const auto wrist = [&](std::size_t line) {
    const auto fields = split(lines[line], ',');
    EXPECT_EQ(fields.size(), header.size()) << line;
    return std::vector<std::string>(fields.begin() + std::ptrdiff_t(at), fields.begin() + std::ptrdiff_t(at) + 6);
  };
  const auto nothing = ElementsAre("", "", "", "", "", "");
  EXPECT_THAT(wrist(1), nothing) << "nobody looked yet";
  EXPECT_THAT(wrist(2), ElementsAre("10.00", "20.00", "0.500", "0.1000", "-0.2000", "0.3000"));
  EXPECT_EQ(wrist(3)[0], "11.00") << "a quarter of the way";
  EXPECT_EQ(wrist(4)[0], "14.00");
  EXPECT_THAT(wrist(5), nothing) << "at the next look nobody is there";
  EXPECT_THAT(wrist(6), nothing);
  EXPECT_THAT(wrist(7), nothing);
  std::vector<std::string> looked;
  for (std::size_t k = 1; k < lines.size(); ++k) looked.push_back(split(lines[k], ',')[2]);
  EXPECT_THAT(looked, ElementsAre("0", "1", "0", "1", "0", "1", "0"));
}

TEST(JointsCsv, WithoutFramesThereIsAHeader) { EXPECT_THAT(split(joints_csv({}, {}), '\n'), SizeIs(2)); }

}  // namespace
}  // namespace choreo::outputs

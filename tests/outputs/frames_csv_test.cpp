// SPDX-License-Identifier: Apache-2.0
// The table of the frames, character by character.
#include "outputs/frames_csv.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace choreo::outputs {
namespace {

const std::string kHeader =
    "frame,time_s,body,area_px,centroid_x_px,centroid_y_px,box_x_px,box_y_px,box_width_px,box_height_px,"
    "quantity_of_motion,contraction,zstar_tt\n";

TEST(FramesCsv, OfNoFramesIsTheHeaderAlone) { EXPECT_EQ(frames_csv({}), kHeader); }

TEST(FramesCsv, AFrameWithABodyHasEveryNumber) {
  FrameRow row;
  row.frame = 12;
  row.time_s = 0.4666666;
  row.body = true;
  row.area_px = 1234;
  row.centroid_px = {10.5, 20.25};
  row.box_px = {3, 4, 50, 60};
  row.quantity_of_motion = 0.125;
  row.contraction = 2.0 / 3.0;
  row.zstar_tt = 1.0F;
  EXPECT_EQ(frames_csv(std::vector{row}),
            kHeader + "12,0.466667,1,1234,10.500,20.250,3,4,50,60,0.125000,0.666667,1.000000\n");
}

TEST(FramesCsv, AFrameWithoutABodyHasGapsEvenWhereNumbersAreLeftOver) {
  FrameRow row;
  row.frame = 1;
  row.area_px = 99;
  row.zstar_tt = 0.5F;
  EXPECT_EQ(frames_csv(std::vector{row}), kHeader + "1,0.000000,0,nan,nan,nan,nan,nan,nan,nan,nan,nan,nan\n");
}

TEST(FramesCsv, EveryLineHasAsManyFieldsAsTheHeader) {
  std::vector<FrameRow> rows(5);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].frame = i * 1'000'000'000'000;
    rows[i].time_s = 1e6 * double(i);
    rows[i].body = i % 2 == 0;
    rows[i].centroid_px = {-3.5e5, 1e-9};
    rows[i].box_px = {-5, -6, 1, 1};
  }
  const auto csv = frames_csv(rows);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 6);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), ','), 6 * 12);
  EXPECT_EQ(csv.find_first_of("\r\" ;"), std::string::npos);
  EXPECT_EQ(csv.back(), '\n');
}

}  // namespace
}  // namespace choreo::outputs

// SPDX-License-Identifier: Apache-2.0
// Rows against the last seconds: what goes by time, what by number, and the same values as the batch.
#include "pipeline/stages/history_stage.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "pipeline/fakes.hpp"
#include "similarity/mask_comparer.hpp"
#include "similarity/particle_comparer.hpp"
#include "support/frames.hpp"
#include "support/particles.hpp"

namespace choreo::pipeline {
namespace {

using test::SimulatedClock;
using namespace std::chrono_literals;

const cv::Size kHistorySize{64, 48};

// A block that wanders and grows, another for every i.
std::unique_ptr<const body::MaskState> state_of(int i) {
  cv::Mat mask = cv::Mat::zeros(kHistorySize, CV_8UC1);
  mask(cv::Rect(5 + i % 20, 4 + i % 7, 10 + i % 13, 20 + i % 17)) = 255;
  mask(cv::Rect(30, 30, 1 + i % 5, 3)) = 255;
  return std::make_unique<const body::MaskState>(mask);
}

class HistoryStageTest : public ::testing::Test {
 protected:
  Observation passed(HistoryStage& stage, int i, Nanoseconds time, bool body = true) {
    Observation observation;
    observation.index = static_cast<std::uint64_t>(i);
    observation.time = time;
    if (body) observation.state = state_of(i);
    stage.process(observation);
    return observation;
  }

  SimulatedClock clock_;
  RowCost cost_;
};

TEST_F(HistoryStageTest, ARowIsThatOfTheBatchToTheLastBit) {
  similarity::MaskHistory history(kHistorySize, 100, similarity::choose_and_count());
  HistoryStage stage(history, 1h, clock_, nullptr);
  std::vector<std::unique_ptr<const body::MaskState>> states;
  for (int i = 0; i < 40; ++i) {
    const bool body = i % 9 != 4;
    const auto row = passed(stage, i, i * 40ms, body);
    states.push_back(body ? state_of(i) : nullptr);
    const similarity::MaskComparer batch(states, similarity::choose_and_count("scalar"));
    const std::size_t n = states.size();
    std::vector<float> z(n), zstar(n);
    batch.compare({n - 1, n}, {0, n}, {z.data(), 1, n}, {zstar.data(), 1, n});
    ASSERT_EQ(row.z_row.size(), n);
    for (std::size_t j = 0; j < n; ++j) {
      const bool gap = std::isnan(z[j]);
      ASSERT_TRUE(gap ? std::isnan(row.z_row[j]) && std::isnan(row.zstar_row[j])
                      : row.z_row[j] == z[j] && row.zstar_row[j] == zstar[j])
          << i << ", " << j;
    }
  }
}

TEST_F(HistoryStageTest, ParticleStatesAreComparedLikewiseAndMasksAreNotLookedAt) {
  const auto states = test::random_particle_sequence(40, 1);
  const similarity::ParticleComparer batch(states);
  similarity::ParticleHistory history(100);
  HistoryStage stage(history, 1h, clock_, &cost_);
  std::uint64_t with_state = 0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    Observation observation;
    observation.time = i * 40ms;
    observation.particles = states[i];
    if (i % 2 == 0) observation.state = state_of(int(i));
    stage.process(observation);
    with_state += states[i] ? 1 : 0;
    std::vector<float> z(i + 1), zstar(i + 1);
    batch.compare({i, i + 1}, {0, i + 1}, {z.data(), 1, i + 1}, {zstar.data(), 1, i + 1});
    ASSERT_EQ(observation.z_row.size(), i + 1);
    for (std::size_t j = 0; j <= i; ++j) {
      ASSERT_TRUE(std::isnan(z[j]) ? std::isnan(observation.z_row[j]) && std::isnan(observation.zstar_row[j])
                                   : observation.z_row[j] == z[j] && observation.zstar_row[j] == zstar[j])
          << i << ", " << j;
    }
  }
  EXPECT_EQ(cost_.filling().count, with_state);
}

TEST_F(HistoryStageTest, WhatIsOlderThanTheHistoryGoesByTimeNotByNumber) {
  similarity::MaskHistory history(kHistorySize, 100, similarity::choose_and_count());
  HistoryStage stage(history, 1s, clock_, nullptr);
  // Uneven times: half a second apart, then ten frames in a second, then a long pause.
  EXPECT_EQ(passed(stage, 0, 0ms).z_row.size(), 1u);
  EXPECT_EQ(passed(stage, 1, 500ms).z_row.size(), 2u);
  EXPECT_EQ(passed(stage, 2, 999ms).z_row.size(), 3u);
  EXPECT_EQ(passed(stage, 3, 1000ms).z_row.size(), 3u) << "a frame from a second ago is out";
  for (int i = 1; i <= 9; ++i) EXPECT_EQ(passed(stage, 3 + i, 1000ms + i * 50ms).z_row.size(), std::size_t(3 + i));
  EXPECT_EQ(passed(stage, 13, 1h).z_row.size(), 1u);
}

TEST_F(HistoryStageTest, MoreFramesThanDeclaredPushTheOldestOut) {
  similarity::MaskHistory history(kHistorySize, 5, similarity::choose_and_count());
  HistoryStage stage(history, 1h, clock_, &cost_);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(passed(stage, i, i * 10ms).z_row.size(), std::size_t(i + 1));
  EXPECT_EQ(cost_.full().count, 0u);
  for (int i = 5; i < 12; ++i) {
    const auto row = passed(stage, i, i * 10ms).z_row;
    ASSERT_EQ(row.size(), 5u);
    EXPECT_EQ(row[0], static_cast<float>(body::similarity(*state_of(i - 4), *state_of(i)))) << "the oldest left";
    EXPECT_EQ(row[4], 1.0F);
  }
  EXPECT_EQ(cost_.filling().count, 5u);
  EXPECT_EQ(cost_.full().count, 7u);
}

TEST_F(HistoryStageTest, FramesWithoutABodyTakeTheirPlaceAndCostNothing) {
  similarity::MaskHistory history(kHistorySize, 3, similarity::choose_and_count());
  HistoryStage stage(history, 1h, clock_, &cost_);
  passed(stage, 0, 0ms);
  const auto gap = passed(stage, 1, 10ms, false);
  ASSERT_EQ(gap.z_row.size(), 2u);
  EXPECT_TRUE(std::isnan(gap.z_row[0]) && std::isnan(gap.z_row[1]));
  const auto row = passed(stage, 2, 20ms).z_row;
  EXPECT_FALSE(std::isnan(row[0]));
  EXPECT_TRUE(std::isnan(row[1]));
  EXPECT_EQ(cost_.filling().count, 2u);
}

}  // namespace
}  // namespace choreo::pipeline

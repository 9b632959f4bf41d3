// SPDX-License-Identifier: Apache-2.0
// Whether the benchmarks run and what they write; how fast anything is, is never asserted.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/places.hpp"
#include "support/program.hpp"
#include "support/temp_folder.hpp"

namespace choreo::test {
namespace {

TEST(Bench, WritesItsRatiosByKey) {
  const TempFolder folder;
  const auto file = folder / "ratios.json";
  const auto run = run_program(built("choreoscope_bench"), {"--smoke", "--only", "kernels", "--json", file});
  ASSERT_EQ(run.status, 0) << run.told();
  EXPECT_NE(run.out.find("ours/peer"), std::string::npos) << run.told();
  const auto text = read_bytes(file);
  const auto ratios = nlohmann::json::parse(text.begin(), text.end());
  for (const auto* key : {"all_pairs_vs_opencv", "all_pairs_cropped_vs_opencv", "all_pairs_vs_popcount_limit",
                          "live_row_vs_stream_read"}) {
    ASSERT_TRUE(ratios.contains(key)) << key;
    EXPECT_GT(ratios[key].get<double>(), 0.0) << key;
  }
}

TEST(Bench, ASignallersFramesComeThroughAndEveryStageHasItsPeer) {
  const TempFolder folder;
  const auto file = folder / "signals.json";
  const auto run = run_program(built("choreoscope_bench"), {"--smoke", "--only", "signals", "--json", file});
  ASSERT_EQ(run.status, 0) << run.told();
  const auto text = read_bytes(file);
  const auto figures = nlohmann::json::parse(text.begin(), text.end());
  for (const auto* key : {"signals_fps", "signals_p99_ms_at_30", "signals_p99_ms_at_120", "signals_mask_vs_opencv",
                          "signals_face_vs_opencv", "signals_row_vs_opencv"}) {
    ASSERT_TRUE(figures.contains(key)) << key;
    EXPECT_GT(figures[key].get<double>(), 0.0) << key;
  }
}

TEST(Bench, AnUnknownNameIsRefusedAndTheKnownOnesAreListed) {
  const auto run = run_program(built("choreoscope_bench"), {"--only", "kernel"});
  EXPECT_EQ(run.status, 2) << run.told();
  EXPECT_NE(run.err.find("\"kernel\""), std::string::npos) << run.told();
  EXPECT_NE(run.err.find("kernels"), std::string::npos) << run.told();
  EXPECT_EQ(run.out, "");
}

TEST(Bench, AnUnknownOptionIsRefused) {
  const auto run = run_program(built("choreoscope_bench"), {"--fast"});
  EXPECT_EQ(run.status, 2) << run.told();
}

}  // namespace
}  // namespace choreo::test

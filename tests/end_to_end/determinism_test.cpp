// SPDX-License-Identifier: Apache-2.0
// The same replay gives the same bytes: on every run, with any number of threads, with every instruction set.
#include <gtest/gtest.h>

#include "end_to_end/choreoscope_run.hpp"
#include "similarity/and_count.hpp"

namespace choreo::test {
namespace {

// Exposure that drifts, a room that is empty first: everything that adapts has something to adapt to.
constexpr auto kClip = "synthetic://walking?size=320x240&fps=15&duration=2&seed=6&drift=20&flicker=3";

// Every file of a run; the summary without its timings.
std::map<std::string, std::string> bytes_of(const std::string& folder) {
  std::map<std::string, std::string> all;
  for (const auto& name : files_in(folder)) {
    const auto bytes = read_bytes(folder + "/" + name);
    all[name] = std::string(bytes.begin(), bytes.end());
  }
  auto summary = nlohmann::ordered_json::parse(all.at("summary.json"));
  EXPECT_EQ(summary.erase("timings"), 1u);
  all["summary.json"] = summary.dump();
  return all;
}

void expect_same(const std::map<std::string, std::string>& a, const std::map<std::string, std::string>& b,
                 const std::string& what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  for (const auto& [name, bytes] : a) EXPECT_TRUE(b.at(name) == bytes) << name << " differs: " << what;
}

TEST(Determinism, EveryRunAndEveryNumberOfThreadsWritesTheSameBytes) {
  const TempFolder folder;
  std::map<std::string, std::string> first;
  for (const auto* threads : {"1", "2", "2", "5"}) {
    const auto out = folder / threads;
    analyze(kClip, out, {"--threads", threads, "--save", "masks", "--set", "plot.svg=true"});
    const auto bytes = bytes_of(out);
    EXPECT_EQ(bytes.size(), 10u);
    if (first.empty()) first = bytes;
    expect_same(first, bytes, std::string("--threads ") + threads);
  }
}

TEST(Determinism, AVideoFileGivesTheSameBytesWithOneThreadAndWithMany) {
  const TempFolder folder;
  const auto clip = folder / "clip.mp4";
  ASSERT_EQ(choreoscope({"synth", "palindrome?size=320x240&duration=2&seed=3", "-o", clip}).status, 0);
  analyze(clip, folder / "one", {"--threads", "1"});
  analyze(clip, folder / "many", {"--threads", "4"});
  expect_same(bytes_of(folder / "one"), bytes_of(folder / "many"), "video file");
}

TEST(Determinism, EveryInstructionSetGivesTheSameMatricesAndIsTheOneThatRan) {
  const TempFolder folder;
  std::map<std::string, std::string> specification;
  auto kernels = similarity::and_count_kernels();
  std::reverse(kernels.begin(), kernels.end());
  ASSERT_EQ(kernels.front().name, "scalar");
  EXPECT_GE(kernels.size(), 2u) << "only the specification is compiled in";
  for (const auto& kernel : kernels) {
    RunOptions options;
    options.environment = {{"CHOREO_FORCE_ISA", kernel.name}};
    analyze(kClip, folder / kernel.name, {"--set", "plot.width_px=320"}, options);
    EXPECT_EQ(Results(folder / kernel.name).summary["timings"]["instruction_set"], kernel.name);
    const auto bytes = bytes_of(folder / kernel.name);
    if (specification.empty()) specification = bytes;
    expect_same(specification, bytes, kernel.name);
  }
}

}  // namespace
}  // namespace choreo::test

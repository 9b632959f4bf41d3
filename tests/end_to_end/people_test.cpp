// SPDX-License-Identifier: Apache-2.0
// Joints by the person network, of recordings and of live runs; skipped where script/run could not bring the network.
#include <algorithm>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "end_to_end/choreoscope_run.hpp"
#include "end_to_end/mask_truth.hpp"

namespace choreo::test {
namespace {

using ::testing::HasSubstr;

// A table by its columns' names; empty fields are none.
struct Table {
  explicit Table(const std::string& path) {
    const auto bytes = read_bytes(path);
    std::istringstream in(std::string(bytes.begin(), bytes.end()));
    std::vector<std::string> names;
    for (std::string line; std::getline(in, line);) {
      std::vector<std::string> fields;
      std::istringstream parts(line + ",");
      for (std::string field; std::getline(parts, field, ',');) fields.push_back(field);
      if (names.empty()) {
        names = fields;
        continue;
      }
      EXPECT_EQ(fields.size(), names.size());
      auto& row = rows.emplace_back();
      for (std::size_t k = 0; k < fields.size(); ++k) {
        if (!fields[k].empty()) row[names[k]] = std::strtod(fields[k].c_str(), nullptr);
      }
    }
  }
  std::vector<std::map<std::string, double>> rows;
};

class People : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto missing = missing_person_network();
    if (!missing.empty()) GTEST_SKIP() << "there is no " << missing << ": script/run brings it";
  }

  TempFolder folder_;
};

// The performer is in the room from 0.5 s on.
TEST_F(People, AnalyzeSavesTheJointsOfEveryFrame) {
  analyze_with_network("synthetic://side-kicks?size=320x240&fps=20&duration=4&empty=0.5", folder_ / "out",
                       {"--save", "joints", "--set", "segmentation=colour", "--set", "person.smooth_hz=1", "--set",
                        "person.smooth_hz_per_mps=0"});
  const Table joints(folder_ / "out/joints.csv");
  const Table smooth(folder_ / "out/joints_smooth.csv");
  const Table frames(folder_ / "out/frames.csv");
  ASSERT_EQ(joints.rows.size(), frames.rows.size());
  int seen = 0, bodies = 0, looks = 0;
  for (std::size_t k = 0; k < frames.rows.size(); ++k) {
    auto joint = joints.rows[k];
    EXPECT_EQ(joint["frame"], double(k + 1));
    EXPECT_EQ(joint["time_s"], frames.rows[k].at("time_s"));
    looks += joint["looked"] == 1 ? 1 : 0;
    const bool body = frames.rows[k].at("body") == 1;
    bodies += body ? 1 : 0;
    if (!joint.contains("nose_x_px")) continue;
    ++seen;
    EXPECT_GT(joint["score"], 0.5);
    EXPECT_LT(joint["nose_y_px"], joint["left_hip_y_px"]) << k;
    EXPECT_LT(joint["left_hip_y_px"], std::max(joint["left_ankle_y_px"], joint["right_ankle_y_px"])) << k;
    EXPECT_GT(joint["left_shoulder_x_px"], joint["right_shoulder_x_px"])
        << "who faces the camera has left on the right";
    EXPECT_NEAR(joint["left_hip_x_m"] + joint["right_hip_x_m"], 0, 0.02) << "metres begin between the hips";
  }
  EXPECT_NEAR(looks, 10 * joints.rows.back().at("time_s"), 2);
  // Kicks: the ankle goes its way more quietly, and no joint is there at other times.
  ASSERT_EQ(smooth.rows.size(), joints.rows.size());
  double raw_way = 0, smooth_way = 0;
  for (std::size_t k = 0; k < smooth.rows.size(); ++k) {
    ASSERT_EQ(smooth.rows[k].size(), joints.rows[k].size()) << k;
    if (k == 0 || !joints.rows[k].contains("left_ankle_x_px") || !joints.rows[k - 1].contains("left_ankle_x_px")) {
      continue;
    }
    const auto step = [k](const Table& table) {
      return std::abs(table.rows[k].at("left_ankle_x_px") - table.rows[k - 1].at("left_ankle_x_px"));
    };
    raw_way += step(joints);
    smooth_way += step(smooth);
  }
  EXPECT_GT(raw_way, 10);
  EXPECT_LT(smooth_way, 0.9 * raw_way);
  EXPECT_GT(smooth_way, 0.2 * raw_way);
  EXPECT_GT(bodies, 50);
  EXPECT_GE(seen, bodies * 9 / 10) << "of " << frames.rows.size();
  EXPECT_LE(seen, bodies + 4);
}

// Whether or not the empty room is ever seen.
TEST_F(People, MasksOfAPersonAreThePersonsAlone) {
  const std::string person = "segmentation=person";
  EXPECT_GT(mean_iou("synthetic://side-kicks?size=320x240&fps=15&duration=3&empty=0", {"--set", person}), 0.95);
  EXPECT_GT(mean_iou("synthetic://dancing?size=320x240&fps=15&duration=3&empty=1", {"--set", person}), 0.95);
}

TEST_F(People, CalibrateTakesMasksOfAPerson) {
  const auto run =
      choreoscope_with_network({"calibrate", "synthetic://semaphore?text=STAGE&fps=15&size=320x240&duration=4&empty=1",
                                "-o", folder_ / "bounds.toml", "--set", "segmentation=person"});
  EXPECT_EQ(run.status, 0) << run.told();
}

// As `live` does it: the first two seconds are the background's, and looks come late.
TEST_F(People, LiveMasksOfAPersonAreReplayedToTheLastBit) {
  const auto live = [&](const std::string& source, const std::string& out, std::vector<std::string> more) {
    std::vector<std::string> arguments = {"live",
                                          source,
                                          "--headless",
                                          "--out",
                                          folder_ / out,
                                          "--set",
                                          "segmentation=person",
                                          "--set",
                                          "plot.width_px=320"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto run = choreoscope_with_network(arguments);
    EXPECT_EQ(run.status, 0) << run.told();
  };
  live("synthetic://dancing?size=320x240&fps=30&duration=1.5&empty=2.1", "live", {"--record", folder_ / "take.mkv"});
  live((folder_ / "take.mkv") + "?frames=processed", "replay", {"--pace", "max"});
  EXPECT_TRUE(read_bytes(folder_ / "live/frames.csv") == read_bytes(folder_ / "replay/frames.csv"));
  EXPECT_TRUE(read_bytes(folder_ / "live/z.npy") == read_bytes(folder_ / "replay/z.npy"));
  int bodies = 0;
  for (const auto& row : Table(folder_ / "live/frames.csv").rows) bodies += row.at("body") == 1 ? 1 : 0;
  EXPECT_GT(bodies, 20);
}

// A look that is due at the next frame, 17 ms later, is rarely done by then.
TEST_F(People, ALiveRunWithLateLooksIsReplayedByteForByte) {
  const std::vector<std::string> settings = {
      "--joints", "--set", "person.delay_s=0.01", "--set", "person.network=lite", "--set", "plot.width_px=320"};
  const auto live = [&](const std::string& source, const std::string& out, std::vector<std::string> more) {
    std::vector<std::string> arguments = {"live", source, "--headless", "--out", folder_ / out};
    arguments.insert(arguments.end(), settings.begin(), settings.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto run = choreoscope_with_network(arguments);
    EXPECT_EQ(run.status, 0) << run.told();
  };
  live("synthetic://dancing?size=320x240&fps=60&duration=1&empty=2.1", "live", {"--record", folder_ / "take.mkv"});
  const auto bytes = read_bytes(folder_ / "take.mkv");
  const std::string mark = "late-person";
  EXPECT_NE(std::search(bytes.begin(), bytes.end(), mark.begin(), mark.end()), bytes.end())
      << "no look was late: the test proves nothing";
  live((folder_ / "take.mkv") + "?frames=processed", "replay", {"--pace", "max"});
  const auto was = read_bytes(folder_ / "live/joints.csv");
  EXPECT_GT(was.size(), 1000u);
  EXPECT_TRUE(was == read_bytes(folder_ / "replay/joints.csv"));
}

TEST(PeopleWithoutANetwork, AreRefusedBeforeAnythingIsRead) {
  const TempFolder folder;
  const auto without = [&](std::vector<std::string> arguments) {
    for (const auto* more : {"--headless", "--out"}) {
      if (arguments[0] == "analyze" && std::string(more) == "--headless") continue;
      arguments.emplace_back(more);
    }
    arguments.insert(arguments.end(), {folder / "out", "--set", "person.models=" + (folder / "none")});
    const auto run = choreoscope_with_network(arguments);
    EXPECT_THAT(complaint_of(run, 2), HasSubstr("there is no folder \"" + (folder / "none")));
    EXPECT_THAT(hint_of(run), HasSubstr("script/run brings them"));
    EXPECT_TRUE(files_in(folder.path()).empty());
  };
  without({"analyze", "synthetic://dancing?duration=1", "--save", "joints"});
  without({"analyze", "synthetic://dancing?duration=1", "--set", "segmentation=person"});
  without({"live", "synthetic://dancing?duration=1", "--joints"});
}

}  // namespace
}  // namespace choreo::test

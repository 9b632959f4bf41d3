// SPDX-License-Identifier: Apache-2.0
#include "pipeline/person_models.hpp"

#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/frames.hpp"
#include "support/temp_folder.hpp"
#include "vision/tiny_pose.hpp"

namespace choreo::pipeline {
namespace {

using test::error_of;
using ::testing::AllOf;
using ::testing::HasSubstr;

// Puts back what a test changes of the environment.
class Environment {
 public:
  Environment() {
    for (const char* name : {"XDG_CACHE_HOME", "HOME"}) {
      if (const char* value = std::getenv(name)) before_[name] = value;
    }
  }
  ~Environment() {
    for (const char* name : {"XDG_CACHE_HOME", "HOME"}) {
      const auto was = before_.find(name);
      (void)(was == before_.end() ? ::unsetenv(name) : ::setenv(name, was->second.c_str(), 1));
    }
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  std::map<std::string, std::string> before_;
};

TEST(PersonModels, AreFoundInTheCacheAsTheDesktopHasIt) {
  const Environment before;
  ASSERT_EQ(::setenv("XDG_CACHE_HOME", "/somewhere", 1), 0);
  EXPECT_EQ(usual_models_folder(), "/somewhere/choreoscope/models");
  ASSERT_EQ(::setenv("XDG_CACHE_HOME", "relative", 1), 0);
  ASSERT_EQ(::setenv("HOME", "/home/anybody", 1), 0);
  EXPECT_EQ(usual_models_folder(), "/home/anybody/.cache/choreoscope/models") << "relative ones do not count";
  ASSERT_EQ(::unsetenv("XDG_CACHE_HOME"), 0);
  EXPECT_EQ(usual_models_folder(), "/home/anybody/.cache/choreoscope/models");
}

TEST(PersonModels, AreNamedWhereTheyAreMissingDamagedOrOthers) {
  test::TempFolder folder;
  PersonModelOptions options;
  options.folder = folder.path();
  EXPECT_THAT(missing_person_models(options),
              AllOf(HasSubstr("pose_landmark_full.tflite"), HasSubstr("pose_detection.tflite")));
  const auto refused = [&](const std::string& file) {
    const auto error = error_of([&] { (void)load_person_search(options); });
    ASSERT_TRUE(error) << file;
    EXPECT_EQ(error->fault(), Fault::kUsage);
    EXPECT_THAT(error->what(), HasSubstr(folder / file));
    EXPECT_FALSE(error->hint().empty());
  };
  refused("pose_landmark_full.tflite");
  options.folder = folder / "nowhere";
  refused("nowhere");
  options.folder = folder.path();
  const auto landmarks = test::tiny_landmarks({});
  const auto detector = test::tiny_detector({}, {});
  test::write_bytes(folder / "pose_landmark_full.tflite", landmarks);
  refused("pose_detection.tflite");
  test::write_bytes(folder / "pose_detection.tflite", landmarks);
  refused("pose_detection.tflite");
  test::write_bytes(folder / "pose_detection.tflite", std::string());
  refused("pose_detection.tflite");
  test::write_bytes(folder / "pose_detection.tflite", detector);
  EXPECT_NO_THROW((void)load_person_search(options));
  EXPECT_EQ(missing_person_models(options), "");
  EXPECT_EQ(trouble_with_person_model(0, folder / "pose_landmark_full.tflite"), "");
  EXPECT_EQ(trouble_with_person_model(2, folder / "pose_detection.tflite"), "");
  EXPECT_THAT(trouble_with_person_model(2, folder / "pose_landmark_full.tflite"), HasSubstr("224 x 224"));
  options.quick = true;
  refused("pose_landmark_lite.tflite");
  std::filesystem::create_directory(folder / "pose_landmark_lite.tflite");
  refused("pose_landmark_lite.tflite");
}

}  // namespace
}  // namespace choreo::pipeline

// SPDX-License-Identifier: Apache-2.0
#include "pipeline/face_models.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "devices/synthetic/performer.hpp"
#include "support/frames.hpp"
#include "support/temp_folder.hpp"

namespace choreo::pipeline {
namespace {

using test::error_of;
using vision::FaceLook;

std::string frontal() {
  std::ifstream file(std::string(kCascadeFolder) + "/haarcascade_frontalface_alt.xml", std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// A cascade of one stump; what is between the marks can be replaced.
std::string small_cascade(const std::string& nodes = "0 -1 0 0.5", const std::string& rect = "1 1 4 4 -1.",
                          const std::string& type = "HAAR", const std::string& leaves = "0.1 0.9") {
  return "<?xml version=\"1.0\"?>\n<opencv_storage>\n<cascade type_id=\"opencv-cascade-classifier\">"
         "<stageType>BOOST</stageType><featureType>" +
         type +
         "</featureType><height>20</height><width>20</width><stageParams><maxWeakCount>1</maxWeakCount></stageParams>"
         "<featureParams><maxCatCount>0</maxCatCount></featureParams><stageNum>1</stageNum><stages><_>"
         "<maxWeakCount>1</maxWeakCount><stageThreshold>0.5</stageThreshold><weakClassifiers><_><internalNodes>" +
         nodes + "</internalNodes><leafValues>" + leaves +
         "</leafValues></_></weakClassifiers></_></stages><features><_><rects><_>" + rect +
         "</_><_>2 2 2 2 4.</_></rects></_></features></cascade>\n</opencv_storage>\n";
}

cv::Mat signaller() {
  devices::synthetic::PerformerSettings settings;
  settings.empty = 0;
  const devices::synthetic::Performer performer("semaphore", settings);
  cv::Mat grey;
  cv::cvtColor(performer.perform(5).bgr, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

TEST(Cascade, OpenCVsOwnAndASmallOneAreRead) {
  const auto whole = vision::read_cascade(frontal(), "frontal");
  EXPECT_FALSE(whole.empty());
  EXPECT_EQ(whole.getOriginalWindowSize(), cv::Size(20, 20));
  const auto small = vision::read_cascade(small_cascade(), "small");
  EXPECT_FALSE(small.empty());
  EXPECT_EQ(small.getOriginalWindowSize(), cv::Size(20, 20));
}

TEST(Cascade, WhatIsNoneIsRefusedInOneLine) {
  const auto refusal = [](const std::string& text) {
    const auto error = error_of([&] { (void)vision::read_cascade(text, "x.xml"); });
    EXPECT_TRUE(error) << text.substr(0, 80);
    if (!error) return std::string();
    EXPECT_EQ(error->fault(), Fault::kUsage);
    EXPECT_EQ(std::string(error->what()).find('\n'), std::string::npos);
    return std::string(error->what());
  };
  EXPECT_EQ(refusal(""), "\"x.xml\" is not XML");
  EXPECT_EQ(refusal("hello"), "\"x.xml\" is not XML");
  (void)refusal("<?xml");
  (void)refusal("<?xml version=\"1.0\"?>");
  EXPECT_EQ(refusal("<?xml version=\"1.0\"?>\n<opencv_storage><a>1</a></opencv_storage>"),
            "\"x.xml\" is no Haar cascade");
  EXPECT_EQ(refusal(small_cascade("0 -1 0 0.5", "1 1 4 4 -1.", "LBP")), "\"x.xml\" is no Haar cascade");
  const auto whole = frontal();
  (void)refusal(whole.substr(0, whole.size() / 2));
}

// OpenCV would follow all of these.
TEST(Cascade, NumbersThatLeadOutsideAreRefused) {
  for (const auto* nodes : {"0 -1 1 0.5", "0 -1 -1 0.5", "0 -2 0 0.5", "1 -1 0 0.5", "0 -1 0", "0 -1 0 0.5 0 -1 0 0.5",
                            "9 -1 0 0.5", "-99999 -1 0 0.5", "a b c d"}) {
    EXPECT_THROW((void)vision::read_cascade(small_cascade(nodes), "x"), Error) << nodes;
  }
  for (const auto* rect : {"17 1 4 4 -1.", "1 17 4 4 -1.", "-1 1 4 4 -1.", "1 1 4000000000 4 -1.", "1 1 4 4", "1"}) {
    EXPECT_THROW((void)vision::read_cascade(small_cascade("0 -1 0 0.5", rect), "x"), Error) << rect;
  }
  EXPECT_THROW((void)vision::read_cascade(small_cascade("0 -1 0 0.5", "1 1 4 4 -1.", "HAAR", "0.1"), "x"), Error);
}

// Changed bytes give an error or a cascade that can be run.
TEST(Cascade, DamageNeverGoesUnnoticedIntoMemory) {
  const auto good = small_cascade();
  cv::RNG random(3);
  const cv::Mat picture = test::noise({40, 40}, CV_8UC1, 1);
  int refused = 0, run = 0;
  for (int i = 0; i < 1500; ++i) {
    auto text = good;
    for (int k = random.uniform(1, 4); k > 0; --k) {
      const auto at = std::size_t(random.uniform(0, int(text.size())));
      constexpr std::string_view kBytes = "0123456789-.<>/_ \nae\"\x80";
      if (random.uniform(0, 2) == 0) {
        text[at] = kBytes[std::size_t(random.uniform(0, int(kBytes.size())))];
      } else {
        text.erase(at, std::size_t(random.uniform(1, 6)));
      }
    }
    const auto error = error_of([&] {
      vision::HaarFaceDetector detector(vision::read_cascade(text, "x"), {}, {});
      (void)detector.detect(picture, {0, 0, 40, 40}, 1, 40, FaceLook::kFront);
      ++run;
    });
    if (error) {
      EXPECT_EQ(std::string(error->what()).find('\n'), std::string::npos);
      ++refused;
    }
  }
  EXPECT_GT(refused, 100) << "else the damage reaches nothing";
  EXPECT_GT(run, 20) << "else nothing was run";
}

TEST(HaarFaces, TheSameWhateverTheNumberOfThreads) {
  const auto detector = load_face_detector({});
  const auto picture = signaller();
  const int before = cv::getNumThreads();
  std::vector<std::vector<vision::Face>> all;
  for (const int threads : {1, 2, 4, 4, 4}) {
    cv::setNumThreads(threads);
    all.push_back(detector->detect(picture, {{0, 0}, picture.size()}, 25, 60, FaceLook::kFront));
  }
  cv::setNumThreads(before);
  ASSERT_EQ(all[0].size(), 1U);
  EXPECT_GT(all[0][0].confidence, 0.5);
  EXPECT_LE(all[0][0].confidence, 1);
  for (const auto& faces : all) {
    ASSERT_EQ(faces.size(), 1U);
    EXPECT_EQ(faces[0].box, all[0][0].box);
    EXPECT_EQ(faces[0].confidence, all[0][0].confidence);
  }
}

TEST(HaarFaces, OnlyWhereAndAsLargeAsAskedFor) {
  const auto detector = load_face_detector({});
  const auto picture = signaller();
  const cv::Rect whole({0, 0}, picture.size());
  const auto faces = detector->detect(picture, whole, 25, 60, FaceLook::kAny);
  ASSERT_EQ(faces.size(), 1U);
  const auto& box = faces[0].box;
  const cv::Point centre(int(box.x + box.width / 2), int(box.y + box.height / 2));
  const cv::Rect around(centre - cv::Point(60, 60), centre + cv::Point(60, 60));
  const auto near = detector->detect(picture, around, 25, 60, FaceLook::kFront);
  ASSERT_EQ(near.size(), 1U);
  EXPECT_GT(vision::overlap(near[0].box, box), 0.7);
  EXPECT_TRUE(detector->detect(picture, {centre.x + 30, 0, 200, 480}, 25, 60, FaceLook::kFront).empty());
  EXPECT_TRUE(detector->detect(picture, whole, 60, 200, FaceLook::kFront).empty());
}

// The cascade's own windows are 20 pixels wide, those of dark faces little wider than the face.
TEST(HaarFaces, FacesUnderTheCascadesWindowAreFoundWhereTheyAre) {
  const auto detector = load_face_detector({});
  for (const auto* skin : {"very-light", "dark"}) {
    devices::synthetic::PerformerSettings settings;
    settings.empty = 0;
    settings.skin = skin;
    for (const auto& [size, distance] : {std::pair{cv::Size(640, 480), 1.9}, {cv::Size(320, 240), 1.0}}) {
      settings.size = size;
      settings.distance = distance;
      const auto shot = devices::synthetic::Performer("semaphore", settings).perform(5);
      ASSERT_LT(shot.face.width, 20);
      cv::Mat grey;
      cv::cvtColor(shot.bgr, grey, cv::COLOR_BGR2GRAY);
      const cv::Rect near(shot.face.tl() - cv::Point2d(25, 25), shot.face.br() + cv::Point2d(25, 25));
      const auto faces = detector->detect(grey, near, 0.8 * shot.face.width, 1.2 * shot.face.width, FaceLook::kAny);
      ASSERT_EQ(faces.size(), 1U) << skin << ", " << shot.face.width << " px";
      EXPECT_GT(vision::overlap(faces[0].box, shot.face), 0.6) << skin << ", " << shot.face.width << " px";
    }
  }
}

TEST(HaarFaces, EmptyAndTinyPicturesHaveNoFace) {
  const auto detector = load_face_detector({});
  for (const cv::Size size : {cv::Size(0, 0), cv::Size(1, 1), cv::Size(19, 19), cv::Size(1000, 3)}) {
    const cv::Mat picture = size.empty() ? cv::Mat() : test::noise(size, CV_8UC1, 2);
    EXPECT_TRUE(detector->detect(picture, {-5, -5, 5000, 5000}, 1, 5000, FaceLook::kAny).empty()) << size;
    EXPECT_TRUE(vision::all_faces(*detector, picture, 4).empty()) << size;
  }
}

TEST(HaarFaces, SettingsOutOfRangeAreRefused) {
  EXPECT_THROW((vision::HaarOptions{.neighbours = 0}.validate()), Error);
  EXPECT_THROW((vision::HaarOptions{.scale_step = 1}.validate()), Error);
}

TEST(FaceModels, AFolderWithoutCascadesIsRefused) {
  const test::TempFolder folder;
  FaceModelOptions options;
  options.cascades = folder.path();
  const auto error = error_of([&] { (void)load_face_detector(options); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_NE(std::string(error->what()).find("haarcascade_frontalface_alt.xml"), std::string::npos);
  EXPECT_NE(error->hint().find("opencv-data"), std::string::npos);
  std::filesystem::create_directory(folder / "haarcascade_frontalface_alt.xml");
  EXPECT_THROW((void)load_face_detector(options), Error);
}

TEST(FaceModels, AModelThatIsNoneIsRefusedInOneLine) {
  const test::TempFolder folder;
  FaceModelOptions options;
  options.model = folder / "model.onnx";
  EXPECT_THROW((void)load_face_detector(options), Error) << "it is not there";
  for (const std::string& text : {std::string(), std::string("not a model"), std::string(1000, '\x08')}) {
    test::write_bytes(options.model, text);
    const auto error = error_of([&] { (void)load_face_detector(options); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->fault(), Fault::kUsage);
    EXPECT_NE(std::string(error->what()).find("no face model"), std::string::npos);
    EXPECT_EQ(std::string(error->what()).find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace choreo::pipeline

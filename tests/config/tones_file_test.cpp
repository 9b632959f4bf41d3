// SPDX-License-Identifier: Apache-2.0
#include "config/tones_file.hpp"

#include <memory>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"

namespace choreo::config {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

vision::ToneSet some_tones() {
  std::vector<cv::Vec3b> pixels;
  for (int i = 0; i < 400; ++i) {
    pixels.emplace_back(static_cast<std::uint8_t>(90 + i % 7), static_cast<std::uint8_t>(130 + i % 11),
                        static_cast<std::uint8_t>(190 + i % 13));
  }
  vision::ToneSet set;
  set.outliers = 0.7;
  vision::ToneFit fit;
  set.put({"a \"quoted\" name", 0.3, vision::fitted_parts(pixels, fit)});
  fit.kind = vision::ToneKind::kHistogram;
  set.put({"flag", 0.1, vision::fitted_parts(pixels, fit)});
  fit.kind = vision::ToneKind::kGaussian;
  fit.parts = 2;
  fit.with_value = false;
  set.put({"two", 0.1, vision::fitted_parts(pixels, fit)});
  return set;
}

const std::string& some_text() {
  static const auto text = print_tones(some_tones(), "a test");
  return text;
}

std::string refused(const std::string& text) {
  try {
    (void)parse_tones(text, "my.toml");
  } catch (const Error& error) {
    EXPECT_EQ(error.fault(), Fault::kUsage);
    return error.what();
  }
  return "nothing was refused";
}

std::string with(const std::string& was, const std::string& is) {
  auto text = some_text();
  const auto at = text.find(was);
  EXPECT_NE(at, std::string::npos) << was;
  return text.replace(at, was.size(), is);
}

TEST(TonesFile, ReadsBackAsTheSameTonesToTheLastBit) {
  const auto again = parse_tones(some_text(), "my.toml");
  EXPECT_EQ(print_tones(again, "a test"), some_text());
  const auto set = some_tones();
  ASSERT_EQ(again.tones.size(), 3U);
  for (int level = 0; level < 256; level += 17) {
    const auto colour = vision::tone_colour({90, 130, double(level)});
    EXPECT_EQ(again.posteriors(colour), set.posteriors(colour));
  }
}

TEST(TonesFile, EveryBeginningOfOneIsRefused) {
  const auto& text = some_text();
  for (std::size_t n = 0; n + 2 < text.size(); n += n < 1500 ? 1 : 97) {
    EXPECT_THAT(refused(text.substr(0, n)), StartsWith("my.toml:")) << n << " bytes";
  }
}

TEST(TonesFile, OfALaterVersionIsRefusedByNameOfTheVersion) {
  EXPECT_THAT(refused(with("choreoscope_tones = 1", "choreoscope_tones = 2")),
              AllOf(StartsWith("my.toml:2:"), HasSubstr("version 2")));
}

TEST(TonesFile, WhatIsNoneIsRefused) {
  EXPECT_THAT(refused("[mask]\nsteps = 1\n"), HasSubstr("is no tones file"));
  EXPECT_THAT(refused("\x89PNG\r\n"), StartsWith("my.toml:1:"));
  EXPECT_THAT(refused("choreoscope_tones = \"one\"\n"), StartsWith("my.toml:1:"));
  EXPECT_THROW((void)load_tones("/tmp"), Error);
  EXPECT_THROW((void)load_tones("/nowhere/my.toml"), Error);
}

TEST(TonesFile, WrongValuesAreFoundByTheirPlace) {
  EXPECT_THAT(refused(with("outliers = 0.7", "outliers = 0")), AllOf(StartsWith("my.toml:4:12"), HasSubstr("range")));
  EXPECT_THAT(refused(with("prior = 0.3", "prior = nan")), StartsWith("my.toml:8:"));
  EXPECT_THAT(refused(with("prior = 0.3", "piror = 0.3")), HasSubstr("unknown key \"piror\""));
  EXPECT_THAT(refused(with("\"gaussian\"", "\"gausian\"")), HasSubstr("unknown model \"gausian\""));
  EXPECT_THAT(refused(with("name = \"flag\"", "name = \"two\"")), HasSubstr("\"two\" is there twice"));
  EXPECT_THAT(refused(with("mean = [", "mean = [1, ")), HasSubstr("is not a row of 3 numbers"));
  EXPECT_THAT(refused(with("covariance = [\n", "covariance = [\n  [0, 0, 0],\n")), HasSubstr("three rows"));
  EXPECT_THAT(refused(with("cells = [\n", "cells = [\n  [64, 0, 1],\n")), HasSubstr("range"));
}

TEST(TonesFile, ASingularCovarianceIsRefusedAtItsPart) {
  auto text = some_text();
  const auto from = text.find("covariance");
  const auto to = text.find("]\n\n", from);
  text.replace(from, to - from, "covariance = [[0.01, 0.01, 0], [0.01, 0.01, 0], [0, 0, 0.01]\n");
  EXPECT_THAT(refused(text), AllOf(StartsWith("my.toml:"), HasSubstr("singular")));
}

}  // namespace
}  // namespace choreo::config

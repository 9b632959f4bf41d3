// SPDX-License-Identifier: Apache-2.0
// The exact bytes of letters.json.
#include "outputs/letters_json.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace choreo::outputs {
namespace {

TEST(LettersJson, HasALineALetterAndLeavesRestOut) {
  const std::vector<recognition::HeldSign> signs = {
      {"REST", 0, 1, 1, "A"}, {"A", 1.73349, 4.6, 0.9984, "B"}, {"NUMERALS", 5, 7.25, 0.5, "U"}};
  EXPECT_EQ(letters_json(signs, "A"),
            "{\n"
            "  \"letters\": [\n"
            "    {\"letter\": \"A\", \"from\": 1.733, \"to\": 4.600, \"confidence\": 0.998},\n"
            "    {\"letter\": \"NUMERALS\", \"from\": 5.000, \"to\": 7.250, \"confidence\": 0.500}\n"
            "  ],\n"
            "  \"text\": \"A\"\n"
            "}\n");
}

TEST(LettersJson, IsWholeWithoutALetter) {
  EXPECT_EQ(letters_json({}, ""), "{\n  \"letters\": [],\n  \"text\": \"\"\n}\n");
  EXPECT_EQ(pictures_json({}), "{\n  \"pictures\": []\n}\n");
}

TEST(LettersJson, SaysSinceWhenWhereLettersWereForgotten) {
  const std::vector<recognition::HeldSign> signs = {{"A", 4000, 4001.5, 1, "B"}};
  EXPECT_EQ(letters_json(signs, "A", 3600.25),
            "{\n"
            "  \"letters\": [\n"
            "    {\"letter\": \"A\", \"from\": 4000.000, \"to\": 4001.500, \"confidence\": 1.000}\n"
            "  ],\n"
            "  \"text\": \"A\",\n"
            "  \"since\": 3600.250\n"
            "}\n");
}

TEST(PicturesJson, WritesNullWhereThereIsNoLetterAndEscapesNames) {
  recognition::SignReading b;
  b.sign = "B";
  b.confidence = 0.9871;
  b.runner_up = "C";
  recognition::SignReading near;
  near.confidence = 0.75;
  near.runner_up = "REST";
  recognition::SignReading nothing;
  nothing.confidence = 1;
  const std::vector<PictureReading> pictures = {{"a \"b\"\n.jpg", b}, {"\xFFx.png", near}, {"wall.jpg", nothing}};
  EXPECT_EQ(pictures_json(pictures),
            "{\n"
            "  \"pictures\": [\n"
            "    {\"file\": \"a \\\"b\\\"\\n.jpg\", \"letter\": \"B\", \"confidence\": 0.987, \"runner_up\": \"C\"},\n"
            "    {\"file\": \"\xEF\xBF\xBDx.png\", \"letter\": null, \"confidence\": 0.750, \"runner_up\": \"REST\"},\n"
            "    {\"file\": \"wall.jpg\", \"letter\": null, \"confidence\": 1.000, \"runner_up\": null}\n"
            "  ]\n"
            "}\n");
}

}  // namespace
}  // namespace choreo::outputs

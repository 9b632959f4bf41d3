// SPDX-License-Identifier: Apache-2.0
// letters.json as others read it.
#include "outputs/letters_json.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace choreo::outputs {
namespace {

TEST(LettersJson, HasTheKeysInTheirOrderAndTimesToAMillisecond) {
  const ReadLetter letters[] = {{"R", 1.2345678, 3.5, 0.98765}, {"REST", 3.75, 4, 1}};
  EXPECT_EQ(letters_json(letters, "R"), R"({
  "letters": [
    {
      "letter": "R",
      "from": 1.235,
      "to": 3.5,
      "confidence": 0.988
    },
    {
      "letter": "REST",
      "from": 3.75,
      "to": 4.0,
      "confidence": 1.0
    }
  ],
  "text": "R"
}
)");
}

TEST(LettersJson, WithoutLettersTheListIsEmptyAndNotMissing) {
  EXPECT_EQ(letters_json({}, ""), "{\n  \"letters\": [],\n  \"text\": \"\"\n}\n");
  EXPECT_EQ(pictures_json({}), "{\n  \"pictures\": []\n}\n");
}

TEST(PicturesJson, WhereThereIsNoLetterItIsNull) {
  const ReadPicture pictures[] = {{"a.jpg", "A", 0.9, "REST"}, {"b \"2\".jpg", std::nullopt, 0.5, ""}};
  const auto json = nlohmann::json::parse(pictures_json(pictures));
  ASSERT_EQ(json["pictures"].size(), 2U);
  EXPECT_EQ(json["pictures"][0]["file"], "a.jpg");
  EXPECT_EQ(json["pictures"][0]["letter"], "A");
  EXPECT_EQ(json["pictures"][0]["runner_up"], "REST");
  EXPECT_EQ(json["pictures"][1]["file"], "b \"2\".jpg");
  EXPECT_TRUE(json["pictures"][1]["letter"].is_null());
  EXPECT_TRUE(json["pictures"][1]["runner_up"].is_null());
}

TEST(PicturesJson, AFilesNameThatIsNoTextStaysReadable) {
  const ReadPicture pictures[] = {{"\xff.jpg", std::nullopt, 0, ""}};
  EXPECT_EQ(nlohmann::json::parse(pictures_json(pictures))["pictures"][0]["file"], "\xEF\xBF\xBD.jpg");
}

}  // namespace
}  // namespace choreo::outputs

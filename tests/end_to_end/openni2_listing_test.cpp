// SPDX-License-Identifier: Apache-2.0
// What the command devices says of a camera behind OpenNI2.
#include "devices/openni2_fixture.hpp"
#include "end_to_end/choreoscope_run.hpp"

namespace choreo::test {
namespace {

using ::testing::HasSubstr;

TEST_F(OpenNi2Test, TheCommandListsItsSettingsAndNothingRaw) {
  tell("rude");
  const auto listed = choreoscope({"devices"});
  EXPECT_EQ(listed.status, 0) << listed.told();
  EXPECT_THAT(listed.out, HasSubstr("\n  Choreo Test\\x1b[31m\\nCamera\n"));
  EXPECT_EQ(listed.out.find('\x1b'), std::string::npos);
  for (const auto* line : {"video=any  (any, rgb, ir, off)", "depth=on  (on, off)", "registration=on  (on, off)",
                           "fps  (1 to 1000 Hz)", "size  (1 to 4096 pixels a side"}) {
    EXPECT_THAT(listed.out, HasSubstr(line));
  }
  const auto told = choreoscope({"devices", "--json"});
  EXPECT_EQ(told.status, 0) << told.told();
  EXPECT_EQ(told.out.find('\x1b'), std::string::npos);
  for (const auto* word : {"\"settings\": [", "\"name\": \"registration\"", "\"choices\": [", "\"max\": 1000.0"}) {
    EXPECT_THAT(told.out, HasSubstr(word));
  }
}

}  // namespace
}  // namespace choreo::test

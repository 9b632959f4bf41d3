// SPDX-License-Identifier: Apache-2.0
// choreoscope devices: what there is on a machine without any.
#include <gmock/gmock.h>

#include "end_to_end/refusal_fixture.hpp"

namespace choreo::test {
namespace {

using ::testing::HasSubstr;

class Devices : public RefusalTest {};

TEST_F(Devices, AreListedForPeopleAndForPrograms) {
  const auto listed = choreoscope({"devices"});
  EXPECT_EQ(listed.status, 0) << listed.told();
  EXPECT_NE(listed.out, "");
  const auto told = choreoscope({"devices", "--json"});
  EXPECT_EQ(told.status, 0) << told.told();
  const auto json = nlohmann::json::parse(told.out);
  ASSERT_TRUE(json["devices"].is_array());
  ASSERT_TRUE(json["troubles"].is_array());
  for (const auto& device : json["devices"]) {
    EXPECT_THAT(listed.out, HasSubstr(device["source"].get<std::string>()));
  }
  if (json["devices"].empty()) {
    EXPECT_THAT(listed.out, HasSubstr("no device is plugged in"));
  }
}

TEST_F(Devices, TakeNoArguments) {
  EXPECT_THAT(complaint_of(choreoscope({"devices", "all"}), 2), HasSubstr("all"));
  EXPECT_THAT(complaint_of(choreoscope({"devices", "--jsn"}), 2), HasSubstr("--jsn"));
}

TEST_F(Devices, ACameraThatIsNotThereIsRefused) {
  const auto run = choreoscope({"live", "v4l2:///dev/video987", "--headless"});
  EXPECT_THAT(complaint_of(run, 2), HasSubstr("/dev/video987"));
  EXPECT_THAT(hint_of(run), HasSubstr("choreoscope devices"));
}

}  // namespace
}  // namespace choreo::test

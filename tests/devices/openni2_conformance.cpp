// SPDX-License-Identifier: Apache-2.0
// What is asked of every driver, asked of OpenNI2's: of a camera behind the real library, and of a recording of it.
#include "devices/conformance.hpp"
#include "devices/openni2_fixture.hpp"

namespace choreo::devices {
namespace {

ConformanceSubject camera() {
  const auto rig = std::make_shared<test::OpenNi2Rig>();
  return {"openni2_camera",
          rig->driver(),
          "openni2://",
          "openni2://?video=sound",
          [rig] { rig->tell("gone"); },
          [rig] { rig->tell(""); },
          rig};
}

ConformanceSubject recording() {
  const auto rig = std::make_shared<test::OpenNi2Rig>();
  const auto take = rig->folder_ / "take.oni";
  rig->record(take, 30);
  return {"oni_recording", rig->driver(), take, take + "?video=sound", {}, {}, rig};
}

}  // namespace

std::vector<ConformanceCase> conformance_subjects() {
  return {{"openni2_camera", ConformanceKind::kCamera, camera},
          {"oni_recording", ConformanceKind::kRecording, recording}};
}

}  // namespace choreo::devices

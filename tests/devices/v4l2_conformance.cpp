// SPDX-License-Identifier: Apache-2.0
// What is asked of every driver, asked of V4L2 on the kernel's virtual camera.
#include "devices/conformance.hpp"

#include <stdexcept>

#include "devices/v4l2/v4l2_controls.hpp"
#include "devices/v4l2/v4l2_driver.hpp"
#include "devices/vivid.hpp"
#include "pipeline/steady_clock.hpp"

namespace choreo::devices {
namespace {

ConformanceSubject vivid() {
  static const pipeline::SteadyClock clock;
  const auto path = vivid_path();
  if (path.empty()) throw std::runtime_error("there is no vivid camera; script/v4l2-vm runs this where there is one");
  const auto drop = [path](const std::string& percentage) {
    (void)v4l2::set_controls(v4l2::Node(path), {{"percentage_of_dropped_buffers", percentage}});
  };
  drop("0");
  return {"vivid",
          v4l2_driver(clock),
          "v4l2://" + path + "?size=320x180",
          "v4l2://" + path + "?size=321x180",
          [drop] { drop("100"); },
          [drop] { drop("0"); }};
}

}  // namespace

std::vector<ConformanceCase> conformance_subjects() { return {{"vivid", ConformanceKind::kCamera, vivid}}; }

}  // namespace choreo::devices

// SPDX-License-Identifier: Apache-2.0
#include "cli/drivers.hpp"

#include "devices/image_folder/image_folder.hpp"
#include "devices/openni2/openni2_driver.hpp"
#include "devices/synthetic/synthetic_source.hpp"
#include "devices/v4l2/v4l2_driver.hpp"
#include "devices/video_file/video_file.hpp"

namespace choreo::cli {

devices::Registry all_drivers(const Clock& clock) {
  devices::Registry registry;
  registry.add(devices::video_file_driver());
  registry.add(devices::image_folder_driver());
  registry.add(devices::synthetic_driver());
  registry.add(devices::v4l2_driver(clock));
#if CHOREO_HAS_OPENNI2
  registry.add(devices::openni2_driver(clock));
#else
  registry.add(devices::absent_driver("openni2", "a depth camera or an .oni recording of OpenNI2",
                                      "apt-get install libopenni2-dev, and build anew"));
#endif
  return registry;
}

}  // namespace choreo::cli

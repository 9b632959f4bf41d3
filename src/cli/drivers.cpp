// SPDX-License-Identifier: Apache-2.0
#include "cli/drivers.hpp"

#if CHOREO_HAS_FREENECT
#include "devices/freenect/freenect_driver.hpp"
#endif
#include "devices/image_folder/image_folder.hpp"
#include "devices/kinect_dump/kinect_dump.hpp"
#include "devices/network/network_driver.hpp"
#include "devices/openni2/openni2_driver.hpp"
#include "devices/synthetic/synthetic_source.hpp"
#include "devices/take/take_driver.hpp"
#include "devices/v4l2/v4l2_driver.hpp"
#include "devices/video_file/video_file.hpp"

namespace choreo::cli {

devices::Registry all_drivers(const Clock& clock) {
  devices::Registry registry;
  registry.add(devices::video_file_driver());
  registry.add(devices::image_folder_driver());
  registry.add(devices::kinect_dump_driver());
  registry.add(devices::synthetic_driver());
  registry.add(devices::take_driver());
  registry.add(devices::v4l2_driver(clock));
#if CHOREO_HAS_FREENECT
  registry.add(devices::freenect_driver(clock));
#else
  registry.add(devices::absent_driver("freenect", "a Kinect v1, its colour and its depth",
                                      "install libfreenect-dev and build again"));
#endif
  registry.add(devices::network_driver(clock, devices::open_remote_recording));
#if CHOREO_HAS_OPENNI2
  registry.add(devices::openni2_driver(clock));
#else
  registry.add(devices::absent_driver("openni2", "a depth camera or an .oni recording of OpenNI2",
                                      "apt-get install libopenni2-dev, and build anew"));
#endif
  return registry;
}

}  // namespace choreo::cli

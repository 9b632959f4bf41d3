// SPDX-License-Identifier: Apache-2.0
#include "cli/plate.hpp"

#include "cli/given_picture.hpp"

namespace choreo::cli {

cv::Mat read_plate(const std::string& path) {
  // Half a picture would be half a room.
  return read_picture(path, "plate", "--background takes auto, first:1s, or the path of a PNG, JPEG, TIFF or the like");
}

}  // namespace choreo::cli

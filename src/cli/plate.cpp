// SPDX-License-Identifier: Apache-2.0
#include "cli/plate.hpp"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/error.hpp"
#include "devices/image_folder/picture_check.hpp"

namespace choreo::cli {

cv::Mat read_plate(const std::string& path) {
  cv::Mat plate;
  try {
    // A pipe or a device may never end.
    std::error_code problem;
    std::ifstream file;
    if (std::filesystem::is_regular_file(path, problem)) file.open(path, std::ios::binary);
    const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    // Half a picture would be half a room.
    if (devices::is_whole_picture(bytes)) plate = cv::imdecode(bytes, cv::IMREAD_COLOR);
  } catch (const std::ios_base::failure&) {
    // A folder, or a disk that does not answer: the picture stays empty.
  } catch (const cv::Exception&) {
    // The same.
  }
  if (plate.empty()) {
    throw usage_error(fmt::format("the plate \"{}\" is no picture that can be read", path), {},
                      "--background takes auto, first:1s, or the path of a PNG, JPEG, TIFF or the like");
  }
  return plate;
}

}  // namespace choreo::cli

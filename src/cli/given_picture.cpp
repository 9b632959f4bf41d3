// SPDX-License-Identifier: Apache-2.0
#include "cli/given_picture.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "devices/media/still_picture.hpp"

namespace choreo::cli {

cv::Mat read_picture(const std::string& path, const std::string& what, const std::string& hint) {
  // A pipe or a device may never end.
  std::error_code problem;
  const bool regular = std::filesystem::is_regular_file(path, problem);
  const auto size = regular ? std::filesystem::file_size(path, problem) : 0;
  if (regular && !problem && size > kMostPictureBytes) {
    throw usage_error(
        fmt::format("the {} \"{}\" is larger than {} MiB: no picture", what, path, kMostPictureBytes >> 20U), {}, hint);
  }
  cv::Mat picture;
  try {
    std::ifstream file;
    if (regular) file.open(path, std::ios::binary);
    const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    picture = devices::decode_picture(bytes);
  } catch (const std::ios_base::failure&) {
    // A disk that does not answer: the picture stays empty.
  }
  if (picture.empty()) {
    throw usage_error(fmt::format("the {} \"{}\" is no picture that can be read", what, path), {}, hint);
  }
  return picture;
}

}  // namespace choreo::cli

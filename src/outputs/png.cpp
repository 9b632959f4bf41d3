// SPDX-License-Identifier: Apache-2.0
#include "outputs/png.hpp"

#include <cassert>

#include <fmt/format.h>
#include <png.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"

namespace choreo::outputs {

std::string png_of(const cv::Mat& picture) {
  assert(picture.type() == CV_8UC3 && !picture.empty());
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = png_uint_32(picture.cols);
  image.height = png_uint_32(picture.rows);
  image.format = PNG_FORMAT_BGR;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.data, png_int_32(picture.step[0]), nullptr) ==
      0) {
    throw failure(fmt::format("a picture of {}x{} cannot be written as PNG: {}", picture.cols, picture.rows,
                              std::string_view(image.message)));
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace choreo::outputs

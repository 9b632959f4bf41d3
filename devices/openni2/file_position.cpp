// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/file_position.hpp"

#include <sys/stat.h>
#include <unistd.h>

namespace choreo::devices::openni2 {

bool stands_at_end(int descriptor) {
  struct stat file {};
  if (::fstat(descriptor, &file) != 0) return false;
  constexpr int kMostDescriptors = 256;  // A helper has a dozen.
  for (int other = 0; other < kMostDescriptors; ++other) {
    struct stat what {};
    if (other == descriptor || ::fstat(other, &what) != 0) continue;
    if (what.st_dev != file.st_dev || what.st_ino != file.st_ino) continue;
    if (::lseek(other, 0, SEEK_CUR) >= file.st_size) return true;
  }
  return false;
}

}  // namespace choreo::devices::openni2

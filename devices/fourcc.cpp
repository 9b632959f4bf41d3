// SPDX-License-Identifier: Apache-2.0
#include "devices/fourcc.hpp"

namespace choreo::devices {

std::string name_of_fourcc(std::uint32_t code) {
  std::string name;
  for (unsigned shift = 0; shift < 32; shift += 8) {
    const char c = static_cast<char>(code >> shift & 0x7fU);
    name += c < 0x20 || c > 0x7e ? '.' : c;
  }
  while (name.size() > 1 && name.back() == ' ') name.pop_back();
  return name;
}

}  // namespace choreo::devices

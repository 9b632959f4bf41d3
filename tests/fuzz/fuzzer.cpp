// SPDX-License-Identifier: Apache-2.0
// What libFuzzer calls; CHOREO_FUZZ_ENTRY names the function of entries.hpp.
#include <cstddef>
#include <cstdint>

#include "fuzz/entries.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  choreo::fuzz::CHOREO_FUZZ_ENTRY({reinterpret_cast<const char*>(data), size});
  return 0;
}

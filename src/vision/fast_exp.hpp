// SPDX-License-Identifier: Apache-2.0
// The exponential function as plain arithmetic, so that a loop over it becomes vector code.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace choreo::vision {

/// e^x for x from -80 to 80, what lies beyond being taken for the end it is beyond; within 2e-7 of the truth,
/// relatively.
///
/// e^x = 2^n e^r, n = round(x / ln 2), |r| <= ln 2 / 2, and a polynomial for e^r.
/// @source Moshier, Cephes Mathematical Library, expf.
[[nodiscard]] inline float fast_exp(float x) {
  x = std::min(std::max(x, -80.0F), 80.0F);
  const float scaled = x * 1.44269504088896341F;
  const auto n = static_cast<std::int32_t>(scaled + (scaled < 0 ? -0.5F : 0.5F));
  const auto whole = static_cast<float>(n);
  // ln 2 in two parts, of which the first times n is exact.
  const float r = (x - whole * 0.693359375F) + whole * 2.12194440e-4F;
  float p = 1.9875691500e-4F;
  p = p * r + 1.3981999507e-3F;
  p = p * r + 8.3334519073e-3F;
  p = p * r + 4.1665795894e-2F;
  p = p * r + 1.6666665459e-1F;
  p = p * r + 5.0000001201e-1F;
  p = (p * r * r + r) + 1.0F;
  return p * std::bit_cast<float>((n + 127) << 23);
}

}  // namespace choreo::vision

// SPDX-License-Identifier: Apache-2.0
// Compiled once for every instruction set: Highway includes this file again for each of them.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "similarity/and_count.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

#include "similarity/and_count.hpp"

HWY_BEFORE_NAMESPACE();
namespace choreo::similarity::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

void AndCountBlock(const std::uint8_t* const* rows, const std::uint8_t* const* cols, std::size_t bytes,
                   std::uint32_t* counts) {
  static_assert(kBlockRows == 2 && kBlockCols == 2);
  const hn::ScalableTag<std::uint8_t> d8;
  const hn::ScalableTag<std::uint64_t> d64;
  const std::size_t lanes = hn::Lanes(d8);
  // A byte has at most 8 bits set, so 31 additions cannot overflow a lane.
  const std::size_t most = 31 * lanes;

  auto sum00 = hn::Zero(d64);
  auto sum01 = hn::Zero(d64);
  auto sum10 = hn::Zero(d64);
  auto sum11 = hn::Zero(d64);
  for (std::size_t begin = 0; begin < bytes; begin += most) {
    const std::size_t end = bytes - begin < most ? bytes : begin + most;
    auto part00 = hn::Zero(d8);
    auto part01 = hn::Zero(d8);
    auto part10 = hn::Zero(d8);
    auto part11 = hn::Zero(d8);
    for (std::size_t i = begin; i < end; i += lanes) {
      const auto col0 = hn::Load(d8, cols[0] + i);
      const auto col1 = hn::Load(d8, cols[1] + i);
      part00 = hn::Add(part00, hn::PopulationCount(hn::And(hn::Load(d8, rows[0] + i), col0)));
      part01 = hn::Add(part01, hn::PopulationCount(hn::And(hn::Load(d8, rows[1] + i), col1)));
      part10 = hn::Add(part10, hn::PopulationCount(hn::And(hn::Load(d8, rows[2] + i), col0)));
      part11 = hn::Add(part11, hn::PopulationCount(hn::And(hn::Load(d8, rows[3] + i), col1)));
    }
    sum00 = hn::Add(sum00, hn::SumsOf8(part00));
    sum01 = hn::Add(sum01, hn::SumsOf8(part01));
    sum10 = hn::Add(sum10, hn::SumsOf8(part10));
    sum11 = hn::Add(sum11, hn::SumsOf8(part11));
  }
  counts[0] += static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(d64, sum00)));
  counts[1] += static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(d64, sum01)));
  counts[2] += static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(d64, sum10)));
  counts[3] += static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(d64, sum11)));
}

const char* NameOfTarget() { return hwy::TargetName(HWY_TARGET); }

}  // namespace choreo::similarity::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <bit>
#include <cstring>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::similarity {
namespace {

HWY_EXPORT(AndCountBlock);
HWY_EXPORT(NameOfTarget);

void and_count_block_scalar(const std::uint8_t* const* rows, const std::uint8_t* const* cols, std::size_t bytes,
                            std::uint32_t* counts) {
  for (std::size_t i = 0; i < kBlockRows; ++i) {
    for (std::size_t j = 0; j < kBlockCols; ++j) {
      counts[i * kBlockCols + j] += and_count_scalar(rows[i * kBlockCols + j], cols[j], bytes);
    }
  }
}

}  // namespace

std::uint32_t and_count_scalar(const std::uint8_t* a, const std::uint8_t* b, std::size_t bytes) {
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < bytes; i += sizeof(std::uint64_t)) {
    std::uint64_t x = 0;
    std::uint64_t y = 0;
    std::memcpy(&x, a + i, sizeof x);
    std::memcpy(&y, b + i, sizeof y);
    count += static_cast<std::uint32_t>(std::popcount(x & y));
  }
  return count;
}

std::vector<AndCountKernel> and_count_kernels() {
  std::vector<AndCountKernel> kernels;
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    // A choice of our own beside Highway's global one: the kernel is a value, not a switch thrown for everybody.
    hwy::ChosenTarget choice;
    choice.Update(target);
    const auto index = choice.GetIndex();
    kernels.push_back({HWY_DISPATCH_TABLE(NameOfTarget)[index](), HWY_DISPATCH_TABLE(AndCountBlock)[index]});
  }
  kernels.push_back({"scalar", &and_count_block_scalar});
  return kernels;
}

AndCountKernel choose_and_count(const std::string& name) {
  const auto kernels = and_count_kernels();
  if (name.empty()) return kernels.front();
  std::vector<std::string> names;
  for (const auto& kernel : kernels) {
    if (kernel.name == name) return kernel;
    names.push_back(kernel.name);
  }
  throw usage_error(fmt::format("instruction set \"{}\" is not to be had on this machine", name), {},
                    "known: " + join(names));
}

}  // namespace choreo::similarity

#endif  // HWY_ONCE

// SPDX-License-Identifier: Apache-2.0
// Compiled once for every instruction set: Highway includes this file again for each of them.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "similarity/and_count.cpp"
#include <hwy/foreach_target.h>

#include <hwy/cache_control.h>
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

using D8 = hn::CappedTag<std::uint8_t, kBitAlignment>;
using D64 = hn::Repartition<std::uint64_t, D8>;
using V8 = hn::Vec<D8>;
using V64 = hn::Vec<D64>;

// Where bits are counted by table look-ups, it is cheaper to add them up in columns first (Harley and Seal's carry-save
// adders): eight vectors become one that is counted. Where one instruction counts, nothing is cheaper than that.
#if HWY_TARGET == HWY_AVX3_DL || HWY_ARCH_ARM
constexpr bool kCountsInHardware = true;
#else
constexpr bool kCountsInHardware = false;
#endif

// The bits of a stream of vectors, eight at a time.
class BitCounter {
 public:
  HWY_INLINE BitCounter()
      : ones_(hn::Zero(D8())), twos_(ones_), fours_(ones_), part_(ones_), sum_(hn::Zero(D64())) {}

  HWY_INLINE void Add8(V8 v0, V8 v1, V8 v2, V8 v3, V8 v4, V8 v5, V8 v6, V8 v7) {
    V8 twos_a, twos_b, fours_a, fours_b, eights;
    AddBits(ones_, v0, v1, twos_a);
    AddBits(ones_, v2, v3, twos_b);
    AddBits(twos_, twos_a, twos_b, fours_a);
    AddBits(ones_, v4, v5, twos_a);
    AddBits(ones_, v6, v7, twos_b);
    AddBits(twos_, twos_a, twos_b, fours_b);
    AddBits(fours_, fours_a, fours_b, eights);
    part_ = hn::Add(part_, hn::PopulationCount(eights));
  }
  // A byte has at most 8 bits set, so 31 additions to part_ cannot overflow a lane.
  HWY_INLINE void Flush() {
    sum_ = hn::Add(sum_, hn::SumsOf8(part_));
    part_ = hn::Zero(D8());
  }
  // How many bits have come in.
  HWY_INLINE std::uint32_t Total() {
    Flush();
    auto all = hn::ShiftLeft<1>(sum_);
    all = hn::ShiftLeft<1>(hn::Add(all, hn::SumsOf8(hn::PopulationCount(fours_))));
    all = hn::ShiftLeft<1>(hn::Add(all, hn::SumsOf8(hn::PopulationCount(twos_))));
    all = hn::Add(all, hn::SumsOf8(hn::PopulationCount(ones_)));
    return static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(D64(), all)));
  }

 private:
  // sum + a + b in binary, bit by bit: sum keeps the lower digit, carry takes the higher one.
  static HWY_INLINE void AddBits(V8& sum, V8 a, V8 b, V8& carry) {
    const auto differ = hn::Xor(a, b);
    carry = hn::OrAnd(hn::And(a, b), differ, sum);
    sum = hn::Xor(differ, sum);
  }

  V8 ones_, twos_, fours_, part_;
  V64 sum_;
};

void AndCountTwice(const std::uint8_t* row, const std::uint8_t* straight, const std::uint8_t* mirrored,
                   std::size_t bytes, const std::uint8_t* next, std::uint32_t* counts) {
  const D8 d8;
  const D64 d64;
  const std::size_t lanes = hn::Lanes(d8);
  std::size_t i = 0;
  std::uint32_t first = 0;
  std::uint32_t second = 0;
  if constexpr (!kCountsInHardware) {
    const std::size_t step = 8 * lanes;
    if (bytes >= step) {
      BitCounter a;
      BitCounter b;
      for (std::size_t steps = bytes / step; steps > 0;) {
        const std::size_t few = steps < 31 ? steps : 31;
        for (const auto end = i + few * step; i < end; i += step) {
          for (std::size_t line = 0; line < step; line += kBitAlignment) hwy::Prefetch(next + i + line);
          const auto r0 = hn::Load(d8, row + i);
          const auto r1 = hn::Load(d8, row + i + lanes);
          const auto r2 = hn::Load(d8, row + i + 2 * lanes);
          const auto r3 = hn::Load(d8, row + i + 3 * lanes);
          const auto r4 = hn::Load(d8, row + i + 4 * lanes);
          const auto r5 = hn::Load(d8, row + i + 5 * lanes);
          const auto r6 = hn::Load(d8, row + i + 6 * lanes);
          const auto r7 = hn::Load(d8, row + i + 7 * lanes);
          const auto* s = straight + i;
          a.Add8(hn::And(r0, hn::LoadU(d8, s)), hn::And(r1, hn::LoadU(d8, s + lanes)),
                 hn::And(r2, hn::LoadU(d8, s + 2 * lanes)), hn::And(r3, hn::LoadU(d8, s + 3 * lanes)),
                 hn::And(r4, hn::LoadU(d8, s + 4 * lanes)), hn::And(r5, hn::LoadU(d8, s + 5 * lanes)),
                 hn::And(r6, hn::LoadU(d8, s + 6 * lanes)), hn::And(r7, hn::LoadU(d8, s + 7 * lanes)));
          const auto* m = mirrored + i;
          b.Add8(hn::And(r0, hn::LoadU(d8, m)), hn::And(r1, hn::LoadU(d8, m + lanes)),
                 hn::And(r2, hn::LoadU(d8, m + 2 * lanes)), hn::And(r3, hn::LoadU(d8, m + 3 * lanes)),
                 hn::And(r4, hn::LoadU(d8, m + 4 * lanes)), hn::And(r5, hn::LoadU(d8, m + 5 * lanes)),
                 hn::And(r6, hn::LoadU(d8, m + 6 * lanes)), hn::And(r7, hn::LoadU(d8, m + 7 * lanes)));
        }
        a.Flush();
        b.Flush();
        steps -= few;
      }
      first = a.Total();
      second = b.Total();
    }
  }
  auto sum0 = hn::Zero(d64);
  auto sum1 = hn::Zero(d64);
  const std::size_t most = 31 * lanes;
  while (i < bytes) {
    const std::size_t end = bytes - i < most ? bytes : i + most;
    auto part0 = hn::Zero(d8);
    auto part1 = hn::Zero(d8);
    for (; i < end; i += lanes) {
      if (i % kBitAlignment == 0) hwy::Prefetch(next + i);
      const auto r = hn::Load(d8, row + i);
      part0 = hn::Add(part0, hn::PopulationCount(hn::And(r, hn::LoadU(d8, straight + i))));
      part1 = hn::Add(part1, hn::PopulationCount(hn::And(r, hn::LoadU(d8, mirrored + i))));
    }
    sum0 = hn::Add(sum0, hn::SumsOf8(part0));
    sum1 = hn::Add(sum1, hn::SumsOf8(part1));
  }
  counts[0] += first + static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(d64, sum0)));
  counts[1] += second + static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(d64, sum1)));
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
HWY_EXPORT(AndCountTwice);
HWY_EXPORT(NameOfTarget);

void and_count_block_scalar(const std::uint8_t* const* rows, const std::uint8_t* const* cols, std::size_t bytes,
                            std::uint32_t* counts) {
  for (std::size_t i = 0; i < kBlockRows; ++i) {
    for (std::size_t j = 0; j < kBlockCols; ++j) {
      counts[i * kBlockCols + j] += and_count_scalar(rows[i * kBlockCols + j], cols[j], bytes);
    }
  }
}

void and_count_twice_scalar(const std::uint8_t* row, const std::uint8_t* straight, const std::uint8_t* mirrored,
                            std::size_t bytes, const std::uint8_t* /*next*/, std::uint32_t* counts) {
  counts[0] += and_count_scalar(row, straight, bytes);
  counts[1] += and_count_scalar(row, mirrored, bytes);
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
    kernels.push_back({HWY_DISPATCH_TABLE(NameOfTarget)[index](), HWY_DISPATCH_TABLE(AndCountBlock)[index],
                       HWY_DISPATCH_TABLE(AndCountTwice)[index]});
  }
  kernels.push_back({"scalar", &and_count_block_scalar, &and_count_twice_scalar});
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

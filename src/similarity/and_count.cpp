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

// How far ahead of the counting memory is asked for: into the next row, where this one ends before.
constexpr std::size_t kAhead = 1024;

// The bits of a stream of vectors, eight at a time.
class BitCounter {
 public:
  HWY_INLINE BitCounter() : ones_(hn::Zero(D8())), twos_(ones_), fours_(ones_), part_(ones_), sum_(hn::Zero(D64())) {}

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
      // The two halves are read side by side: a processor follows two streams of memory faster than one.
      const std::size_t half = bytes / step * (step / 2);
      BitCounter a;
      BitCounter b;
      for (std::size_t steps = bytes / step; steps > 0;) {
        const std::size_t few = steps < 31 ? steps : 31;
        for (const auto end = i + few * (step / 2); i < end; i += step / 2) {
          const auto* ahead = i + kAhead < half ? row + i + kAhead : next + (i + kAhead - half);
          for (std::size_t line = 0; line < step / 2; line += kBitAlignment) {
            hwy::Prefetch(ahead + line);
            hwy::Prefetch(ahead + half + line);
          }
          const auto* r = row + i;
          const auto r0 = hn::LoadU(d8, r);
          const auto r1 = hn::LoadU(d8, r + lanes);
          const auto r2 = hn::LoadU(d8, r + 2 * lanes);
          const auto r3 = hn::LoadU(d8, r + 3 * lanes);
          const auto r4 = hn::LoadU(d8, r + half);
          const auto r5 = hn::LoadU(d8, r + half + lanes);
          const auto r6 = hn::LoadU(d8, r + half + 2 * lanes);
          const auto r7 = hn::LoadU(d8, r + half + 3 * lanes);
          const auto* s = straight + i;
          a.Add8(hn::And(r0, hn::LoadU(d8, s)), hn::And(r1, hn::LoadU(d8, s + lanes)),
                 hn::And(r2, hn::LoadU(d8, s + 2 * lanes)), hn::And(r3, hn::LoadU(d8, s + 3 * lanes)),
                 hn::And(r4, hn::LoadU(d8, s + half)), hn::And(r5, hn::LoadU(d8, s + half + lanes)),
                 hn::And(r6, hn::LoadU(d8, s + half + 2 * lanes)), hn::And(r7, hn::LoadU(d8, s + half + 3 * lanes)));
          const auto* m = mirrored + i;
          b.Add8(hn::And(r0, hn::LoadU(d8, m)), hn::And(r1, hn::LoadU(d8, m + lanes)),
                 hn::And(r2, hn::LoadU(d8, m + 2 * lanes)), hn::And(r3, hn::LoadU(d8, m + 3 * lanes)),
                 hn::And(r4, hn::LoadU(d8, m + half)), hn::And(r5, hn::LoadU(d8, m + half + lanes)),
                 hn::And(r6, hn::LoadU(d8, m + half + 2 * lanes)), hn::And(r7, hn::LoadU(d8, m + half + 3 * lanes)));
        }
        a.Flush();
        b.Flush();
        steps -= few;
      }
      i = 2 * half;
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
      if (i % kBitAlignment == 0) hwy::Prefetch(i + kAhead < bytes ? row + i + kAhead : next + (i + kAhead - bytes));
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

using D16 = hn::CappedTag<std::uint16_t, kRunLanes>;

void RunSums(const std::uint8_t* columns, std::size_t line_bytes, std::size_t lines, std::uint16_t* sums) {
  const D16 d16;
  const hn::Rebind<std::uint8_t, D16> d8;
  const std::size_t lanes = hn::Lanes(d16);
  for (std::size_t line = 0; line < lines; ++line) {
    for (std::size_t lane = 0; lane < kRunLanes; lane += lanes) {
      const auto* in = columns + line * line_bytes * kRunLanes + lane;
      auto* out = sums + line * sums_per_line(line_bytes) + lane;
      auto sum = hn::Zero(d16);
      for (int k = 0; k < 2; ++k, out += kRunLanes) hn::Store(sum, d16, out);
      for (std::size_t byte = 0; byte < line_bytes; ++byte, in += kRunLanes) {
        const auto pixels = hn::LoadU(d8, in);
        auto part = hn::Zero(d8);
        for (int k = 0; k < 8; ++k, out += kRunLanes) {
          const auto bit = hn::Set(d8, static_cast<std::uint8_t>(1U << k));
          // Where the bit is set the comparison gives 255, which is -1.
          part = hn::Sub(part, hn::VecFromMask(d8, hn::Eq(hn::And(pixels, bit), bit)));
          hn::Store(hn::Add(sum, hn::PromoteTo(d16, part)), d16, out);
        }
        sum = hn::Add(sum, hn::PromoteTo(d16, part));
      }
      hn::Store(sum, d16, out);
    }
  }
}

// Adds the runs in `vectors` neighbouring vectors of lanes.
template <std::size_t kVectors>
HWY_INLINE void RunCountOf(const std::uint16_t* sums, const std::uint32_t* places, std::size_t count,
                           std::uint16_t* out) {
  const D16 d16;
  const std::size_t lanes = hn::Lanes(d16);
  auto ends0 = hn::Zero(d16);
  auto ends1 = ends0;
  auto begins0 = ends0;
  auto begins1 = ends0;
  for (std::size_t k = 0; k < count; k += 2) {
    const auto* begin = sums + places[k];
    const auto* end = sums + places[k + 1];
    begins0 = hn::Add(begins0, hn::Load(d16, begin));
    ends0 = hn::Add(ends0, hn::Load(d16, end));
    if constexpr (kVectors == 2) {
      begins1 = hn::Add(begins1, hn::Load(d16, begin + lanes));
      ends1 = hn::Add(ends1, hn::Load(d16, end + lanes));
    }
  }
  // The sums may have passed 65,535; their difference has not.
  hn::Store(hn::Sub(ends0, begins0), d16, out);
  if constexpr (kVectors == 2) hn::Store(hn::Sub(ends1, begins1), d16, out + lanes);
}

void RunCount(const std::uint16_t* sums, const std::uint32_t* places, std::size_t count, std::uint32_t* counts) {
  HWY_ALIGN std::uint16_t common[kRunLanes];
  const std::size_t lanes = hn::Lanes(D16());
  if (lanes == kRunLanes) {
    RunCountOf<1>(sums, places, count, common);
  } else {
    for (std::size_t lane = 0; lane < kRunLanes; lane += 2 * lanes) {
      RunCountOf<2>(sums + lane, places, count, common + lane);
    }
  }
  for (std::size_t lane = 0; lane < kRunLanes; ++lane) counts[lane] += common[lane];
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

HWY_EXPORT(AndCountTwice);
HWY_EXPORT(RunSums);
HWY_EXPORT(RunCount);
HWY_EXPORT(NameOfTarget);

void and_count_twice_scalar(const std::uint8_t* row, const std::uint8_t* straight, const std::uint8_t* mirrored,
                            std::size_t bytes, const std::uint8_t* /*next*/, std::uint32_t* counts) {
  counts[0] += and_count_scalar(row, straight, bytes);
  counts[1] += and_count_scalar(row, mirrored, bytes);
}

void run_sums_scalar(const std::uint8_t* columns, std::size_t line_bytes, std::size_t lines, std::uint16_t* sums) {
  const auto width = 8 * line_bytes;
  for (std::size_t line = 0; line < lines; ++line) {
    for (std::size_t lane = 0; lane < kRunLanes; ++lane) {
      std::uint16_t sum = 0;
      for (std::size_t place = 0; place < width + 3; ++place) {
        // Place 1 + x: the pixel left of x is at place - 2.
        if (place >= 2 && place < width + 2) {
          const auto x = place - 2;
          const auto byte = columns[(line * line_bytes + x / 8) * kRunLanes + lane];
          sum = static_cast<std::uint16_t>(sum + (byte >> (x % 8) & 1));
        }
        sums[line * sums_per_line(line_bytes) + place * kRunLanes + lane] = sum;
      }
    }
  }
}

void run_count_scalar(const std::uint16_t* sums, const std::uint32_t* places, std::size_t count,
                      std::uint32_t* counts) {
  for (std::size_t k = 0; k < count; k += 2) {
    for (std::size_t lane = 0; lane < kRunLanes; ++lane) {
      counts[lane] += std::uint32_t{sums[places[k + 1] + lane]} - sums[places[k] + lane];
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
    kernels.push_back({HWY_DISPATCH_TABLE(NameOfTarget)[index](), HWY_DISPATCH_TABLE(AndCountTwice)[index],
                       HWY_DISPATCH_TABLE(RunSums)[index], HWY_DISPATCH_TABLE(RunCount)[index]});
  }
  kernels.push_back({"scalar", &and_count_twice_scalar, &run_sums_scalar, &run_count_scalar});
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

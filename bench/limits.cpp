// SPDX-License-Identifier: Apache-2.0
// Compiled once for every instruction set: Highway includes this file again for each of them.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bench/limits.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

#include "limits.hpp"

HWY_BEFORE_NAMESPACE();
namespace choreo::bench::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

std::uint64_t AndCount(const std::uint8_t* stream, std::size_t bytes) {
  const hn::CappedTag<std::uint8_t, 64> d8;
  const hn::Repartition<std::uint64_t, decltype(d8)> d64;
  const std::size_t lanes = hn::Lanes(d8);
  const auto held = hn::Load(d8, stream);
  auto sum = hn::Zero(d64);
  // Four accumulators hide the additions' latency; each takes at most 31 counts of at most 8.
  for (std::size_t i = 0; i < bytes;) {
    auto part0 = hn::Zero(d8);
    auto part1 = part0;
    auto part2 = part0;
    auto part3 = part0;
    for (int k = 0; k < 16 && i < bytes; ++k, i += 4 * lanes) {
      part0 = hn::Add(part0, hn::PopulationCount(hn::And(held, hn::Load(d8, stream + i))));
      part1 = hn::Add(part1, hn::PopulationCount(hn::And(held, hn::Load(d8, stream + i + lanes))));
      part2 = hn::Add(part2, hn::PopulationCount(hn::And(held, hn::Load(d8, stream + i + 2 * lanes))));
      part3 = hn::Add(part3, hn::PopulationCount(hn::And(held, hn::Load(d8, stream + i + 3 * lanes))));
    }
    sum = hn::Add(
        sum, hn::Add(hn::Add(hn::SumsOf8(part0), hn::SumsOf8(part1)), hn::Add(hn::SumsOf8(part2), hn::SumsOf8(part3))));
  }
  return hn::GetLane(hn::SumOfLanes(d64, sum));
}

std::uint64_t Read(const std::uint8_t* stream, std::size_t bytes) {
  const hn::CappedTag<std::uint64_t, 8> d64;
  const std::size_t lanes = hn::Lanes(d64);
  auto a0 = hn::Zero(d64);
  auto a1 = a0;
  auto a2 = a0;
  auto a3 = a0;
  auto a4 = a0;
  auto a5 = a0;
  auto a6 = a0;
  auto a7 = a0;
  const auto* p = reinterpret_cast<const std::uint64_t*>(stream);
  const auto* end = reinterpret_cast<const std::uint64_t*>(stream + bytes);
  for (; p < end; p += 8 * lanes) {
    a0 = hn::Or(a0, hn::Load(d64, p));
    a1 = hn::Or(a1, hn::Load(d64, p + lanes));
    a2 = hn::Or(a2, hn::Load(d64, p + 2 * lanes));
    a3 = hn::Or(a3, hn::Load(d64, p + 3 * lanes));
    a4 = hn::Or(a4, hn::Load(d64, p + 4 * lanes));
    a5 = hn::Or(a5, hn::Load(d64, p + 5 * lanes));
    a6 = hn::Or(a6, hn::Load(d64, p + 6 * lanes));
    a7 = hn::Or(a7, hn::Load(d64, p + 7 * lanes));
  }
  const auto all = hn::Or(hn::Or(hn::Or(a0, a1), hn::Or(a2, a3)), hn::Or(hn::Or(a4, a5), hn::Or(a6, a7)));
  return hn::GetLane(hn::SumOfLanes(d64, all));
}

// Twelve sums hide the latency of an operation. @return a number that depends on all of it.
float MultiplyAdd(std::size_t rounds) {
  const hn::ScalableTag<float> d;
  const auto factor = hn::Set(d, 0.999F);
  const auto term = hn::Set(d, 1e-3F);
  auto a0 = term, a1 = term, a2 = term, a3 = term, a4 = term, a5 = term;
  auto b0 = term, b1 = term, b2 = term, b3 = term, b4 = term, b5 = term;
  for (std::size_t k = 0; k < rounds; ++k) {
    a0 = hn::MulAdd(a0, factor, term);
    a1 = hn::MulAdd(a1, factor, term);
    a2 = hn::MulAdd(a2, factor, term);
    a3 = hn::MulAdd(a3, factor, term);
    a4 = hn::MulAdd(a4, factor, term);
    a5 = hn::MulAdd(a5, factor, term);
    b0 = hn::MulAdd(b0, factor, term);
    b1 = hn::MulAdd(b1, factor, term);
    b2 = hn::MulAdd(b2, factor, term);
    b3 = hn::MulAdd(b3, factor, term);
    b4 = hn::MulAdd(b4, factor, term);
    b5 = hn::MulAdd(b5, factor, term);
  }
  const auto a = hn::Add(hn::Add(hn::Add(a0, a1), hn::Add(a2, a3)), hn::Add(a4, a5));
  const auto b = hn::Add(hn::Add(hn::Add(b0, b1), hn::Add(b2, b3)), hn::Add(b4, b5));
  return hn::GetLane(hn::SumOfLanes(d, hn::Add(a, b)));
}

std::size_t FloatsARound() { return 12 * hn::Lanes(hn::ScalableTag<float>()); }

const char* NameOfTarget() { return hwy::TargetName(HWY_TARGET); }

}  // namespace choreo::bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstring>

namespace choreo::bench {
namespace {

HWY_EXPORT(AndCount);
HWY_EXPORT(Read);
HWY_EXPORT(MultiplyAdd);
HWY_EXPORT(FloatsARound);
HWY_EXPORT(NameOfTarget);

template <typename Take>
std::uint64_t over_words(const std::uint8_t* stream, std::size_t bytes, Take take) {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < bytes; i += sizeof sum) {
    std::uint64_t word = 0;
    std::memcpy(&word, stream + i, sizeof word);
    sum = take(sum, word);
  }
  return sum;
}

std::uint64_t and_count_plain(const std::uint8_t* stream, std::size_t bytes) {
  std::uint64_t held = 0;
  std::memcpy(&held, stream, sizeof held);
  return over_words(stream, bytes, [held](std::uint64_t sum, std::uint64_t word) {
    return sum + static_cast<std::uint64_t>(std::popcount(held & word));
  });
}

std::uint64_t read_plain(const std::uint8_t* stream, std::size_t bytes) {
  return over_words(stream, bytes, [](std::uint64_t sum, std::uint64_t word) { return sum | word; });
}

}  // namespace

double multiply_add_rate() {
  constexpr std::size_t kRounds = 2'000'000;
  volatile float kept = 0;
  double best = 0;
  for (int turn = 0; turn < 5; ++turn) {
    const auto begin = std::chrono::steady_clock::now();
    kept = kept + HWY_DYNAMIC_DISPATCH(MultiplyAdd)(kRounds);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    best = std::max(best, 2.0 * double(kRounds * HWY_DYNAMIC_DISPATCH(FloatsARound)()) / took.count());
  }
  return best;
}

Limits limits_of(const std::string& kernel) {
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::ChosenTarget choice;
    choice.Update(target);
    const auto index = choice.GetIndex();
    if (kernel == HWY_DISPATCH_TABLE(NameOfTarget)[index]()) {
      return {HWY_DISPATCH_TABLE(AndCount)[index], HWY_DISPATCH_TABLE(Read)[index]};
    }
  }
  return {&and_count_plain, &read_plain};
}

}  // namespace choreo::bench

#endif  // HWY_ONCE

// SPDX-License-Identifier: Apache-2.0
// Every compiled kernel against the specification.
#include "similarity/and_count.hpp"

#include <array>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "core/error.hpp"

namespace choreo::similarity {
namespace {

class Bits {
 public:
  explicit Bits(std::size_t bytes)
      : bytes_(static_cast<std::uint8_t*>(std::aligned_alloc(kBitAlignment, bytes + kBitAlignment)), &std::free) {
    std::memset(bytes_.get(), 0, bytes + kBitAlignment);
  }
  std::uint8_t* get() { return bytes_.get(); }

 private:
  std::unique_ptr<std::uint8_t, void (*)(void*)> bytes_;
};

// Sizes around the places where a kernel changes its step: its vector, eight of them that are added in columns, and the
// 31 vectors whose counts a byte holds.
std::vector<std::size_t> sizes() {
  std::vector<std::size_t> all = {0, 64, 128, 192, 4096, 65536};
  for (const std::size_t lanes : {16, 32, 64}) {
    const auto limit = 31 * lanes / kBitAlignment * kBitAlignment;
    for (const auto around : {limit - 64, limit, limit + 64, 2 * limit, 2 * limit + 64}) all.push_back(around);
    for (const auto around : {8 * lanes, 248 * lanes}) {
      for (const auto size : {around - 64, around, around + 64}) all.push_back(size);
    }
  }
  return all;
}

enum class Fill { kRandom, kOnes, kSparse };

void fill(std::uint8_t* bits, std::size_t bytes, Fill how, std::mt19937& random) {
  for (std::size_t i = 0; i < bytes; ++i) {
    const auto any = static_cast<std::uint8_t>(random());
    bits[i] = how == Fill::kOnes ? 0xFF : how == Fill::kRandom ? any : static_cast<std::uint8_t>(any % 97 == 0);
  }
}

TEST(AndCount, TheSpecificationCountsCommonBits) {
  alignas(64) std::array<std::uint8_t, 64> a{};
  alignas(64) std::array<std::uint8_t, 64> b{};
  EXPECT_EQ(and_count_scalar(a.data(), b.data(), 64), 0U);
  a[0] = 0b1011;
  b[0] = 0b0110;
  EXPECT_EQ(and_count_scalar(a.data(), b.data(), 64), 1U);
  a[63] = 0xFF;
  b[63] = 0x81;
  EXPECT_EQ(and_count_scalar(a.data(), b.data(), 64), 3U);
  EXPECT_EQ(and_count_scalar(a.data(), b.data(), 0), 0U);
}

TEST(AndCount, EveryKernelCountsAsTheSpecificationDoes) {
  std::mt19937 random(21);
  for (const auto& kernel : and_count_kernels()) {
    for (const auto bytes : sizes()) {
      for (const auto how : {Fill::kRandom, Fill::kOnes, Fill::kSparse}) {
        std::vector<Bits> strings;
        for (int k = 0; k < 6; ++k) {
          strings.emplace_back(bytes);
          fill(strings.back().get(), bytes, how, random);
        }
        const std::array<const std::uint8_t*, 4> rows = {strings[0].get(), strings[1].get(), strings[2].get(),
                                                         strings[3].get()};
        const std::array<const std::uint8_t*, 2> cols = {strings[4].get(), strings[5].get()};
        // It adds to what is there.
        std::array<std::uint32_t, 4> counts = {1, 20, 300, 4000};
        auto expected = counts;
        for (std::size_t i = 0; i < 4; ++i) expected[i] += and_count_scalar(rows[i], cols[i % 2], bytes);
        kernel.block(rows.data(), cols.data(), bytes, counts.data());
        EXPECT_EQ(counts, expected) << kernel.name << ", " << bytes << " bytes, fill " << int(how);
        if (how == Fill::kOnes) {
          EXPECT_EQ(counts[3], 4000 + 8 * bytes) << "no lane overflows";
        }
      }
    }
  }
}

TEST(AndCount, EveryKernelCountsOneReadingTwice) {
  std::mt19937 random(22);
  for (const auto& kernel : and_count_kernels()) {
    for (const auto bytes : sizes()) {
      for (const auto how : {Fill::kRandom, Fill::kOnes, Fill::kSparse}) {
        Bits row(bytes);
        fill(row.get(), bytes, how, random);
        // The two others lie at any address.
        for (const std::size_t offset : {0, 4, 37}) {
          Bits straight(bytes + 64);
          Bits mirrored(bytes + 64);
          fill(straight.get(), bytes + 64, how, random);
          fill(mirrored.get(), bytes + 64, how, random);
          const auto* first = straight.get() + offset;
          const auto* second = mirrored.get() + 64 - offset;
          std::array<std::uint32_t, 2> counts = {1, 20};
          const std::array<std::uint32_t, 2> expected = {1 + and_count_scalar(row.get(), first, bytes),
                                                         20 + and_count_scalar(row.get(), second, bytes)};
          kernel.twice(row.get(), first, second, bytes, row.get(), counts.data());
          EXPECT_EQ(counts, expected) << kernel.name << ", " << bytes << " bytes, fill " << int(how);
        }
      }
    }
  }
}

TEST(AndCount, ReadsNothingPastTheEnd) {
  for (const auto& kernel : and_count_kernels()) {
    Bits ones(64);
    std::memset(ones.get(), 0xFF, 128);  // 64 bytes beyond the length given.
    const std::array<const std::uint8_t*, 4> rows = {ones.get(), ones.get(), ones.get(), ones.get()};
    std::array<std::uint32_t, 4> counts{};
    kernel.block(rows.data(), rows.data(), 64, counts.data());
    EXPECT_EQ(counts, (std::array<std::uint32_t, 4>{512, 512, 512, 512})) << kernel.name;
    std::array<std::uint32_t, 2> two{};
    kernel.twice(ones.get(), ones.get(), ones.get(), 64, ones.get(), two.data());
    EXPECT_EQ(two, (std::array<std::uint32_t, 2>{512, 512})) << kernel.name;
  }
}

TEST(AndCount, TheKernelsAreDifferentCodeUnderDifferentNamesAndEndWithTheSpecification) {
  const auto kernels = and_count_kernels();
  std::set<std::string> names;
  std::set<AndCountBlock> blocks;
  for (const auto& kernel : kernels) {
    names.insert(kernel.name);
    blocks.insert(kernel.block);
  }
  EXPECT_EQ(names.size(), kernels.size());
  EXPECT_EQ(blocks.size(), kernels.size());
  EXPECT_EQ(kernels.back().name, "scalar");
}

#if defined(__x86_64__) && defined(__GNUC__)
TEST(AndCount, TheNamesAreThoseOfWhatThisProcessorCanRun) {
  const auto kernels = and_count_kernels();
  std::set<std::string> names;
  for (const auto& kernel : kernels) names.insert(kernel.name);
  // The processor is asked here by another way than Highway's.
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
  const bool avx3 = avx2 && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
                    __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512cd");
  const bool avx3_dl = avx3 && __builtin_cpu_supports("avx512vpopcntdq") && __builtin_cpu_supports("avx512bitalg") &&
                       __builtin_cpu_supports("avx512vbmi2") && __builtin_cpu_supports("gfni") &&
                       __builtin_cpu_supports("vaes");
  EXPECT_EQ(names.contains("AVX2"), avx2);
  EXPECT_EQ(names.contains("AVX3"), avx3);
  EXPECT_EQ(names.contains("AVX3_DL"), avx3_dl);
  if (avx2) {
    EXPECT_EQ(kernels.front().name, avx3_dl ? "AVX3_DL" : avx3 ? "AVX3" : "AVX2");
  }
}
#endif

TEST(AndCount, WithoutANameTheBestIsChosen) {
  EXPECT_EQ(choose_and_count("").name, and_count_kernels().front().name);
  EXPECT_EQ(choose_and_count().block, and_count_kernels().front().block);
}

TEST(AndCount, EveryKernelIsHadByItsName) {
  for (const auto& kernel : and_count_kernels()) {
    const auto chosen = choose_and_count(kernel.name);
    EXPECT_EQ(chosen.name, kernel.name);
    EXPECT_EQ(chosen.block, kernel.block);
  }
}

TEST(AndCount, AnUnknownNameIsRefusedAndTheKnownOnesAreListed) {
  for (const auto* name : {"MMX", "avx2 ", "Scalar"}) {
    try {
      (void)choose_and_count(name);
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.fault(), Fault::kUsage);
      EXPECT_NE(std::string(error.what()).find('"' + std::string(name) + '"'), std::string::npos) << error.what();
      for (const auto& kernel : and_count_kernels()) {
        EXPECT_NE(error.hint().find(kernel.name), std::string::npos) << error.hint();
      }
    }
  }
}

}  // namespace
}  // namespace choreo::similarity

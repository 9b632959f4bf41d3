// SPDX-License-Identifier: Apache-2.0
// Every compiled kernel against the specification.
#include "similarity/and_count.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "similarity/bit_buffer.hpp"

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
          // It adds to what is there.
          std::array<std::uint32_t, 2> counts = {1, 20};
          const std::array<std::uint32_t, 2> expected = {1 + and_count_scalar(row.get(), first, bytes),
                                                         20 + and_count_scalar(row.get(), second, bytes)};
          kernel.twice(row.get(), first, second, bytes, row.get(), counts.data());
          EXPECT_EQ(counts, expected) << kernel.name << ", " << bytes << " bytes, fill " << int(how);
          if (how == Fill::kOnes) {
            EXPECT_EQ(counts[1], 20 + 8 * bytes) << "no lane overflows";
          }
        }
      }
    }
  }
}

TEST(AndCount, ReadsNothingPastTheEnd) {
  for (const auto& kernel : and_count_kernels()) {
    Bits ones(64);
    std::memset(ones.get(), 0xFF, 128);  // 64 bytes beyond the length given.
    std::array<std::uint32_t, 2> two{};
    kernel.twice(ones.get(), ones.get(), ones.get(), 64, ones.get(), two.data());
    EXPECT_EQ(two, (std::array<std::uint32_t, 2>{512, 512})) << kernel.name;
  }
}

// What sums[...] of a line must be, by its meaning.
std::uint32_t pixels_left_of(const std::uint8_t* columns, std::size_t lane, std::size_t x) {
  std::uint32_t count = 0;
  for (std::size_t k = 0; k < x; ++k) count += columns[k / 8 * kRunLanes + lane] >> (k % 8) & 1U;
  return count;
}

TEST(RunSums, EveryKernelSumsUpEveryLineFromTheLeft) {
  std::mt19937 random(23);
  for (const auto& kernel : and_count_kernels()) {
    for (const std::size_t line_bytes : {1, 2, 5, 8, 81}) {
      const std::size_t lines = 3;
      std::vector<std::uint8_t> columns(lines * line_bytes * kRunLanes);
      for (const auto how : {Fill::kRandom, Fill::kOnes, Fill::kSparse}) {
        fill(columns.data(), columns.size(), how, random);
        auto sums = make_bit_buffer(padded(lines * sums_per_line(line_bytes) * sizeof(std::uint16_t)));
        auto* values = reinterpret_cast<std::uint16_t*>(sums.get());
        kernel.sums(columns.data(), line_bytes, lines, values);
        const auto width = 8 * line_bytes;
        for (std::size_t line = 0; line < lines; ++line) {
          const auto* of_line = columns.data() + line * line_bytes * kRunLanes;
          for (std::size_t place = 0; place < width + 3; ++place) {
            // The places before 1 and after 1 + width repeat their neighbours.
            const auto x = std::min(std::max<std::size_t>(place, 1) - 1, width);
            for (std::size_t lane = 0; lane < kRunLanes; ++lane) {
              ASSERT_EQ(values[line * sums_per_line(line_bytes) + place * kRunLanes + lane],
                        pixels_left_of(of_line, lane, x))
                  << kernel.name << ", line " << line << ", place " << place << ", lane " << lane;
            }
          }
        }
      }
    }
  }
}

TEST(RunSums, TheWidestLineFits) {
  const std::size_t line_bytes = 0xFFFF / 8;
  const std::vector<std::uint8_t> columns(line_bytes * kRunLanes, 0xFF);
  for (const auto& kernel : and_count_kernels()) {
    auto sums = make_bit_buffer(padded(sums_per_line(line_bytes) * sizeof(std::uint16_t)));
    const auto* values = reinterpret_cast<std::uint16_t*>(sums.get());
    kernel.sums(columns.data(), line_bytes, 1, reinterpret_cast<std::uint16_t*>(sums.get()));
    EXPECT_EQ(values[(8 * line_bytes + 1) * kRunLanes], 8 * line_bytes) << kernel.name;
    const std::array<std::uint32_t, 2> whole = {kRunLanes, std::uint32_t((8 * line_bytes + 1) * kRunLanes)};
    std::array<std::uint32_t, kRunLanes> counts{};
    kernel.runs(values, whole.data(), 2, counts.data());
    EXPECT_EQ(counts[kRunLanes - 1], 8 * line_bytes) << kernel.name;
  }
}

TEST(RunCount, EveryKernelAddsTheDifferencesAtTheEndsOfRuns) {
  std::mt19937 random(24);
  // Sums that pass 65,535 together, whose differences do not.
  const std::size_t length = 200;
  auto buffer = make_bit_buffer(length * kRunLanes * sizeof(std::uint16_t));
  auto* sums = reinterpret_cast<std::uint16_t*>(buffer.get());
  for (std::size_t k = 0; k < length * kRunLanes; ++k) sums[k] = std::uint16_t(60000 + k / kRunLanes + random() % 2);
  for (const auto& kernel : and_count_kernels()) {
    for (const std::size_t runs : {0, 1, 2, 7, 90}) {
      std::vector<std::uint32_t> places;
      for (std::size_t k = 0; k < runs; ++k) {
        const auto begin = random() % (length - 10);
        places.push_back(std::uint32_t(begin * kRunLanes));
        places.push_back(std::uint32_t((begin + 2 + random() % 8) * kRunLanes));
      }
      std::array<std::uint32_t, kRunLanes> counts{};
      std::array<std::uint32_t, kRunLanes> expected{};
      for (std::size_t lane = 0; lane < kRunLanes; ++lane) {
        counts[lane] = expected[lane] = std::uint32_t(1000 * lane);
        for (std::size_t k = 0; k < places.size(); k += 2) {
          expected[lane] += std::uint32_t{sums[places[k + 1] + lane]} - sums[places[k] + lane];
        }
      }
      kernel.runs(sums, places.data(), places.size(), counts.data());
      EXPECT_EQ(counts, expected) << kernel.name << ", " << runs << " runs";
    }
  }
}

TEST(AndCount, TheKernelsAreDifferentCodeUnderDifferentNamesAndEndWithTheSpecification) {
  const auto kernels = and_count_kernels();
  std::set<std::string> names;
  std::set<AndCountTwice> loops;
  for (const auto& kernel : kernels) {
    names.insert(kernel.name);
    loops.insert(kernel.twice);
  }
  EXPECT_EQ(names.size(), kernels.size());
  EXPECT_EQ(loops.size(), kernels.size());
  EXPECT_EQ(kernels.back().name, "scalar");
}

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)  // clang 16 cannot ask for vaes.
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
  EXPECT_EQ(choose_and_count().twice, and_count_kernels().front().twice);
}

TEST(AndCount, EveryKernelIsHadByItsName) {
  for (const auto& kernel : and_count_kernels()) {
    const auto chosen = choose_and_count(kernel.name);
    EXPECT_EQ(chosen.name, kernel.name);
    EXPECT_EQ(chosen.twice, kernel.twice);
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

// SPDX-License-Identifier: Apache-2.0
// Mask similarity on one core: all pairs against plain OpenCV and against the population count at its best; a live row
// against the rate at which memory can be read.
#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>

#include "bodies.hpp"
#include "limits.hpp"
#include "report.hpp"
#include "similarity/all_pairs.hpp"
#include "similarity/mask_comparer.hpp"
#include "similarity/mask_history.hpp"
#include "timing.hpp"

namespace choreo::bench {
namespace {

using States = std::vector<std::unique_ptr<const body::MaskState>>;

const cv::Size kMaskSize(640, 480);
constexpr std::size_t kCachedBytes = 16 * 1024;  // Half a first cache.

std::size_t states_for(const Settings& settings) { return settings.smoke ? 40 : 512; }
// Rows of 40 KB: 160 MB, far larger than any cache.
std::size_t history_for(const Settings& settings) { return settings.smoke ? 40 : 4000; }
int turns_for(const Settings& settings, int quick, int full) {
  return settings.smoke ? 1 : settings.quick ? quick : full;
}

// Where every loop's result goes, so that no compiler leaves the loop out.
volatile std::uint64_t result_sink = 0;

std::vector<cv::Mat> random_bodies(unsigned seed, std::size_t count) {
  std::mt19937 random(seed);
  std::vector<cv::Mat> masks;
  for (std::size_t k = 0; k < count; ++k) masks.push_back(random_body(random, kMaskSize));
  return masks;
}

// Not zeros: a host may keep all pages of zeros in one place, which stays in the cache.
similarity::BitBuffer random_bytes(std::size_t bytes) {
  auto buffer = similarity::make_bit_buffer(bytes);
  std::mt19937 random(2);
  for (std::size_t k = 0; k < bytes; k += sizeof(std::uint32_t)) {
    const auto word = static_cast<std::uint32_t>(random());
    std::memcpy(buffer.get() + k, &word, sizeof word);
  }
  return buffer;
}

// The bodies' states; with a pixel in every corner, so that nothing can be cropped, or as they are.
States states_of(const std::vector<cv::Mat>& masks, bool corners) {
  States states;
  for (const auto& mask : masks) {
    cv::Mat stretched = mask.clone();
    if (corners) {
      for (const int y : {0, mask.rows - 1}) {
        for (const int x : {0, mask.cols - 1}) stretched.at<uchar>(y, x) = 255;
      }
    }
    states.push_back(std::make_unique<const body::MaskState>(stretched));
  }
  return states;
}

// Plain OpenCV: what anyone would write, mirrored masks and scratch made beforehand.
class Peer {
 public:
  explicit Peer(const std::vector<cv::Mat>& masks) : masks_(masks), both_(kMaskSize, CV_8UC1) {
    for (const auto& mask : masks) {
      cv::Mat mirrored;
      cv::flip(mask, mirrored, 1);
      mirrored_.push_back(mirrored);
    }
  }
  // Every `step`-th row of the upper triangle. Returns how many pairs.
  std::size_t run(std::size_t step) {
    std::size_t pairs = 0;
    std::uint64_t common = 0;
    for (std::size_t i = 0; i < masks_.size(); i += step) {
      for (std::size_t j = i; j < masks_.size(); ++j, ++pairs) {
        cv::bitwise_and(masks_[i], masks_[j], both_);
        common += static_cast<std::uint64_t>(cv::countNonZero(both_));
        cv::bitwise_and(mirrored_[i], masks_[j], both_);
        common += static_cast<std::uint64_t>(cv::countNonZero(both_));
      }
    }
    result_sink = common;
    return pairs;
  }

 private:
  const std::vector<cv::Mat>& masks_;
  std::vector<cv::Mat> mirrored_;
  cv::Mat both_;
};

// All pairs of a set of states, into matrices that exist already.
class AllPairs {
 public:
  AllPairs(const States& states, const similarity::AndCountKernel& kernel, similarity::MaskComparer::Method method)
      : comparer_(states, kernel, method), z_(states.size() * states.size()), zstar_(z_.size()) {}
  void run() {
    const auto n = comparer_.size();
    similarity::all_pairs(comparer_, {z_.data(), n, n}, {zstar_.data(), n, n});
  }
  [[nodiscard]] double pairs() const { return double(comparer_.size()) * double(comparer_.size() + 1) / 2; }
  [[nodiscard]] cv::Size canvas() const { return comparer_.canvas(); }

 private:
  similarity::MaskComparer comparer_;
  std::vector<float> z_;
  std::vector<float> zstar_;
};

std::string microseconds(double seconds) { return fmt::format("{:.3f} us", seconds * 1e6); }
std::string rate(double bytes_per_second) { return fmt::format("{:.1f} GB/s", bytes_per_second / 1e9); }
std::string times(double ratio) { return fmt::format("{:.1f} x", ratio); }
std::string percent(double ratio) { return fmt::format("{:.0f} %", 100 * ratio); }

void all_pairs(const Settings& settings, const similarity::AndCountKernel& kernel, const Limits& limits,
               Report& report) {
  const auto masks = random_bodies(1, states_for(settings));
  Peer peer(masks);
  using Method = similarity::MaskComparer::Method;
  AllPairs whole(states_of(masks, true), kernel, Method::kFaster);
  AllPairs cropped(states_of(masks, false), kernel, Method::kFaster);
  AllPairs bits(states_of(masks, true), kernel, Method::kBits);
  const auto cached = random_bytes(kCachedBytes);

  const std::size_t step = settings.quick ? 32 : 16;
  const std::size_t limit_rounds = 500;
  std::size_t peer_pairs = 0;
  const auto medians =
      interleaved_medians(turns_for(settings, 9, 41), {
                                                          [&] { peer_pairs = peer.run(step); },
                                                          [&] { whole.run(); },
                                                          [&] { cropped.run(); },
                                                          [&] { bits.run(); },
                                                          [&] {
                                                            std::uint64_t sum = 0;
                                                            for (std::size_t k = 0; k < limit_rounds; ++k)
                                                              sum += limits.and_count(cached.get(), kCachedBytes);
                                                            result_sink = sum;
                                                          },
                                                      });
  // The bytes of AND results that a pair takes: two bit strings of a picture.
  const double pair_bytes = 2.0 * kMaskSize.area() / 8;
  const double peer_pair = medians[0] / double(peer_pairs);
  const double whole_pair = medians[1] / whole.pairs();
  const double cropped_pair = medians[2] / cropped.pairs();
  const double bits_pair = medians[3] / bits.pairs();
  const double limit_pair = pair_bytes / (double(limit_rounds * kCachedBytes) / medians[4]);
  report.notes.push_back(fmt::format(
      "{} random bodies at {} x {}, Z and Z* of a pair. Peer: cv::bitwise_and and cv::countNonZero on 8-bit masks, one "
      "thread.",
      masks.size(), kMaskSize.width, kMaskSize.height));
  report.lines.push_back({"all pairs, whole frame", microseconds(peer_pair), microseconds(whole_pair),
                          microseconds(limit_pair), times(peer_pair / whole_pair), percent(limit_pair / whole_pair)});
  report.lines.push_back({fmt::format("all pairs, cropped to {} x {}", cropped.canvas().width, cropped.canvas().height),
                          microseconds(peer_pair), microseconds(cropped_pair), "", times(peer_pair / cropped_pair),
                          ""});
  report.lines.push_back({"all pairs, whole frame, by bits", microseconds(peer_pair), microseconds(bits_pair),
                          microseconds(limit_pair), times(peer_pair / bits_pair), percent(limit_pair / bits_pair)});
  report.figures["all_pairs_vs_opencv"] = peer_pair / whole_pair;
  report.figures["all_pairs_cropped_vs_opencv"] = peer_pair / cropped_pair;
  report.figures["all_pairs_vs_popcount_limit"] = limit_pair / whole_pair;
  report.figures["all_pairs_bits_vs_opencv"] = peer_pair / bits_pair;
  report.figures["all_pairs_bits_vs_popcount_limit"] = limit_pair / bits_pair;
}

void live_row(const Settings& settings, const similarity::AndCountKernel& kernel, const Limits& limits,
              Report& report) {
  const auto masks = random_bodies(3, 64);
  const auto length = history_for(settings);
  const auto whole = states_of(masks, true);
  const auto cropped = states_of(masks, false);
  similarity::MaskHistory whole_history(kMaskSize, length, kernel);
  similarity::MaskHistory cropped_history(kMaskSize, length, kernel);
  for (std::size_t k = 0; k < length; ++k) {
    whole_history.remember(whole[k % whole.size()].get());
    cropped_history.remember(cropped[k % cropped.size()].get());
  }
  const std::size_t stream_bytes = length * std::size_t(kMaskSize.area()) / 8 / 1024 * 1024;
  const auto stream = random_bytes(stream_bytes);
  std::vector<float> z(length);
  std::vector<float> zstar(length);
  std::size_t next = 0;
  const auto medians =
      interleaved_medians(turns_for(settings, 15, 61),
                          {
                              [&] { whole_history.append(whole[next++ % whole.size()].get(), z, zstar); },
                              [&] { cropped_history.append(cropped[next++ % cropped.size()].get(), z, zstar); },
                              [&] { result_sink = limits.read(stream.get(), stream_bytes); },
                          });
  const double read_rate = double(stream_bytes) / medians[2];
  const auto line = [&](const std::string& what, const similarity::MaskHistory& history, double seconds) {
    const double row_rate = double(history.bytes_read()) / seconds;
    report.lines.push_back({what, "", rate(row_rate), rate(read_rate), "", percent(row_rate / read_rate)});
    report.lines.push_back({fmt::format("  a pair, {:.1f} KB", double(history.bytes_read()) / length / 1e3), "",
                            microseconds(seconds / length), "", "", ""});
    return row_rate / read_rate;
  };
  report.notes.push_back(
      fmt::format("A live row: Z and Z* against {} rows in memory. Limit: reading, one core.", length));
  report.figures["live_row_vs_stream_read"] = line("live row, whole frame", whole_history, medians[0]);
  report.figures["live_row_cropped_vs_stream_read"] = line("live row, cropped", cropped_history, medians[1]);
}

}  // namespace

void kernels(const Settings& settings, Report& report) {
  const tbb::global_control one_core(tbb::global_control::max_allowed_parallelism, 1);
  cv::setNumThreads(1);
  const auto kernel = similarity::choose_and_count();
  const auto limits = limits_of(kernel.name);
  report.notes.push_back(fmt::format("{} kernel, one core", kernel.name));
  // The history first, while the memory is fresh: large pages are soon hard to come by.
  live_row(settings, kernel, limits, report);
  all_pairs(settings, kernel, limits, report);
}

}  // namespace choreo::bench

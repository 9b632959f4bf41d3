// SPDX-License-Identifier: Apache-2.0
#include "vision/colour_modes.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdlib>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace choreo::vision {
namespace {

struct Cluster {
  std::array<int, 3> mean{};
  std::array<int, 3> sum{};
  int count = 0;
};

// The greatest distance of any channel.
int distance(const Cluster& c, const std::uint8_t* p) {
  return std::max({std::abs(p[0] - c.mean[0]), std::abs(p[1] - c.mean[1]), std::abs(p[2] - c.mean[2])});
}

// Insertion: there are five at most, and equals keep their order.
void commonest_first(std::array<Cluster, ColourModes::kMost>& clusters, std::size_t used) {
  for (std::size_t i = 1; i < used; ++i) {
    for (std::size_t k = i; k > 0 && clusters[k].count > clusters[k - 1].count; --k)
      std::swap(clusters[k], clusters[k - 1]);
  }
}

}  // namespace

ColourModes colour_modes(std::span<const cv::Mat> pictures, int radius) {
  assert(!pictures.empty());
  ColourModes out;
  out.size = pictures.front().size();
  out.pictures = static_cast<int>(pictures.size());
  out.modes.resize(std::size_t(out.size.area()) * ColourModes::kMost);
  for (std::size_t k = 0; k < pictures.size(); ++k) out.of.emplace_back(out.size, CV_8UC1);
  tbb::parallel_for(tbb::blocked_range<int>(0, out.size.height), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      for (int x = 0; x < out.size.width; ++x) {
        std::array<Cluster, ColourModes::kMost> clusters{};
        std::size_t used = 0;
        for (const auto& picture : pictures) {
          const auto* p = picture.ptr<std::uint8_t>(y) + 3 * x;
          Cluster* home = nullptr;
          for (std::size_t c = 0; c < used && home == nullptr; ++c) {
            if (distance(clusters[c], p) <= radius) home = &clusters[c];
          }
          if (home == nullptr) {
            // The rarest makes room.
            home = used < clusters.size() ? &clusters[used++]
                                          : &*std::min_element(clusters.begin(), clusters.end(),
                                                               [](auto& a, auto& b) { return a.count < b.count; });
            *home = Cluster{};
          }
          ++home->count;
          for (std::size_t c = 0; c < 3; ++c) {
            home->sum[c] += p[c];
            home->mean[c] = (home->sum[c] + home->count / 2) / home->count;
          }
        }
        commonest_first(clusters, used);
        for (std::size_t c = 0; c < used; ++c) clusters[c].count = 0;
        // Means move while they are learned: asked again at the end, each colour belongs to the nearest.
        for (std::size_t k = 0; k < pictures.size(); ++k) {
          const auto* p = pictures[k].ptr<std::uint8_t>(y) + 3 * x;
          std::size_t nearest = 0;
          int least = 256;
          for (std::size_t c = 0; c < used; ++c) {
            const int d = distance(clusters[c], p);
            if (d < least) {
              least = d;
              nearest = c;
            }
          }
          if (least <= radius) ++clusters[nearest].count;
          out.of[k].at<std::uint8_t>(y, x) = least <= radius ? static_cast<std::uint8_t>(nearest) : ColourModes::kNone;
        }
        auto* modes =
            out.modes.data() + (std::size_t(y) * std::size_t(out.size.width) + std::size_t(x)) * ColourModes::kMost;
        for (std::size_t c = 0; c < used; ++c) {
          for (int channel = 0; channel < 3; ++channel) {
            modes[c].colour[channel] = static_cast<std::uint8_t>(clusters[c].mean[std::size_t(channel)]);
          }
          modes[c].count = clusters[c].count;
        }
      }
    }
  });
  return out;
}

}  // namespace choreo::vision

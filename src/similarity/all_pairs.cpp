// SPDX-License-Identifier: Apache-2.0
#include "similarity/all_pairs.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace choreo::similarity {
namespace {

// A tile is one of these wide and at most so many high: what a comparer prepares for a tile's columns serves all its
// rows. Its two results are 256 KiB.
constexpr std::size_t kTile = 64;
constexpr std::size_t kTallest = 8;

void copy_transposed(MatrixView<const float> tile, MatrixView<float> matrix, Range rows, Range cols) {
  for (std::size_t j = 0; j < cols.size(); ++j) {
    auto* out = &matrix(cols.begin + j, rows.begin);
    for (std::size_t i = 0; i < rows.size(); ++i) out[i] = tile(i, j);
  }
}

}  // namespace

bool all_pairs(const Comparer& states, MatrixView<float> z, MatrixView<float> zstar, std::stop_token stop,
               const std::function<void(double)>& progress) {
  const std::size_t n = states.size();
  assert(z.rows() == n && z.cols() == n && zstar.rows() == n && zstar.cols() == n);
  // The upper triangle in columns of tiles, each cut into tiles of equal height but for the last, which ends at the
  // diagonal.
  struct Tile {
    Range rows, cols;
  };
  std::vector<Tile> tiles;
  for (std::size_t begin = 0; begin < n; begin += kTile) {
    const Range cols{begin, std::min(n, begin + kTile)};
    for (std::size_t row = 0; row < cols.end; row += kTallest * kTile) {
      tiles.push_back({{row, std::min(cols.end, row + kTallest * kTile)}, cols});
    }
  }
  const auto count = tiles.size();
  std::atomic<std::size_t> done{0};
  const auto work = [&](std::size_t k) {
    const auto& [rows, cols] = tiles[k];
    const MatrixView<float> z_tile(&z(rows.begin, cols.begin), rows.size(), cols.size(), z.stride());
    const MatrixView<float> zstar_tile(&zstar(rows.begin, cols.begin), rows.size(), cols.size(), zstar.stride());
    states.compare(rows, cols, z_tile, zstar_tile);
    // What lies below the diagonal's tile is not computed; what the tile itself has of it is right already.
    const Range above{rows.begin, std::min(rows.end, cols.begin)};
    if (above.begin < above.end) {
      copy_transposed(z_tile, z, above, cols);
      copy_transposed(zstar_tile, zstar, above, cols);
    }
    const auto so_far = done.fetch_add(1, std::memory_order_relaxed) + 1;
    if (progress) progress(double(so_far) / double(count));
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t k = range.begin(); k < range.end() && !stop.stop_requested(); ++k) work(k);
  });
  return done.load() == count;
}

}  // namespace choreo::similarity

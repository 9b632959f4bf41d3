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

constexpr std::size_t kTile = 64;  // Rows and columns; a tile's two results are 32 KiB.

Range tile_range(std::size_t tile, std::size_t n) { return {tile * kTile, std::min(n, (tile + 1) * kTile)}; }

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
  const std::size_t tiles = (n + kTile - 1) / kTile;
  const std::size_t count = tiles * (tiles + 1) / 2;
  std::atomic<std::size_t> done{0};
  // Tiles of the upper triangle, row by row: k is the tile's place in that order.
  const auto work = [&](std::size_t k) {
    std::size_t row = 0;
    while (k >= tiles - row) k -= tiles - row++;
    const auto rows = tile_range(row, n);
    const auto cols = tile_range(row + k, n);
    const MatrixView<float> z_tile(&z(rows.begin, cols.begin), rows.size(), cols.size(), z.stride());
    const MatrixView<float> zstar_tile(&zstar(rows.begin, cols.begin), rows.size(), cols.size(), zstar.stride());
    states.compare(rows, cols, z_tile, zstar_tile);
    if (k > 0) {
      copy_transposed(z_tile, z, rows, cols);
      copy_transposed(zstar_tile, zstar, rows, cols);
    }
    const auto so_far = done.fetch_add(1, std::memory_order_relaxed) + 1;
    if (progress && (so_far == count || so_far % 64 == 0)) progress(double(so_far) / double(count));
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t k = range.begin(); k < range.end() && !stop.stop_requested(); ++k) work(k);
  });
  return done.load() == count;
}

}  // namespace choreo::similarity

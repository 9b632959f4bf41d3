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

// A tile is this wide and at most so many high: what a comparer prepares for a tile's columns serves all its rows. Its
// two results are 256 KiB.
constexpr std::size_t kTileCols = 64;
constexpr std::size_t kTileRows = 512;
// A band has as many tiles side by side as keep a few cores busy; of 20,000 states it takes 41 MB.
constexpr std::size_t kBandTiles = 4;

// Compares states `earlier` with `later` and writes the result turned over, a row for each of the later ones.
void compare_turned(const Comparer& states, Range earlier, Range later, std::size_t first_row, MatrixView<float> z,
                    MatrixView<float> zstar) {
  const std::size_t size = earlier.size() * later.size();
  std::vector<float> tile(2 * size);
  const MatrixView<float> z_tile(tile.data(), earlier.size(), later.size());
  const MatrixView<float> zstar_tile(tile.data() + size, earlier.size(), later.size());
  states.compare(earlier, later, z_tile, zstar_tile);
  for (std::size_t j = 0; j < later.size(); ++j) {
    auto* z_out = &z(later.begin + j - first_row, earlier.begin);
    auto* zstar_out = &zstar(later.begin + j - first_row, earlier.begin);
    for (std::size_t i = 0; i < earlier.size(); ++i) {
      z_out[i] = z_tile(i, j);
      zstar_out[i] = zstar_tile(i, j);
    }
  }
}

}  // namespace

bool pairs_by_bands(const Comparer& states, const BandSink& sink, std::stop_token stop,
                    const std::function<void(double)>& progress) {
  const std::size_t n = states.size();
  std::vector<float> z;
  std::vector<float> zstar;
  std::atomic<std::size_t> done{0};  // Pairs.
  struct Tile {
    Range earlier, later;
  };
  std::vector<Tile> tiles;
  for (std::size_t begin = 0; begin < n; begin += kBandTiles * kTileCols) {
    const Range rows{begin, std::min(n, begin + kBandTiles * kTileCols)};
    z.resize(rows.size() * rows.end);
    zstar.resize(rows.size() * rows.end);
    const MatrixView<float> z_band(z.data(), rows.size(), rows.end);
    const MatrixView<float> zstar_band(zstar.data(), rows.size(), rows.end);
    tiles.clear();
    for (std::size_t col = rows.begin; col < rows.end; col += kTileCols) {
      const Range later{col, std::min(rows.end, col + kTileCols)};
      for (std::size_t row = 0; row < later.end; row += kTileRows) {
        tiles.push_back({{row, std::min(later.end, row + kTileRows)}, later});
      }
    }
    const auto before = done.load();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, tiles.size(), 1), [&](const auto& range) {
      for (std::size_t k = range.begin(); k < range.end() && !stop.stop_requested(); ++k) {
        compare_turned(states, tiles[k].earlier, tiles[k].later, rows.begin, z_band, zstar_band);
        done.fetch_add(tiles[k].earlier.size() * tiles[k].later.size(), std::memory_order_relaxed);
      }
    });
    std::size_t wanted = 0;
    for (const auto& tile : tiles) wanted += tile.earlier.size() * tile.later.size();
    if (done.load() - before != wanted) return false;
    // Right of a row's own tile the band's rows meet later rows of the same band: those know.
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto own_tile_end = std::min(rows.size(), (i / kTileCols + 1) * kTileCols);
      for (std::size_t j = own_tile_end; j < rows.size(); ++j) {
        z_band(i, rows.begin + j) = z_band(j, rows.begin + i);
        zstar_band(i, rows.begin + j) = zstar_band(j, rows.begin + i);
      }
    }
    sink(rows, z_band, zstar_band);
    if (progress) progress(double(rows.end) / double(n) * double(rows.end) / double(n));
  }
  return true;
}

bool all_pairs(const Comparer& states, MatrixView<float> z, MatrixView<float> zstar, std::stop_token stop,
               const std::function<void(double)>& progress) {
  assert(z.rows() == states.size() && z.cols() == states.size());
  assert(zstar.rows() == states.size() && zstar.cols() == states.size());
  const auto copy = [](Range rows, MatrixView<const float> band, MatrixView<float> matrix) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      std::copy_n(&band(i, 0), rows.end, &matrix(rows.begin + i, 0));
      for (std::size_t j = 0; j < rows.begin; ++j) matrix(j, rows.begin + i) = band(i, j);
    }
  };
  return pairs_by_bands(
      states,
      [&](Range rows, MatrixView<const float> z_band, MatrixView<const float> zstar_band) {
        copy(rows, z_band, z);
        copy(rows, zstar_band, zstar);
      },
      std::move(stop), progress);
}

}  // namespace choreo::similarity

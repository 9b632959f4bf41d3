// SPDX-License-Identifier: Apache-2.0
#include "similarity/mask_runs.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

namespace choreo::similarity {
namespace {

constexpr std::size_t kRunBlock = 2 * kRunLanes;    // States among which the columns are sorted.
constexpr std::size_t kSumsBytes = 256 * 1024;      // About half of a second cache.
constexpr std::size_t kMostLineBytes = 0xFFFF / 8;  // A line's count must fit 16 bits.
constexpr std::size_t kWays = 4;                    // Straight, and mirrored with sigma = -1, 0, 1.
using Counts = std::array<std::array<std::uint32_t, kRunLanes>, kWays>;

}  // namespace

bool MaskRuns::possible(const MaskTable& table) { return (std::size_t(table.canvas.width) + 7) / 8 <= kMostLineBytes; }

MaskRuns::MaskRuns(MaskStates states, std::shared_ptr<const MaskTable> table, AndCountKernel kernel)
    : table_(std::move(table)), kernel_(std::move(kernel)), columns_(make_bit_buffer(0)) {
  const auto& canvas = table_->canvas;
  const auto lines = std::size_t(canvas.height);
  line_bytes_ = (std::size_t(canvas.width) + 7) / 8;
  if (lines > 0) {
    const auto line_sums = sums_per_line(line_bytes_) * sizeof(std::uint16_t);
    chunk_lines_ = std::clamp<std::size_t>(kSumsBytes / line_sums, 1, std::min(lines, kMostLineBytes / line_bytes_));
    chunks_ = (lines + chunk_lines_ - 1) / chunk_lines_;
  }
  for (const auto& state : states) add_runs(state.get());
  for (auto* runs : {&straight_, &mirrored_}) {
    runs->begins.push_back(runs->places.size());
    runs->places.shrink_to_fit();
  }

  const auto none = static_cast<std::uint32_t>(states.size());
  const auto blocks = (states.size() + kRunBlock - 1) / kRunBlock;
  lanes_.assign(blocks * kRunBlock, none);
  std::iota(lanes_.begin(), lanes_.begin() + std::ptrdiff_t(states.size()), 0U);
  for (std::size_t block = 0; block < blocks; ++block) {
    const auto begin = lanes_.begin() + std::ptrdiff_t(block * kRunBlock);
    const auto end = begin + kRunBlock;
    // Gaps take no part: to the end with them.
    const auto bodies = std::stable_partition(begin, end, [&](auto i) { return i < none && table_->has_body(i); });
    std::stable_sort(begin, bodies, [&](auto a, auto b) {
      return table_->remainders[a] * table_->areas[b] < table_->remainders[b] * table_->areas[a];
    });
    std::fill(bodies, end, none);
  }
  const auto group_bytes = lines * line_bytes_ * kRunLanes;
  columns_ = make_bit_buffer(padded(lanes_.size() / kRunLanes * group_bytes));
  for (std::size_t k = 0; k < lanes_.size(); ++k) {
    if (lanes_[k] == none) continue;
    const auto& state = *states[lanes_[k]];
    const auto box = state.box();
    for (int y = box.y; y < box.y + box.height; ++y) {
      auto* line = columns_.get() + k / kRunLanes * group_bytes + std::size_t(y - canvas.y) * line_bytes_ * kRunLanes +
                   k % kRunLanes;
      for (std::size_t byte = 0; byte < line_bytes_; ++byte) {
        line[byte * kRunLanes] = static_cast<std::uint8_t>(pixels_from(state, state.row(y), canvas.x + int(byte) * 8));
      }
    }
  }
}

void MaskRuns::add_runs(const body::MaskState* state) {
  const auto& canvas = table_->canvas;
  for (std::size_t chunk = 0; chunk < chunks_; ++chunk) {
    straight_.begins.push_back(straight_.places.size());
    mirrored_.begins.push_back(mirrored_.places.size());
    if (state == nullptr) continue;
    const auto box = state->box();
    const int first = canvas.y + int(chunk * chunk_lines_);
    const int last = std::min(first + int(chunk_lines_), box.y + box.height);
    for (int y = std::max(first, box.y); y < last; ++y) {
      const auto line = std::size_t(y - first) * sums_per_line(line_bytes_);
      // A line's sums begin one place left of the canvas and end one right of it: whatever the shift, a place beyond
      // the canvas sums up to the same as its side.
      const auto place = [&](int x) {
        const int on_canvas = std::clamp(x - canvas.x, 0, canvas.width);
        return static_cast<std::uint32_t>(line + std::size_t(1 + on_canvas) * kRunLanes);
      };
      const auto add = [&](Runs& runs, int begin, int end) {
        if (place(begin) == place(end)) return;
        runs.places.push_back(place(begin));
        runs.places.push_back(place(end));
      };
      for_each_run(*state, state->row(y), [&](int begin, int end) {
        add(straight_, begin, end);
        add(mirrored_, 1 - end, 1 - begin);
      });
    }
  }
}

std::size_t MaskRuns::bytes() const {
  return lanes_.size() * std::size_t(table_->canvas.height) * line_bytes_ +
         (straight_.places.size() + mirrored_.places.size()) * sizeof(std::uint32_t) +
         (straight_.begins.size() + mirrored_.begins.size()) * sizeof(std::size_t);
}

// One group of columns against rows.
class MaskRuns::Group {
 public:
  Group(const MaskRuns& masks, Range rows)
      : masks_(masks),
        rows_(rows),
        sums_(make_bit_buffer(padded(masks.chunk_lines_ * sums_per_line(masks.line_bytes_) * sizeof(std::uint16_t)))),
        counts_(rows.size()),
        shifts_(rows.size()),
        ways_(rows.size()) {}

  void compare(std::size_t group, Range cols, MatrixView<float> z, MatrixView<float> zstar) {
    const auto& table = *masks_.table_;
    const auto* lanes = masks_.lanes_.data() + group * kRunLanes;
    const auto wanted = [&](std::size_t lane) { return lanes[lane] >= cols.begin && lanes[lane] < cols.end; };
    bool any = false;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const auto row = rows_.begin + r;
      counts_[r] = {};
      ways_[r] = {};
      if (!table.has_body(row)) continue;
      for (std::size_t lane = 0; lane < kRunLanes; ++lane) {
        if (!wanted(lane)) continue;
        const auto way = static_cast<std::uint8_t>(2 + table.shift(row, lanes[lane]));
        shifts_[r][lane] = way;
        ways_[r][0] = ways_[r][way] = any = true;
      }
    }
    if (any) count(group);
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (!ways_[r][0]) continue;
      for (std::size_t lane = 0; lane < kRunLanes; ++lane) {
        if (!wanted(lane)) continue;
        const auto row = rows_.begin + r;
        const std::size_t col = lanes[lane];
        z(r, col - cols.begin) = table.similarity(counts_[r][0][lane], row, col);
        zstar(r, col - cols.begin) = table.similarity(counts_[r][shifts_[r][lane]][lane], row, col);
      }
    }
  }

 private:
  void count(std::size_t group) {
    const auto lines = std::size_t(masks_.table_->canvas.height);
    const auto line_bytes = masks_.line_bytes_ * kRunLanes;
    auto* sums = reinterpret_cast<std::uint16_t*>(sums_.get());
    for (std::size_t chunk = 0; chunk < masks_.chunks_; ++chunk) {
      const auto first = chunk * masks_.chunk_lines_;
      masks_.kernel_.sums(masks_.columns_.get() + (group * lines + first) * line_bytes, masks_.line_bytes_,
                          std::min(masks_.chunk_lines_, lines - first), sums);
      for (std::size_t r = 0; r < rows_.size(); ++r) {
        const auto k = (rows_.begin + r) * masks_.chunks_ + chunk;
        for (std::size_t way = 0; way < kWays; ++way) {
          if (!ways_[r][way]) continue;
          const auto& runs = way == 0 ? masks_.straight_ : masks_.mirrored_;
          // A pixel further right, and its sum is one place further.
          const auto shift = way == 0 ? 0 : (std::ptrdiff_t(way) - 2) * std::ptrdiff_t(kRunLanes);
          masks_.kernel_.runs(sums + shift, runs.places.data() + runs.begins[k], runs.begins[k + 1] - runs.begins[k],
                              counts_[r][way].data());
        }
      }
    }
  }

  const MaskRuns& masks_;
  Range rows_;
  BitBuffer sums_;
  std::vector<Counts> counts_;                               // By row.
  std::vector<std::array<std::uint8_t, kRunLanes>> shifts_;  // By row: which way a lane's mirror image is counted.
  std::vector<std::array<bool, kWays>> ways_;                // By row: which counts are needed.
};

void MaskRuns::compare(Range rows, Range cols, MatrixView<float> z, MatrixView<float> zstar) const {
  for (std::size_t r = 0; r < rows.size(); ++r) {
    std::fill(z.row(r).begin(), z.row(r).end(), std::numeric_limits<float>::quiet_NaN());
    std::fill(zstar.row(r).begin(), zstar.row(r).end(), std::numeric_limits<float>::quiet_NaN());
  }
  if (rows.size() == 0 || cols.size() == 0 || chunks_ == 0) return;
  Group one(*this, rows);
  const auto first = cols.begin / kRunBlock * kRunBlock / kRunLanes;
  const auto end = (cols.end + kRunBlock - 1) / kRunBlock * kRunBlock / kRunLanes;
  for (auto group = first; group < end; ++group) one.compare(group, cols, z, zstar);
}

}  // namespace choreo::similarity

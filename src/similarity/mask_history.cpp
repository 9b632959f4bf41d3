// SPDX-License-Identifier: Apache-2.0
#include "similarity/mask_history.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"
#include "similarity/mask_table.hpp"

namespace choreo::similarity {
namespace {

constexpr int kCell = 32;  // Pixels; a cell of a line is one 32-bit word.
constexpr std::size_t kCellBytes = 4;
constexpr std::size_t kRowsAhead = 6;
constexpr std::size_t kShortRow = 4096;  // Bytes.
constexpr int kShifts = 3;               // The mirror's sigma: -1, 0, 1.

constexpr int floor_div(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

// 32 pixels of a mask's line from x = `first` (relative to the centroid) on, bit k the pixel at first + k.
std::uint32_t cell_at(const body::MaskState& state, const std::uint64_t* line, int first) {
  return static_cast<std::uint32_t>(pixels_from(state, line, first));
}

constexpr std::uint32_t reversed(std::uint32_t bits) {
  bits = (bits >> 1 & 0x55555555U) | (bits & 0x55555555U) << 1;
  bits = (bits >> 2 & 0x33333333U) | (bits & 0x33333333U) << 2;
  bits = (bits >> 4 & 0x0F0F0F0FU) | (bits & 0x0F0F0F0FU) << 4;
  bits = (bits >> 8 & 0x00FF00FFU) | (bits & 0x00FF00FFU) << 8;
  return bits >> 16 | bits << 16;
}

}  // namespace

// The live state in one layout: straight, and mirrored with each shift, made when first asked for. Before and after
// every string lie kBitAlignment zero bytes, so that a row may be read from and to aligned addresses.
class MaskHistory::Query {
 public:
  Query(const body::MaskState& state, Layout layout, std::uint8_t* bits, std::size_t slot_bytes)
      : state_(state), layout_(layout), bits_(bits), stride_(slot_bytes + 2 * kBitAlignment) {
    fill(string(0), [&](const std::uint64_t* line, int cell) { return cell_at(state_, line, kCell * cell); });
  }

  const std::uint8_t* straight() const { return string(0); }

  // A(sigma - u_x, u_y) at u: bit k of a cell is the pixel at sigma - (first + k).
  const std::uint8_t* mirrored(int sigma) {
    auto* out = string(2 + sigma);
    if (!std::exchange(made_[std::size_t(1 + sigma)], true)) {
      fill(out, [&](const std::uint64_t* line, int cell) {
        return reversed(cell_at(state_, line, sigma - kCell * cell - (kCell - 1)));
      });
    }
    return out;
  }

 private:
  std::uint8_t* string(int k) const { return bits_ + std::size_t(k) * stride_ + kBitAlignment; }

  template <typename CellOf>
  void fill(std::uint8_t* out, CellOf cell_of) const {
    const auto box = state_.box();
    for (int y = box.y; y < box.y + box.height; ++y) {
      const auto* line = state_.row(y);
      for (int cell = layout_.first; cell < layout_.first + layout_.cells; ++cell, out += kCellBytes) {
        const auto bits = cell_of(line, cell);
        std::memcpy(out, &bits, kCellBytes);
      }
    }
    std::memset(out, 0, kBitAlignment);
  }

  const body::MaskState& state_;
  Layout layout_;
  std::uint8_t* bits_;
  std::size_t stride_;
  std::array<bool, kShifts> made_{};
};

std::size_t MaskHistory::Layout::line_bytes() const { return std::size_t(cells) * kCellBytes; }

MaskHistory::MaskHistory(cv::Size picture, std::size_t capacity, AndCountKernel kernel)
    : kernel_(std::move(kernel)),
      picture_(picture),
      // A body of the picture's width begins anywhere in its first cell.
      most_cells_((picture.width + kCell - 2) / kCell + 1),
      slot_bytes_(padded(std::size_t(most_cells_) * kCellBytes * std::size_t(picture.height))),
      rows_(capacity),
      bits_(make_bit_buffer(capacity * slot_bytes_)),
      query_bits_(make_bit_buffer((1 + kShifts) * (slot_bytes_ + 2 * kBitAlignment))),
      order_(capacity),
      bucket_of_(capacity) {
  assert(picture.width >= 1 && picture.height >= 1 && capacity >= 1);
  assert(capacity <= std::numeric_limits<std::uint32_t>::max());
  // The centroid lies within a body's box, so the box begins at most a picture's width to its left and never to its
  // right.
  const auto first_cells = std::size_t(-floor_div(1 - picture.width, kCell)) + 1;
  bucket_end_.resize(first_cells * std::size_t(most_cells_) * kShifts + 1);
}

std::uint32_t MaskHistory::number_of(Layout layout) const {
  return static_cast<std::uint32_t>(-layout.first * most_cells_ + layout.cells - 1);
}

MaskHistory::Layout MaskHistory::layout_of(std::uint32_t number) const {
  const int n = static_cast<int>(number);
  return {-(n / most_cells_), n % most_cells_ + 1};
}

std::size_t MaskHistory::bytes_per_row() const { return slot_bytes_ + sizeof(Row) + 2 * sizeof(std::uint32_t); }

std::size_t MaskHistory::memory_bytes() const {
  return sizeof(*this) + capacity() * bytes_per_row() + (1 + kShifts) * (slot_bytes_ + 2 * kBitAlignment) +
         bucket_end_.size() * sizeof(std::uint32_t);
}

void MaskHistory::drop_oldest(std::size_t count) {
  count = std::min(count, size_);
  first_ = slot_of(count);
  size_ -= count;
}

void MaskHistory::store(const body::MaskState& state, std::size_t slot) {
  const auto box = state.box();
  const int first = floor_div(box.x, kCell);
  const Layout layout{first, floor_div(box.x + box.width - 1, kCell) - first + 1};
  rows_[slot] = {state.area(), state.remainder_x(), box.y, box.height, number_of(layout)};
  auto* out = bits_of(slot);
  for (int y = box.y; y < box.y + box.height; ++y) {
    const auto* line = state.row(y);
    for (int cell = layout.first; cell < layout.first + layout.cells; ++cell, out += kCellBytes) {
      const auto bits = cell_at(state, line, kCell * cell);
      std::memcpy(out, &bits, kCellBytes);
    }
  }
  // Up to the alignment the string is read, and what was there before is another body's.
  const auto used = std::size_t(out - bits_of(slot));
  std::memset(out, 0, padded(used) - used);
}

// The lines that a row and the live state both occupy, widened to whole alignments: what is read besides meets zeros.
MaskHistory::Part MaskHistory::common_part(const Row& row, cv::Rect box) const {
  const int begin = std::max(row.y, box.y) - row.y;
  const int end = std::min(row.y + row.lines, box.y + box.height) - row.y;
  if (begin >= end) return {};
  const auto line_bytes = layout_of(row.layout).line_bytes();
  return {std::size_t(begin) * line_bytes / kBitAlignment * kBitAlignment, padded(std::size_t(end) * line_bytes)};
}

// Counting sort; within a layout and shift the rows stay in the order of time, which is that of their addresses.
std::size_t MaskHistory::sort_by_layout_and_shift(const Row& query) {
  std::fill(bucket_end_.begin(), bucket_end_.end(), 0);
  for (std::size_t age = 0; age < size_; ++age) {
    const auto& row = rows_[slot_of(age)];
    if (row.area == 0) continue;
    const int sigma = body::mirror_shift(query.remainder, query.area, row.remainder, row.area);
    bucket_of_[age] = row.layout * kShifts + static_cast<std::uint32_t>(1 + sigma);
    ++bucket_end_[bucket_of_[age] + 1];
  }
  for (std::size_t k = 1; k < bucket_end_.size(); ++k) bucket_end_[k] += bucket_end_[k - 1];
  const auto count = bucket_end_.back();
  for (std::size_t age = 0; age < size_; ++age) {
    if (rows_[slot_of(age)].area > 0) order_[bucket_end_[bucket_of_[age]]++] = static_cast<std::uint32_t>(age);
  }
  return count;
}

// The slot of the newest state, with the state in it.
std::size_t MaskHistory::take_slot(const body::MaskState* state) {
  if (state != nullptr && (state->box().width > picture_.width || state->box().height > picture_.height)) {
    throw failure(fmt::format("a body of {} x {} pixels does not come from a picture of {} x {}", state->box().width,
                              state->box().height, picture_.width, picture_.height));
  }
  if (size_ == capacity()) drop_oldest(1);
  const auto slot = slot_of(size_);
  ++size_;
  if (state != nullptr) {
    store(*state, slot);
  } else {
    rows_[slot] = {};
  }
  return slot;
}

void MaskHistory::remember(const body::MaskState* state) { take_slot(state); }

void MaskHistory::append(const body::MaskState* state, std::span<float> z, std::span<float> zstar) {
  const auto slot = take_slot(state);
  bytes_read_ = 0;
  assert(z.size() >= size_ && zstar.size() >= size_);

  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  if (state == nullptr) {
    std::fill_n(z.begin(), size_, kNaN);
    std::fill_n(zstar.begin(), size_, kNaN);
    return;
  }
  for (std::size_t age = 0; age < size_; ++age) {
    if (rows_[slot_of(age)].area == 0) z[age] = zstar[age] = kNaN;
  }

  const auto& own = rows_[slot];
  const auto box = state->box();
  const auto visits = sort_by_layout_and_shift(own);
  std::size_t k = 0;
  while (k < visits) {
    const auto layout = layout_of(rows_[slot_of(order_[k])].layout);
    Query query(*state, layout, query_bits_.get(), slot_bytes_);
    const auto line_bytes = std::ptrdiff_t(layout.line_bytes());
    for (const auto number = number_of(layout); k < visits; ++k) {
      const auto age = order_[k];
      const auto& row = rows_[slot_of(age)];
      if (row.layout != number) break;
      const auto part = common_part(row, box);
      const auto* bits = bits_of(slot_of(age)) + part.begin;
      const auto* next = bits;
      if (k + 1 < visits) {
        const auto next_slot = slot_of(order_[k + 1]);
        next = bits_of(next_slot) + common_part(rows_[next_slot], box).begin;
      }
      // Short rows end before what is asked for ahead of them has come: then it is asked for several rows before.
      if (k + kRowsAhead < visits && part.end - part.begin <= kShortRow) {
        const auto later = slot_of(order_[k + kRowsAhead]);
        const auto later_part = common_part(rows_[later], box);
        for (auto line = later_part.begin; line < later_part.end; line += kBitAlignment) {
          __builtin_prefetch(bits_of(later) + line);
        }
      }
      // Where the row's first byte lies in the strings of the live state; at most an alignment before their begin.
      const auto offset = std::ptrdiff_t(part.begin) + (row.y - box.y) * line_bytes;
      const int sigma = static_cast<int>(bucket_of_[age] % kShifts) - 1;
      std::array<std::uint32_t, 2> common{};
      if (part.end > part.begin) {
        kernel_.twice(bits, query.straight() + offset, query.mirrored(sigma) + offset, part.end - part.begin, next,
                      common.data());
      }
      bytes_read_ += part.end - part.begin;
      z[age] = static_cast<float>(body::similarity_of_counts(common[0], own.area, row.area));
      zstar[age] = static_cast<float>(body::similarity_of_counts(common[1], own.area, row.area));
    }
  }
}

std::unique_ptr<const body::MaskState> MaskHistory::state(std::size_t age) const {
  assert(age < size_);
  const auto slot = slot_of(age);
  const auto& row = rows_[slot];
  if (row.area == 0) return nullptr;
  const auto layout = layout_of(row.layout);
  cv::Mat mask = cv::Mat::zeros(row.lines, kCell * layout.cells, CV_8UC1);
  const auto* bits = bits_of(slot);
  for (int y = 0; y < row.lines; ++y) {
    auto* out = mask.ptr<std::uint8_t>(y);
    for (int cell = 0; cell < layout.cells; ++cell, bits += kCellBytes) {
      std::uint32_t word = 0;
      std::memcpy(&word, bits, kCellBytes);
      for (int k = 0; k < kCell; ++k) out[kCell * cell + k] = (word >> k & 1U) != 0 ? 255 : 0;
    }
  }
  return std::make_unique<const body::MaskState>(mask);
}

}  // namespace choreo::similarity

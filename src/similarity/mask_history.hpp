// SPDX-License-Identifier: Apache-2.0
// The online history of silhouettes: one row of Z and Z* a frame, in memory that does not grow.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <opencv2/core/types.hpp>

#include "body/mask_state.hpp"
#include "similarity/and_count.hpp"
#include "similarity/bit_buffer.hpp"
#include "similarity/history.hpp"

namespace choreo::similarity {

/// A ring of silhouettes as bit strings, each cropped to what its own body occupies.
///
/// A row has room for the largest body that its picture can hold, wherever the centroid lies in it, so no pixel is ever
/// lost. What is stored of a body, and read again for every later frame, is its box widened to whole cells of 32
/// pixels: line after line without a break. The live state is laid out likewise once for every layout (first cell,
/// cells a line) that occurs in the history, straight, mirrored, and mirrored with the shifts sigma that occur; the
/// rows are then visited layout by layout and, within one, sigma by sigma, so that a row is read once for both
/// similarities, against strings that stay in the first cache. Lines that only one of the two bodies occupies are not
/// read.
class MaskHistory final : public History {
 public:
  /// @param picture   size of the pictures that the masks come from, at least 1 x 1.
  /// @param capacity  states, at least 1.
  MaskHistory(cv::Size picture, std::size_t capacity, AndCountKernel kernel);

  [[nodiscard]] std::size_t capacity() const override { return rows_.size(); }
  [[nodiscard]] std::size_t size() const override { return size_; }
  [[nodiscard]] std::size_t bytes_per_row() const override;
  [[nodiscard]] std::size_t memory_bytes() const override;
  void drop_oldest(std::size_t count) override;

  /// Appends a state, dropping the oldest where the ring is full, and compares it with all that remain.
  ///
  /// z[i] = Z(state, i-th oldest) and zstar[i] likewise, i = 0 to size() - 1, the last the state with itself; NaN where
  /// either is a gap.
  /// @param state  nullptr: a gap. From a picture of the size given; Error (run time) where it is larger.
  /// @param z, zstar  at least min(size() + 1, capacity()) floats; what lies beyond stays as it is.
  /// @cost O(bytes read), see `bytes_read`; no allocation.
  void append(const body::MaskState* state, std::span<float> z, std::span<float> zstar);

  /// The `age`-th oldest state, as it was but for where it stood in its picture; nullptr for a gap.
  [[nodiscard]] std::unique_ptr<const body::MaskState> state(std::size_t age) const;

  /// Appends a state, or a gap, without comparing it: for a history that begins with what is known already.
  /// As `append` otherwise.
  void remember(const body::MaskState* state);

  /// How many bytes of the history the last `append` read, each once.
  [[nodiscard]] std::size_t bytes_read() const { return bytes_read_; }

 private:
  struct Row {
    std::int64_t area = 0;  // 0: a gap.
    std::int64_t remainder = 0;
    int y = 0;  // First line, relative to the centroid, and how many.
    int lines = 0;
    std::uint32_t layout = 0;
  };
  /// Which cells of every line a string has.
  struct Layout {
    int first = 0;  // The cell that begins at x = 32 * first.
    int cells = 0;
    [[nodiscard]] std::size_t line_bytes() const;
  };
  /// Part of a row's string: from `begin` up to `end`, both multiples of kBitAlignment.
  struct Part {
    std::size_t begin = 0;
    std::size_t end = 0;
  };
  class Query;

  [[nodiscard]] std::uint32_t number_of(Layout layout) const;
  [[nodiscard]] Layout layout_of(std::uint32_t number) const;
  [[nodiscard]] std::size_t slot_of(std::size_t age) const { return (first_ + age) % rows_.size(); }
  [[nodiscard]] std::uint8_t* bits_of(std::size_t slot) const { return bits_.get() + slot * slot_bytes_; }
  [[nodiscard]] Part common_part(const Row& row, cv::Rect box) const;
  std::size_t take_slot(const body::MaskState* state);
  void store(const body::MaskState& state, std::size_t slot);
  std::size_t sort_by_layout_and_shift(const Row& query);

  AndCountKernel kernel_;
  cv::Size picture_;
  int most_cells_ = 0;          // Cells a line that the largest body needs.
  std::size_t slot_bytes_ = 0;  // Of one row's string, a multiple of kBitAlignment.
  std::size_t first_ = 0;       // Slot of the oldest state.
  std::size_t size_ = 0;
  std::size_t bytes_read_ = 0;
  std::vector<Row> rows_;  // By slot.
  BitBuffer bits_;
  BitBuffer query_bits_;  // Straight, and mirrored with three shifts.
  // Of the row under way: the ages of the states that are no gap, in the order of their visit; where each layout and
  // shift begins among them; and to which of those an age belongs.
  std::vector<std::uint32_t> order_;
  std::vector<std::uint32_t> bucket_end_;
  std::vector<std::uint32_t> bucket_of_;
};

}  // namespace choreo::similarity

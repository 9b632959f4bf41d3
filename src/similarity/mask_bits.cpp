// SPDX-License-Identifier: Apache-2.0
#include "similarity/mask_bits.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <limits>
#include <utility>

namespace choreo::similarity {
namespace {

// So many bytes of a block's strings are worked through at a time: those of the block (32 columns, 32 rows, of every
// row two) stay in the second cache, those of four rows in the first.
constexpr std::size_t kBitBlock = 32;
constexpr std::size_t kRowsAtATime = 4;
constexpr std::size_t kChunk = 2048;

void set_bit(std::uint8_t* bits, std::size_t k) { bits[k / 8] |= static_cast<std::uint8_t>(1U << (k % 8)); }

// out = in moved by one pixel: to the right (towards higher bits) for +1, to the left for -1. Little-endian words.
void shift_by_one(const std::uint8_t* in, std::uint8_t* out, std::size_t bytes, int direction) {
  const std::size_t words = bytes / 8;
  const auto load = [&](std::size_t i) {
    std::uint64_t word = 0;
    std::memcpy(&word, in + 8 * i, 8);
    return word;
  };
  for (std::size_t i = 0; i < words; ++i) {
    const auto here = load(i);
    const auto carry = direction > 0 ? (i > 0 ? load(i - 1) >> 63 : 0) : (i + 1 < words ? load(i + 1) << 63 : 0);
    const auto moved = (direction > 0 ? here << 1 : here >> 1) | carry;
    std::memcpy(out + 8 * i, &moved, 8);
  }
}

}  // namespace

MaskBits::MaskBits(MaskStates states, std::shared_ptr<const MaskTable> table, AndCountKernel kernel)
    : table_(std::move(table)), kernel_(std::move(kernel)), bits_(make_bit_buffer(0)) {
  const auto& canvas = table_->canvas;
  bytes_ = padded((std::size_t(canvas.width) * std::size_t(canvas.height) + 7) / 8);
  bits_ = make_bit_buffer(2 * bytes_ * states.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (!states[i]) continue;
    const auto& state = *states[i];
    auto* straight = bits_.get() + 2 * i * bytes_;
    auto* mirrored = straight + bytes_;
    const auto box = state.box();
    for (int y = box.y; y < box.y + box.height; ++y) {
      const auto line = std::size_t(y - canvas.y) * std::size_t(canvas.width);
      for_each_run(state, state.row(y), [&](int begin, int end) {
        for (int x = begin; x < end; ++x) {
          set_bit(straight, line + std::size_t(x - canvas.x));
          // What the mirror image has beyond the margins no mask can meet, shifted or not. What it has in them may be
          // shifted to meet one; shifted the other way it lands in the margin of the next line, where no mask has a
          // bit.
          const int mirrored_x = -x - canvas.x;
          if (mirrored_x >= 0 && mirrored_x < canvas.width) set_bit(mirrored, line + std::size_t(mirrored_x));
        }
      });
    }
  }
}

// A tile's row strings shifted by -1 and +1, made when first asked for.
class MaskBits::Shifted {
 public:
  Shifted(const MaskBits& masks, Range rows)
      : masks_(masks),
        rows_(rows),
        made_(2 * rows.size(), false),
        bits_(make_bit_buffer(2 * rows.size() * masks.bytes_)) {}

  const std::uint8_t* mirror(std::size_t i, int sigma) {
    if (sigma == 0) return masks_.mirror(i);
    const auto slot = 2 * (i - rows_.begin) + (sigma > 0 ? 1 : 0);
    auto* bits = bits_.get() + slot * masks_.bytes_;
    if (!made_[slot]) {
      shift_by_one(masks_.mirror(i), bits, masks_.bytes_, sigma);
      made_[slot] = true;
    }
    return bits;
  }

 private:
  const MaskBits& masks_;
  Range rows_;
  std::vector<bool> made_;
  BitBuffer bits_;
};

void MaskBits::compare(Range rows, Range cols, MatrixView<float> z, MatrixView<float> zstar) const {
  Shifted shifted(*this, rows);
  struct Pair {
    std::size_t row, col;
    const std::uint8_t *straight, *mirrored, *column;
    std::array<std::uint32_t, 2> common;
  };
  std::vector<Pair> pairs;
  pairs.reserve(kBitBlock * kBitBlock);
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

  for (std::size_t i0 = rows.begin; i0 < rows.end; i0 += kBitBlock) {
    for (std::size_t j0 = cols.begin; j0 < cols.end; j0 += kBitBlock) {
      pairs.clear();
      const Range block_rows{i0, std::min(i0 + kBitBlock, rows.end)};
      const Range block_cols{j0, std::min(j0 + kBitBlock, cols.end)};
      for (auto i1 = block_rows.begin; i1 < block_rows.end; i1 += kRowsAtATime) {
        for (auto j = block_cols.begin; j < block_cols.end; ++j) {
          for (auto i = i1; i < std::min(i1 + kRowsAtATime, block_rows.end); ++i) {
            if (table_->has_body(i) && table_->has_body(j)) {
              pairs.push_back({i, j, mask(i), shifted.mirror(i, table_->shift(i, j)), mask(j), {}});
            } else {
              z(i - rows.begin, j - cols.begin) = zstar(i - rows.begin, j - cols.begin) = kNaN;
            }
          }
        }
      }
      for (std::size_t begin = 0; begin < bytes_; begin += kChunk) {
        const auto length = std::min(kChunk, bytes_ - begin);
        for (auto& pair : pairs) {
          const auto* column = pair.column + begin;
          kernel_.twice(column, pair.straight + begin, pair.mirrored + begin, length, column, pair.common.data());
        }
      }
      for (const auto& [i, j, straight, mirrored, column, common] : pairs) {
        z(i - rows.begin, j - cols.begin) = table_->similarity(common[0], i, j);
        zstar(i - rows.begin, j - cols.begin) = table_->similarity(common[1], i, j);
      }
    }
  }
}

}  // namespace choreo::similarity

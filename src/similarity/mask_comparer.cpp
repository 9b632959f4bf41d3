// SPDX-License-Identifier: Apache-2.0
#include "similarity/mask_comparer.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <limits>
#include <utility>

namespace choreo::similarity {
namespace {

// Bytes of every string that a block works through at a time, so that the block's strings stay in the first cache.
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

MaskComparer::MaskComparer(std::span<const std::unique_ptr<const body::MaskState>> states, AndCountKernel kernel)
    : kernel_(std::move(kernel)), areas_(states.size(), 0), remainders_(states.size(), 0), bits_(make_bit_buffer(0)) {
  for (const auto& state : states) {
    if (state) canvas_ = canvas_.empty() ? state->box() : (canvas_ | state->box());
  }
  // The empty columns between which a string may be shifted.
  if (!canvas_.empty()) {
    canvas_.x -= 1;
    canvas_.width += 2;
  }
  const auto bits = std::size_t(canvas_.width) * std::size_t(canvas_.height);
  bytes_ = padded((bits + 7) / 8);
  bits_ = make_bit_buffer(2 * bytes_ * states.size());

  for (std::size_t i = 0; i < states.size(); ++i) {
    if (!states[i]) continue;
    const auto& state = *states[i];
    areas_[i] = state.area();
    remainders_[i] = state.remainder_x();
    auto* straight = bits_.get() + 2 * i * bytes_;
    auto* mirrored = straight + bytes_;
    const auto box = state.box();
    for (int y = box.y; y < box.y + box.height; ++y) {
      const auto line = std::size_t(y - canvas_.y) * std::size_t(canvas_.width);
      for (int x = box.x; x < box.x + box.width; ++x) {
        if (!state.at(x, y)) continue;
        set_bit(straight, line + std::size_t(x - canvas_.x));
        // What the mirror image has beyond the margins no mask can meet, shifted or not. What it has in them may be
        // shifted to meet one; shifted the other way it lands in the margin of the next line, where no mask has a bit.
        const int mirrored_x = -x - canvas_.x;
        if (mirrored_x >= 0 && mirrored_x < canvas_.width) set_bit(mirrored, line + std::size_t(mirrored_x));
      }
    }
  }
}

// A tile's row strings shifted by -1 and +1, made when first asked for.
class MaskComparer::Scratch {
 public:
  Scratch(const MaskComparer& comparer, Range rows)
      : comparer_(comparer),
        rows_(rows),
        made_(2 * rows.size(), false),
        bits_(make_bit_buffer(2 * rows.size() * comparer.bytes_)) {}

  const std::uint8_t* mirror(std::size_t i, int sigma) {
    if (sigma == 0) return comparer_.mirror(i);
    const auto slot = 2 * (i - rows_.begin) + (sigma > 0 ? 1 : 0);
    auto* bits = bits_.get() + slot * comparer_.bytes_;
    if (!made_[slot]) {
      shift_by_one(comparer_.mirror(i), bits, comparer_.bytes_, sigma);
      made_[slot] = true;
    }
    return bits;
  }

 private:
  const MaskComparer& comparer_;
  Range rows_;
  std::vector<bool> made_;
  BitBuffer bits_;
};

void MaskComparer::compare(Range rows, Range cols, MatrixView<float> z, MatrixView<float> zstar) const {
  assert(z.rows() == rows.size() && z.cols() == cols.size());
  assert(zstar.rows() == rows.size() && zstar.cols() == cols.size());
  Scratch scratch(*this, rows);
  const auto body_of = [&](std::size_t i) { return areas_[i] > 0; };

  for (std::size_t i0 = rows.begin; i0 < rows.end; i0 += kBlockRows) {
    for (std::size_t j0 = cols.begin; j0 < cols.end; j0 += kBlockCols) {
      std::array<const std::uint8_t*, kBlockRows * kBlockCols> straight{};
      std::array<const std::uint8_t*, kBlockRows * kBlockCols> mirrored{};
      std::array<const std::uint8_t*, kBlockCols> columns{};
      // A block at the edge repeats its last row or column; what comes of the repetition is not written.
      for (std::size_t j = 0; j < kBlockCols; ++j) columns[j] = mask(std::min(j0 + j, cols.end - 1));
      bool any = false;
      for (std::size_t i = 0; i < kBlockRows; ++i) {
        const auto row = std::min(i0 + i, rows.end - 1);
        for (std::size_t j = 0; j < kBlockCols; ++j) {
          const auto col = std::min(j0 + j, cols.end - 1);
          const bool both = body_of(row) && body_of(col);
          any = any || both;
          straight[i * kBlockCols + j] = mask(row);
          mirrored[i * kBlockCols + j] = scratch.mirror(
              row, both ? body::mirror_shift(remainders_[row], areas_[row], remainders_[col], areas_[col]) : 0);
        }
      }
      std::array<std::uint32_t, kBlockRows * kBlockCols> common{};
      std::array<std::uint32_t, kBlockRows * kBlockCols> common_mirrored{};
      for (std::size_t begin = 0; any && begin < bytes_; begin += kChunk) {
        const auto length = std::min(kChunk, bytes_ - begin);
        kernel_.block(straight.data(), columns.data(), length, common.data());
        kernel_.block(mirrored.data(), columns.data(), length, common_mirrored.data());
        for (auto& p : straight) p += length;
        for (auto& p : mirrored) p += length;
        for (auto& p : columns) p += length;
      }
      for (std::size_t i = 0; i < kBlockRows && i0 + i < rows.end; ++i) {
        for (std::size_t j = 0; j < kBlockCols && j0 + j < cols.end; ++j) {
          const auto row = i0 + i;
          const auto col = j0 + j;
          float value = std::numeric_limits<float>::quiet_NaN();
          float mirror_value = value;
          if (body_of(row) && body_of(col)) {
            const auto k = i * kBlockCols + j;
            value = float(body::similarity_of_counts(common[k], areas_[row], areas_[col]));
            mirror_value = float(body::similarity_of_counts(common_mirrored[k], areas_[row], areas_[col]));
          }
          z(row - rows.begin, col - cols.begin) = value;
          zstar(row - rows.begin, col - cols.begin) = mirror_value;
        }
      }
    }
  }
}

}  // namespace choreo::similarity

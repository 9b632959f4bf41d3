// SPDX-License-Identifier: Apache-2.0
#include "vision/tone_mapper.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

namespace choreo::vision {
namespace {

constexpr int kShift = 8 - ToneMapper::kBits;
constexpr std::size_t kSteps = std::size_t(1) << ToneMapper::kBits;
constexpr std::size_t kTable = kSteps * kSteps * kSteps;
constexpr std::size_t kMostCells = 512;  // At a time: what is reckoned of them stays in the first cache.

std::size_t cell_at(std::size_t b, std::size_t g, std::size_t r) { return (b * kSteps + g) * kSteps + r; }

cv::Mat looked_up(const std::uint8_t* table, const cv::Mat& picture, const cv::Mat& mask) {
  assert(picture.type() == CV_8UC3);
  assert(mask.empty() || (mask.type() == CV_8UC1 && mask.size() == picture.size()));
  cv::Mat out(picture.size(), CV_8UC1);
  const auto at = [table](const std::uint8_t* p) {
    return table[cell_at(std::size_t(p[0] >> kShift), std::size_t(p[1] >> kShift), std::size_t(p[2] >> kShift))];
  };
  for (int y = 0; y < picture.rows; ++y) {
    const auto* p = picture.ptr<std::uint8_t>(y);
    const auto* m = mask.empty() ? nullptr : mask.ptr<std::uint8_t>(y);
    auto* o = out.ptr<std::uint8_t>(y);
    for (int x = 0; x < picture.cols; ++x) o[x] = m == nullptr || m[x] != 0 ? at(p + 3 * x) : std::uint8_t(0);
  }
  return out;
}

}  // namespace

// The cells' centres as colours, by their value: a density's part of v is reckoned once a value.
struct ToneMapper::Cells {
  struct Shell {
    double v = 0;
    std::vector<std::uint32_t> cell;
    std::vector<float> x, y;
  };
  std::array<Shell, kSteps> shells;

  Cells() {
    const auto centre = [](std::size_t step) { return double(step << kShift) + 0.5 * ((1 << kShift) - 1); };
    for (std::size_t b = 0; b < kSteps; ++b) {
      for (std::size_t g = 0; g < kSteps; ++g) {
        for (std::size_t r = 0; r < kSteps; ++r) {
          const auto colour = tone_colour({centre(b), centre(g), centre(r)});
          auto& shell = shells[std::max({b, g, r})];
          shell.v = colour.v;
          shell.cell.push_back(static_cast<std::uint32_t>(cell_at(b, g, r)));
          shell.x.push_back(static_cast<float>(colour.x));
          shell.y.push_back(static_cast<float>(colour.y));
        }
      }
    }
  }
};

ToneMapper::ToneMapper(ToneSet tones) : cells_(std::make_shared<const Cells>()) { rebuild(std::move(tones)); }

void ToneMapper::rebuild(ToneSet tones) {
  prepare(std::move(tones));
  advance(1);
}

void ToneMapper::prepare(ToneSet tones) {
  tones.validate();
  begun_.emplace(Begun());
  begun_->tones = std::move(tones);
  begun_->tables.resize(begun_->tones.tones.size());
  for (auto& table : begun_->tables) table.resize(kTable);
}

bool ToneMapper::advance(int parts) {
  assert(parts > 0);
  if (!begun_) return false;
  auto& begun = *begun_;
  const auto share = kTable / static_cast<std::size_t>(parts) + 1;
  for (std::size_t done = 0; done < share && begun.shell < kSteps;) {
    const auto left = cells_->shells[begun.shell].cell.size() - begun.at;
    const auto cells = std::min(kMostCells, left);
    fill(begun, cells);
    done += cells;
    begun.at += cells;
    if (cells == left) {
      ++begun.shell;
      begun.at = 0;
    }
  }
  if (begun.shell < kSteps) return false;
  tones_ = std::move(begun.tones);
  tables_ = std::move(begun.tables);
  begun_.reset();
  return true;
}

// The next cells, all of one value.
void ToneMapper::fill(Begun& begun, std::size_t cells) const {
  const auto& shell = cells_->shells[begun.shell];
  const auto x = std::span(shell.x).subspan(begun.at, cells);
  const auto y = std::span(shell.y).subspan(begun.at, cells);
  const auto count = begun.tones.tones.size();
  std::vector<std::array<float, kMostCells>> joint(count);  // P(colour | tone) P(tone).
  std::array<float, kMostCells> density;
  std::array<float, kMostCells> sum;
  std::fill_n(sum.begin(), cells, static_cast<float>(begun.tones.outliers * outlier_density(shell.v)));
  for (std::size_t t = 0; t < count; ++t) {
    const auto& tone = begun.tones.tones[t];
    double weights = 0;
    for (const auto& part : tone.parts) weights += part.weight;
    std::fill_n(joint[t].begin(), cells, 0.0F);
    for (const auto& part : tone.parts) {
      part.model->densities(shell.v, x, y, std::span(density).first(cells));
      const auto weight = static_cast<float>(tone.prior * part.weight / weights);
      for (std::size_t i = 0; i < cells; ++i) joint[t][i] += weight * density[i];
    }
    for (std::size_t i = 0; i < cells; ++i) sum[i] += joint[t][i];
  }
  const auto* cell = shell.cell.data() + begun.at;
  for (std::size_t t = 0; t < count; ++t) {
    auto* table = begun.tables[t].data();
    for (std::size_t i = 0; i < cells; ++i) density[i] = 255.0F * joint[t][i] / sum[i] + 0.5F;
    for (std::size_t i = 0; i < cells; ++i) table[cell[i]] = static_cast<std::uint8_t>(density[i]);
  }
}

cv::Mat ToneMapper::posterior(const cv::Mat& picture, const cv::Mat& mask, std::size_t tone) const {
  assert(tone < tables_.size());
  return looked_up(tables_[tone].data(), picture, mask);
}

cv::Mat ToneMapper::posterior(const cv::Mat& picture, const cv::Mat& mask, std::span<const std::size_t> tones) const {
  if (tones.size() == 1) return posterior(picture, mask, tones[0]);
  std::vector<std::uint8_t> all(kTable, 0);
  for (const auto tone : tones) {
    assert(tone < tables_.size());
    const auto* table = tables_[tone].data();
    // Rounded one by one they may sum to 256.
    for (std::size_t i = 0; i < kTable; ++i) all[i] = static_cast<std::uint8_t>(std::min(255, all[i] + table[i]));
  }
  return looked_up(all.data(), picture, mask);
}

}  // namespace choreo::vision

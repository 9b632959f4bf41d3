// SPDX-License-Identifier: Apache-2.0
#include "outputs/picture_sheet.hpp"

#include <algorithm>
#include <cassert>
#include <vector>

#include <opencv2/core.hpp>

#include "outputs/plot_canvas.hpp"

namespace choreo::outputs {
namespace {

constexpr int kWidth = 320;  // Of a picture, px.
constexpr int kColumns = 6;
constexpr int kGap = 12;      // Between pictures, and around all of them.
constexpr int kCaption = 50;  // Below a picture.
constexpr Rgb kPage{0.11, 0.11, 0.12};
constexpr Rgb kLetterColour{1.0, 0.86, 0.20};  // As over the live picture.
constexpr Rgb kName{0.96, 0.96, 0.95};
constexpr Rgb kQuiet{0.66, 0.67, 0.68};

constexpr double kLetterSize = 46;  // Pixels an em; capitals are 0.73 of it high.
constexpr double kLetterRoom = 56;
constexpr double kWordRoom = 100;  // "NUMERALS" and "CANCEL".
constexpr double kSmallType = 15;

// Draws what stands below a picture, whose left lower corner is at `x`, `y`.
void draw_caption(Canvas& canvas, const TextMeter& meter, const SheetTile& tile, double x, double y) {
  const auto letter = printable(tile.letter);
  const double room = letter.size() > 1 ? kWordRoom : kLetterRoom;
  const double base = y + 43;
  if (letter.empty()) {
    canvas.fill({x + 6, y + 24, 30, 5}, kQuiet);
  } else {
    const double natural = meter.width(letter, kLetterSize, true);
    const double size = natural > room - 8 ? kLetterSize * (room - 8) / natural : kLetterSize;
    canvas.text({x + 4, base}, letter, {.size = size, .color = kLetterColour, .bold = true});
  }
  const double left = x + room;
  const double width = x + kWidth - left;
  canvas.text({left, y + 21}, meter.shortened(printable(tile.name), kSmallType, false, width),
              {.size = kSmallType, .color = kName});
  canvas.text({left, base}, meter.shortened(printable(tile.beside), kSmallType, false, width),
              {.size = kSmallType, .color = kQuiet});
}

cv::Mat row_of(std::span<const SheetTile> tiles, int width) {
  int height = 0;
  for (const auto& tile : tiles) height = std::max(height, tile.picture.rows);
  PixelCanvas canvas(width, height + kCaption + kGap);
  canvas.fill({0, 0, double(width), double(height + kCaption + kGap)}, kPage);
  const TextMeter meter;
  double x = kGap;
  for (const auto& tile : tiles) {
    assert(tile.picture.type() == CV_8UC3 && tile.picture.cols == kWidth);
    // Where pictures are of several heights each stands upon its caption.
    const double top = height - tile.picture.rows;
    canvas.image(tile.picture, {x, top, double(kWidth), double(tile.picture.rows)}, Scaling::kCrisp, {});
    draw_caption(canvas, meter, tile, x, height);
    x += kWidth + kGap;
  }
  return canvas.bgr();
}

}  // namespace

cv::Size size_on_sheet(cv::Size picture) {
  return {kWidth, std::clamp(cvRound(double(kWidth) * picture.height / picture.width), 1, 2 * kWidth)};
}

cv::Mat picture_sheet(std::span<const SheetTile> tiles) {
  if (tiles.empty()) return {};
  const auto columns = std::min<std::size_t>(tiles.size(), kColumns);
  const int width = int(columns) * (kWidth + kGap) + kGap;
  // A row at a time: no canvas is as high as a sheet of a thousand pictures.
  std::vector<cv::Mat> rows = {cv::Mat(kGap, width, CV_8UC3)};
  rows.front().setTo(cv::Scalar::all(0));
  for (std::size_t first = 0; first < tiles.size(); first += columns) {
    rows.push_back(row_of(tiles.subspan(first, std::min(columns, tiles.size() - first)), width));
  }
  rows.front().setTo(rows[1].at<cv::Vec3b>(rows[1].rows - 1, 0));  // The page's colour.
  cv::Mat sheet;
  cv::vconcat(rows, sheet);
  return sheet;
}

std::uint64_t bytes_of_sheet(std::uint64_t pictures) {
  constexpr std::uint64_t kTile = 2 * kWidth * kWidth;
  constexpr std::uint64_t kCell = (kWidth + 2 * kGap) * (2 * kWidth + kCaption + kGap);
  return 3 * pictures * (kTile + 2 * kCell);  // The tiles, the rows and the sheet that they become.
}

}  // namespace choreo::outputs

// SPDX-License-Identifier: Apache-2.0
#include "cli/picture_set_results.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "cli/memory.hpp"
#include "cli/results.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/time.hpp"
#include "outputs/letters_json.hpp"
#include "outputs/output_set.hpp"
#include "outputs/picture_sheet.hpp"
#include "outputs/png.hpp"
#include "vision/colourless.hpp"

namespace choreo::cli {
namespace {

using pipeline::PictureReading;

constexpr const char* kLetters = "letters.json";
constexpr const char* kSheet = "pictures.png";

std::optional<std::string> letter_of(const PictureReading& reading) {
  return reading.sign ? std::optional(std::string(*reading.sign)) : std::nullopt;
}

// A run that is killed half way would leave nothing, and one that swaps would never end.
void require_memory(const std::string& source, std::uint64_t pictures) {
  const auto bytes = outputs::bytes_of_sheet(pictures);
  const auto free = available_memory();
  if (!free || bytes <= *free / 10 * 8) return;
  throw usage_error(fmt::format("the sheet of its {} pictures takes {:.1f} GB of memory, and {:.1f} GB are free",
                                pictures, 1e-9 * double(bytes), 1e-9 * double(*free)),
                    source, "read them in several folders");
}

std::string json_of(const std::vector<std::string>& names, const std::vector<PictureReading>& readings) {
  std::vector<outputs::PictureReading> pictures;
  for (std::size_t i = 0; i < names.size(); ++i) {
    recognition::SignReading shown;
    shown.sign = readings[i].sign;
    shown.confidence = readings[i].confidence;
    shown.runner_up = readings[i].runner_up;
    pictures.push_back({names[i], shown});
  }
  return outputs::pictures_json(pictures);
}

// "3 of 26 pictures", "1 of 1 picture".
std::string of_pictures(std::size_t count, std::size_t all) {
  return fmt::format("{} of {}", count, counted(all, "picture"));
}

// "3 of 26 pictures show", "1 of 26 pictures shows".
std::string pictures_show(std::size_t count, std::size_t all) {
  return of_pictures(count, all) + (count == 1 || all == 1 ? " shows" : " show");
}

// Why there is no letter, in a few words.
std::string why_none(const PictureReading& reading) {
  switch (reading.why.value_or(pipeline::NoSign::kUnlikeAny)) {
    case pipeline::NoSign::kNobody:
      return "nobody";
    case pipeline::NoSign::kHidden:
      return "an arm is hidden";
    case pipeline::NoSign::kNoFace:
      return "no face";
    case pipeline::NoSign::kNoTone:
      return "no tone of arms is known";
    case pipeline::NoSign::kArmsHang:
      return "both arms hang";
    case pipeline::NoSign::kUnlikeAny:
      break;
  }
  return "arms like no letter";
}

// A picture with what was seen in it, as wide as the sheet has it.
cv::Mat drawn(const cv::Mat& picture, const PictureReading& reading) {
  const auto size = outputs::size_on_sheet(picture.size());
  const double scale = double(size.width) / picture.cols;
  cv::Mat tile;
  cv::resize(picture, tile, size, 0, 0, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  if (!reading.evidence.empty()) {
    cv::Mat seen;
    cv::resize(reading.evidence, seen, tile.size(), 0, 0, cv::INTER_NEAREST);
    std::vector<std::vector<cv::Point>> outlines;
    cv::findContours(seen, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    cv::drawContours(tile, outlines, -1, {0, 255, 255}, 1);
  }
  if (reading.face) {
    const auto& b = reading.face->box;
    cv::rectangle(
        tile, cv::Rect(cvRound(b.x * scale), cvRound(b.y * scale), cvRound(b.width * scale), cvRound(b.height * scale)),
        {0, 255, 0}, 1);
  }
  for (const auto& arm : reading.forearms)
    cv::line(tile, arm.from * scale, arm.to * scale, {255, 0, 255}, 1, cv::LINE_AA);
  return tile;
}

outputs::SheetTile tile_of(const std::string& name, const cv::Mat& picture, const PictureReading& reading) {
  outputs::SheetTile tile;
  tile.picture = drawn(picture, reading);
  tile.name = name;
  tile.letter = letter_of(reading).value_or("");
  tile.beside = reading.sign ? fmt::format("{:.2f}, then {}", reading.confidence, reading.runner_up)
                             : fmt::format("{:.2f}, {}", reading.confidence, why_none(reading));
  return tile;
}

void warn_of(const std::vector<std::string>& names, const std::vector<PictureReading>& readings, std::size_t colourless,
             Console& console) {
  const auto tell = [&](pipeline::NoSign why, const char* what, const char* consequence) {
    const auto is = [why](const auto& reading) { return reading.why == why; };
    const auto first = std::ranges::find_if(readings, is);
    if (first == readings.end()) return;
    console.warn(fmt::format("{} {}, the first \"{}\"{}", what,
                             of_pictures(std::size_t(std::ranges::count_if(readings, is)), names.size()),
                             one_line(names[std::size_t(first - readings.begin())]), consequence));
  };
  tell(pipeline::NoSign::kNobody, "nobody was seen in", "");
  tell(pipeline::NoSign::kNoFace, "no face was found in", ": without one nothing tells where arms are");
  if (colourless > 0 && !readings.front().by_network) {
    console.warn(fmt::format("no colour in {}: tones need it, and nothing tells of arms",
                             of_pictures(colourless, names.size())));
  }
}

}  // namespace

int analyze_pictures(devices::Source& source, const ReadPicture& read_picture, const std::filesystem::path& out,
                     Session& session) {
  auto& console = session.console;
  const auto stop = session.interrupt.orderly();
  outputs::OutputSet files(out);
  files.check(kLetters);
  files.check(kSheet);
  const auto& info = source.info();
  const auto expected =
      std::uint64_t(std::llround(to_seconds(info.duration.value_or(Nanoseconds{0})) * info.nominal_fps));
  require_memory(info.name, expected);
  std::vector<std::string> names;
  std::vector<PictureReading> readings;
  std::vector<outputs::SheetTile> tiles;
  std::size_t colourless = 0;
  while (const auto frame = source.read(stop)) {
    const auto picture = pipeline::reduced_picture(frame->bgr);
    colourless += vision::colourless(picture) ? 1 : 0;
    names.push_back(frame->name);
    readings.push_back(read_picture(picture));
    tiles.push_back(tile_of(names.back(), picture, readings.back()));
    readings.back().evidence.release();  // Drawn, and large.
    console.progress("reading pictures", double(readings.size()) / double(std::max<std::uint64_t>(expected, 1)));
  }
  if (stop.stop_requested()) throw Interrupted{};
  console.finish_progress();
  outputs::write_file(files.add(kLetters), json_of(names, readings));
  const auto sheet = outputs::picture_sheet(tiles);
  outputs::write_file(files.add(kSheet), outputs::png_of(sheet));
  supersede_others(files, std::vector<std::string>{kLetters, kSheet});
  files.commit();
  for (const auto& warning : source.warnings()) console.warn(warning);
  warn_of(names, readings, colourless, console);
  std::string letters;
  std::size_t read = 0;
  for (const auto& reading : readings) {
    const auto letter = letter_of(reading);
    read += letter ? 1 : 0;
    letters += (letters.empty() ? "" : " ") + letter.value_or("-");
  }
  fmt::print("{} a sign: {}\n", pictures_show(read, names.size()), letters);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto& reading = readings[i];
    if (reading.sign) continue;
    fmt::print("{}: no letter, {} (confidence {:.3f})\n", one_line(names[i]), why_none(reading), reading.confidence);
  }
  fmt::print("wrote {} and {}\n", (out / kLetters).string(), (out / kSheet).string());
  // Also where all pictures were read before: whoever stops a batch wants the batch to stop.
  return stop.stop_requested() ? kInterrupted : kDone;
}

}  // namespace choreo::cli

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
// @param pixels  of the reduced pictures, as far as they are known.
// @param free  bytes before the first of them was read.
void require_memory(const std::string& source, std::uint64_t pictures, std::uint64_t pixels,
                    std::optional<std::uint64_t> free) {
  const auto bytes = pipeline::bytes_to_read(pixels, pictures) + outputs::bytes_of_sheet(pictures);
  if (!free || bytes <= *free / 10 * 8) return;
  throw usage_error(fmt::format("its {} pictures take {:.1f} GB of memory together, and {:.1f} GB are free", pictures,
                                1e-9 * double(bytes), 1e-9 * double(*free)),
                    source, "read them in several folders");
}

std::uint64_t reduced_pixels(cv::Size size, int longest_side) {
  const double shrink = std::min(1.0, double(longest_side) / std::max(size.width, size.height));
  return std::uint64_t(shrink * shrink * double(size.area()));
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
    case pipeline::NoSign::kNoArms:
      return reading.face_seen ? "no arms" : "neither face nor arms";
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
        reading.face_seen ? cv::Scalar(0, 255, 0) : cv::Scalar(0, 160, 160), 1);
  }
  if (reading.overlap > 0 || (reading.by_network && reading.why != pipeline::NoSign::kNobody)) {
    for (const auto& arm : reading.arms) {
      cv::line(tile, arm.from * scale, arm.to * scale, {255, 0, 255}, 1, cv::LINE_AA);
    }
  }
  return tile;
}

std::vector<outputs::SheetTile> tiles_of(const std::vector<std::string>& names, const std::vector<cv::Mat>& pictures,
                                         const std::vector<PictureReading>& readings) {
  std::vector<outputs::SheetTile> tiles;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto& reading = readings[i];
    outputs::SheetTile tile;
    tile.picture = drawn(pictures[i], reading);
    tile.name = names[i];
    tile.letter = letter_of(reading).value_or("");
    tile.beside = reading.sign ? fmt::format("{:.2f}, then {}", reading.confidence, reading.runner_up)
                               : fmt::format("{:.2f}, {}", reading.confidence, why_none(reading));
    tiles.push_back(std::move(tile));
  }
  return tiles;
}

void warn_of(const std::vector<std::string>& names, const std::vector<cv::Mat>& pictures,
             const std::vector<PictureReading>& readings, Console& console) {
  const auto first = [&](auto holds) {
    std::pair<std::size_t, std::string> out{0, {}};
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (holds(readings[i]) && out.first++ == 0) out.second = names[i];
    }
    return out;
  };
  const auto [unseen, unseen_name] = first([](const auto& r) { return r.why == pipeline::NoSign::kNobody; });
  if (unseen > 0) {
    console.warn(fmt::format("nobody was seen in {}, the first \"{}\"", of_pictures(unseen, names.size()),
                             one_line(unseen_name)));
  }
  if (readings.empty() || readings.front().by_network) return;
  const auto [faceless, faceless_name] = first([](const auto& r) { return !r.face; });
  if (faceless > 0) {
    console.warn(fmt::format("no face was found in {}, the first \"{}\": without one nothing tells where arms are",
                             of_pictures(faceless, names.size()), one_line(faceless_name)));
  }
  const auto grey = std::find_if(pictures.begin(), pictures.end(), vision::colourless);
  if (grey != pictures.end()) {
    const auto count = std::count_if(pictures.begin(), pictures.end(), vision::colourless);
    console.warn(fmt::format(
        "no colour in {}, the first \"{}\": tones need it, and only what differs from the wall tells of arms",
        of_pictures(std::size_t(count), names.size()), one_line(names[std::size_t(grey - pictures.begin())])));
  }
  const auto [alone, alone_name] = first([](const auto& r) { return !r.shared; });
  if (alone > 0 && names.size() > 1) {
    console.warn(fmt::format("{} a scene of {} own, the first \"{}\": what has skin's colour there counts as arm",
                             pictures_show(alone, names.size()), alone == 1 ? "its" : "their", one_line(alone_name)));
  }
}

std::optional<std::vector<PictureReading>> read_each(const std::vector<cv::Mat>& pictures, vision::PersonSearch& people,
                                                     bool mirrored, const std::function<void(double)>& report,
                                                     const std::stop_token& stop) {
  std::vector<PictureReading> readings;
  for (const auto& picture : pictures) {
    if (stop.stop_requested()) return std::nullopt;
    readings.push_back(pipeline::read_by_network(picture, people, mirrored));
    report(double(readings.size()) / double(pictures.size()));
  }
  return readings;
}

}  // namespace

int analyze_pictures(devices::Source& source, vision::FaceDetector& faces, vision::PersonSearch* people,
                     const pipeline::PictureSetOptions& options, const std::filesystem::path& out, Session& session) {
  auto& console = session.console;
  const auto stop = session.interrupt.orderly();
  options.validate();
  outputs::OutputSet files(out);
  files.check(kLetters);
  files.check(kSheet);
  const auto& info = source.info();
  const auto expected =
      std::uint64_t(std::llround(to_seconds(info.duration.value_or(Nanoseconds{0})) * info.nominal_fps));
  const auto free = available_memory();
  require_memory(info.name, expected, expected * reduced_pixels(info.size, options.longest_side), free);
  std::vector<cv::Mat> pictures;
  std::vector<std::string> names;
  std::uint64_t pixels = 0;
  while (const auto frame = source.read(stop)) {
    pictures.push_back(pipeline::reduced_picture(frame->bgr, options.longest_side));
    names.push_back(frame->name);
    pixels += pictures.back().total();
    require_memory(info.name, expected, pixels, free);  // Later ones may be larger than the first.
  }
  if (stop.stop_requested()) throw Interrupted{};
  const auto report = [&](double share) { console.progress("reading pictures", share); };
  const auto readings = people != nullptr ? read_each(pictures, *people, options.semaphore.mirrored, report, stop)
                                          : pipeline::read_pictures(pictures, faces, options, report, stop);
  console.finish_progress();
  if (!readings) throw Interrupted{};
  outputs::write_file(files.add(kLetters), json_of(names, *readings));
  const auto sheet = outputs::picture_sheet(tiles_of(names, pictures, *readings));
  outputs::write_file(files.add(kSheet), outputs::png_of(sheet));
  supersede_others(files, std::vector<std::string>{kLetters, kSheet});
  files.commit();
  for (const auto& warning : source.warnings()) console.warn(warning);
  warn_of(names, pictures, *readings, console);
  std::string letters;
  std::size_t read = 0;
  for (const auto& reading : *readings) {
    const auto letter = letter_of(reading);
    read += letter ? 1 : 0;
    letters += (letters.empty() ? "" : " ") + letter.value_or("-");
  }
  fmt::print("{} a sign: {}\n", pictures_show(read, names.size()), letters);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto& reading = (*readings)[i];
    if (reading.sign) continue;
    fmt::print("{}: no letter, {} (confidence {:.3f})\n", one_line(names[i]), why_none(reading), reading.confidence);
  }
  fmt::print("wrote {} and {}\n", (out / kLetters).string(), (out / kSheet).string());
  // Also where all pictures were read before: whoever stops a batch wants the batch to stop.
  return stop.stop_requested() ? kInterrupted : kDone;
}

}  // namespace choreo::cli

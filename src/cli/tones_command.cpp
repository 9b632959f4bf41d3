// SPDX-License-Identifier: Apache-2.0
// choreoscope tones: trains tones from labelled pixels, shows what is in a tones file, tests it.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <opencv2/core.hpp>

#include "cli/commands.hpp"
#include "cli/given_picture.hpp"
#include "config/colour_table.hpp"
#include "config/tones_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "outputs/output_set.hpp"
#include "vision/tone_mapper.hpp"

namespace choreo::cli {
namespace {

namespace fs = std::filesystem;

constexpr auto kTonesExamples = R"(
Examples:
  choreoscope tones train samples.csv --name skin --out skin.toml
  choreoscope tones train --picture p.png --mask m.png --name flag --out my.toml
  choreoscope tones show my.toml
  choreoscope tones test skin.toml samples.csv)";

constexpr auto kTrainManual = R"(
From a CSV: one colour a line, blue, green, red from 0 to 255 and a label. What a
first line calls its columns is believed; --columns says otherwise. Rows of the
label are the tone; with --others the rest become a tone of that name.
From a picture: the tone is where the mask (of the picture's size) is not black.

Examples:
  choreoscope tones train samples.csv --columns B,G,R,label --name skin --out skin.toml
  choreoscope tones train --picture p.png --mask m.png --name flag --parts 2 \
      --merge skin.toml --out my.toml)";

constexpr auto kTestManual = R"(
Precision, recall and F1 of one tone on labelled colours, by the tables that
runs use.

Example:
  choreoscope tones test skin.toml samples.csv --columns B,G,R,label --half second)";

struct TableOptions {
  std::string csv, columns;
  int label = 1;
  std::string half = "all";
};

struct TrainOptions {
  TableOptions table;
  std::string picture, mask, name, out, others, model = "gaussian";
  std::vector<std::string> merge;
  double prior = 0.2, outliers = 0.5, noise = 2;
  int parts = 1;
};

struct TestOptions {
  TableOptions table;
  std::string file, name = "skin";
  double threshold = 0.5;
};

struct Labelled {
  std::vector<cv::Vec3b> tone, rest;
};

void add_table_options(CLI::App& command, TableOptions& options) {
  command.add_option("--columns", options.columns, "what the CSV's columns are, - for others: B,G,R,label")
      ->type_name("NAMES");
  command.add_option("--label", options.label, "the label of the tone's rows")->capture_default_str();
  command.add_option("--half", options.half, "all rows, or those in every other block of 1000: first, second")
      ->type_name("ROWS:{all,first,second}")
      ->capture_default_str();
}

Labelled labelled_of(const TableOptions& options) {
  if (options.half != "all" && options.half != "first" && options.half != "second") {
    throw usage_error(fmt::format("--half is \"{}\"", shortened(options.half)), {}, "it is all, first or second");
  }
  const auto table = config::load_colour_table(options.csv, options.columns);
  constexpr std::size_t kBlock = 1000;  // Samples of one photograph follow one another: single rows would be no test.
  Labelled out;
  for (std::size_t i = 0; i < table.bgr.size(); ++i) {
    if (options.half != "all" && (i / kBlock % 2 == 0) != (options.half == "first")) continue;
    (table.label[i] == options.label ? out.tone : out.rest).push_back(table.bgr[i]);
  }
  if (out.tone.empty() && out.rest.empty()) {
    throw usage_error(fmt::format("none of the {} rows is of the {} half", table.bgr.size(), options.half), options.csv,
                      fmt::format("halves are every other block of {} rows: give more, or leave --half out", kBlock));
  }
  if (out.tone.empty() || out.rest.empty()) {
    throw usage_error(fmt::format("all rows are of one class: {} of label {}, {} of others", out.tone.size(),
                                  options.label, out.rest.size()),
                      options.csv, "both what the tone is and what it is not are needed; --label says which is which");
  }
  return out;
}

// The columns of a file may be called what they are not.
void refuse_blue_skin(const std::vector<cv::Vec3b>& skin, const std::string& csv) {
  const auto bluer = std::count_if(skin.begin(), skin.end(), [](const cv::Vec3b& c) { return c[0] > c[2]; });
  if (double(bluer) < 0.5 * double(skin.size())) return;
  throw usage_error(fmt::format("{:.0f} % of the skin is bluer than red: the columns are not what they are called",
                                100.0 * double(bluer) / double(skin.size())),
                    csv, "say what they are, such as --columns B,G,R,label");
}

std::vector<cv::Vec3b> masked_pixels(const TrainOptions& options) {
  const std::string hint = "give a PNG, JPEG, TIFF or the like";
  const auto picture = read_picture(options.picture, "picture", hint);
  const auto mask = read_picture(options.mask, "mask", hint);
  if (picture.size() != mask.size()) {
    throw usage_error(fmt::format("the mask is of {} x {} pixels and the picture of {} x {}", mask.cols, mask.rows,
                                  picture.cols, picture.rows),
                      options.mask, "paint the mask over the picture itself, white where the tone is");
  }
  std::vector<cv::Vec3b> pixels;
  bool colour = false;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const auto& p = picture.at<cv::Vec3b>(y, x);
      colour = colour || p[0] != p[1] || p[1] != p[2];
      if (mask.at<cv::Vec3b>(y, x) != cv::Vec3b(0, 0, 0)) pixels.push_back(p);
    }
  }
  if (!colour) throw usage_error("is a grey picture: tones need colour", options.picture);
  if (pixels.size() == picture.total()) {
    throw usage_error("the mask leaves nothing out: all pixels are of one class", options.mask,
                      "white where the tone is, black elsewhere");
  }
  return pixels;
}

vision::Tone trained(const TrainOptions& options, const std::string& name, const std::vector<cv::Vec3b>& pixels,
                     const std::string& from) {
  vision::ToneFit fit;
  fit.kind = vision::tone_kind_named(options.model);
  fit.parts = options.parts;
  fit.noise = options.noise;
  try {
    return {name, options.prior, vision::fitted_parts(pixels, fit)};
  } catch (const Error& error) {
    if (!error.where().empty()) throw;
    throw usage_error(fmt::format("tone \"{}\": {}", name, error.what()), from, error.hint());
  }
}

// As a shell takes it for one word.
std::string as_word(const std::string& text) {
  const auto plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("_-+=.,:/@%").find(c) != std::string_view::npos;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), plain)) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

// All that decides what is in the file, so that it can be made again.
std::string made_by(const TrainOptions& options) {
  const TrainOptions usual;
  std::string said = "choreoscope tones train";
  const auto say = [&](const char* option, const std::string& value) {
    if (!value.empty()) said += fmt::format(" {} {}", option, as_word(value));
  };
  const auto say_number = [&](const char* option, auto value, auto unless) {
    if (value != unless) say(option, fmt::format("{}", value));
  };
  if (!options.table.csv.empty()) {
    said += " " + as_word(options.table.csv);
    say("--columns", options.table.columns);
    say_number("--label", options.table.label, usual.table.label);
    if (options.table.half != usual.table.half) say("--half", options.table.half);
  }
  say("--picture", options.picture);
  say("--mask", options.mask);
  say("--name", options.name);
  say("--others", options.others);
  for (const auto& file : options.merge) say("--merge", file);
  say("--model", options.model);
  say_number("--parts", options.parts, usual.parts);
  say_number("--prior", options.prior, usual.prior);
  say_number("--outliers", options.outliers, usual.outliers);
  say_number("--noise", options.noise, usual.noise);
  return said;
}

int train(const TrainOptions& options) {
  const bool from_table = !options.table.csv.empty();
  if (from_table == (!options.picture.empty() || !options.mask.empty())) {
    throw usage_error("tones train: a CSV, or a picture with its mask?", {},
                      "give either a CSV or both of --picture and --mask");
  }
  if (!from_table && (options.picture.empty() || options.mask.empty())) {
    throw usage_error("tones train: a picture needs a mask, and a mask a picture", {},
                      "give both --picture and --mask");
  }
  if (!from_table && !options.others.empty()) {
    throw usage_error("tones train: --others is for a CSV's other rows", {}, "leave it out with --picture");
  }
  if (!(options.prior >= 0.001 && options.prior <= 1000)) {
    throw usage_error(fmt::format("--prior is {}", options.prior), {}, "from 0.001 to 1000");
  }
  if (!(options.outliers >= 0.001 && options.outliers <= 1000)) {
    throw usage_error(fmt::format("--outliers is {}", options.outliers), {}, "from 0.001 to 1000");
  }
  for (const auto& [option, name] : {std::pair{"--name", options.name}, std::pair{"--others", options.others}}) {
    if (is_utf8(name)) continue;
    throw usage_error(fmt::format("{} \"{}\" is not UTF-8: no tones file can hold it", option, shortened(name)), {},
                      "call the tone in UTF-8, or in plain letters");
  }
  const fs::path path = options.out;
  if (!path.has_filename()) {
    throw usage_error(fmt::format("--out \"{}\" names no file", shortened(options.out)), {}, "for instance tones.toml");
  }
  vision::ToneSet set;
  for (const auto& file : options.merge) {
    for (auto& tone : config::load_tones(file).tones) set.put(std::move(tone));
  }
  set.outliers = options.outliers;
  outputs::OutputSet folder(path.has_parent_path() ? path.parent_path() : fs::path("."));
  folder.check(path.filename().string());
  std::size_t pixels = 0;
  if (from_table) {
    const auto labelled = labelled_of(options.table);
    if (options.name == "skin") refuse_blue_skin(labelled.tone, options.table.csv);
    set.put(trained(options, options.name, labelled.tone, options.table.csv));
    pixels = labelled.tone.size();
    if (!options.others.empty()) {
      if (options.others == options.name) throw usage_error("--others is called as --name is", {}, "call it otherwise");
      set.put(trained(options, options.others, labelled.rest, options.table.csv));
    }
  } else {
    const auto masked = masked_pixels(options);
    set.put(trained(options, options.name, masked, options.mask));
    pixels = masked.size();
  }
  set.validate();
  outputs::write_file(folder.add(path.filename().string()), config::print_tones(set, made_by(options)));
  folder.commit();
  fmt::print("{}: tone \"{}\" from {} pixels\n", path.string(), one_line(options.name), pixels);
  return kDone;
}

// Hue in degrees and saturation in per cent of a place in the disc.
std::string in_words(double x, double y) {
  const double hue = std::atan2(y, x) * 180 / std::numbers::pi;
  return fmt::format("hue {:.0f} deg, saturation {:.0f} %", hue < 0 ? hue + 360 : hue, 100 * std::hypot(x, y));
}

int show(const std::string& file) {
  const auto set = config::load_tones(file);
  double sum = set.outliers;
  for (const auto& tone : set.tones) sum += tone.prior;
  for (const auto& tone : set.tones) {
    fmt::print("{}: prior {:.3f}\n", one_line(tone.name), tone.prior / sum);
    for (const auto& part : tone.parts) {
      if (const auto* g = dynamic_cast<const vision::GaussianTone*>(part.model.get())) {
        const auto& p = g->parameters();
        const auto value = g->with_value() ? fmt::format(", value {:.0f} +- {:.0f} %", 100 * p.mean[2],
                                                         100 * std::sqrt(p.covariance(2, 2)))
                                           : std::string(", any value");
        fmt::print("  gaussian: {}{}; spread {:.3f} x {:.3f}; weight {:.2f}\n", in_words(p.mean[0], p.mean[1]), value,
                   std::sqrt(p.covariance(0, 0)), std::sqrt(p.covariance(1, 1)), part.weight);
      } else if (const auto* h = dynamic_cast<const vision::HistogramTone*>(part.model.get())) {
        const auto& weights = h->parameters().weights;
        const auto most = std::max_element(weights.begin(), weights.end()) - weights.begin();
        const auto at = [](std::ptrdiff_t i) { return (double(i) + 0.5) * 2 / vision::HistogramTone::kCells - 1; };
        fmt::print("  histogram: most at {}; {} of {} cells; weight {:.2f}\n",
                   in_words(at(most % vision::HistogramTone::kCells), at(most / vision::HistogramTone::kCells)),
                   std::count_if(weights.begin(), weights.end(), [](float w) { return w > 0; }), weights.size(),
                   part.weight);
      }
    }
  }
  fmt::print("outliers: prior {:.3f}\n", set.outliers / sum);
  return kDone;
}

int test(const TestOptions& options) {
  if (!(options.threshold >= 0.01 && options.threshold <= 0.99)) {
    throw usage_error(fmt::format("--threshold is {}", options.threshold), {}, "from 0.01 to 0.99");
  }
  const vision::ToneMapper mapper(config::load_tones(options.file));
  const auto tone = mapper.tones().find(options.name);
  if (tone == mapper.tones().tones.size()) {
    throw usage_error(fmt::format("holds no tone \"{}\"", shortened(options.name)), options.file,
                      hint_for_name(options.name, mapper.tones().names()));
  }
  const auto labelled = labelled_of(options.table);
  const auto found = [&](const std::vector<cv::Vec3b>& pixels) {
    const cv::Mat picture(static_cast<int>(pixels.size()), 1, CV_8UC3, const_cast<cv::Vec3b*>(pixels.data()));
    return double(cv::countNonZero(mapper.posterior(picture, {}, tone) >= 255 * options.threshold));
  };
  const double hits = found(labelled.tone);
  const double false_hits = found(labelled.rest);
  const double precision = hits + false_hits > 0 ? hits / (hits + false_hits) : 0;
  const double recall = hits / double(labelled.tone.size());
  const double f1 = precision + recall > 0 ? 2 * precision * recall / (precision + recall) : 0;
  fmt::print("{} of {} pixels are \"{}\"\nprecision {:.4f}\nrecall {:.4f}\nf1 {:.4f}\n", labelled.tone.size(),
             labelled.tone.size() + labelled.rest.size(), one_line(options.name), precision, recall, f1);
  return kDone;
}

}  // namespace

void declare_tones(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand("tones", "train colour tones (skin, gloves, flags), show them, test them");
  command->require_subcommand(1);
  command->footer(kTonesExamples);

  auto training = std::make_shared<TrainOptions>();
  auto* train_command = command->add_subcommand("train", "make a tones file from labelled pixels");
  train_command->add_option("CSV", training->table.csv, "labelled colours");
  add_table_options(*train_command, training->table);
  train_command->add_option("--picture", training->picture, "a picture that shows the tone")->type_name("FILE");
  train_command->add_option("--mask", training->mask, "where in it: not black")->type_name("FILE");
  train_command->add_option("--name", training->name, "what the tone is called")->required();
  train_command->add_option("--others", training->others, "make a tone of this name of a CSV's other rows, too")
      ->type_name("NAME");
  train_command->add_option("-o,--out", training->out, "the tones file to write")->required()->type_name("FILE");
  train_command->add_option("--merge", training->merge, "begin with the tones of this file; may be repeated")
      ->type_name("FILE")
      ->allow_extra_args(false);
  train_command->add_option("--model", training->model, "what densities are made of")
      ->type_name("MODEL:{gaussian,histogram}")
      ->capture_default_str();
  train_command->add_option("--parts", training->parts, "clusters of colours, 1 to 8: 2 for a flag of two colours")
      ->capture_default_str();
  train_command->add_option("--prior", training->prior, "how common the tone is, 0.001 to 1000, beside the others")
      ->capture_default_str();
  train_command->add_option("--outliers", training->outliers, "how common all else is, 0.001 to 1000")
      ->capture_default_str();
  train_command->add_option("--noise", training->noise, "of the camera, grey levels, 0 to 50")->capture_default_str();
  train_command->footer(kTrainManual);
  train_command->callback([training, &chosen] { chosen = [training](Session&) { return train(*training); }; });

  auto file = std::make_shared<std::string>();
  auto* show_command = command->add_subcommand("show", "print what is in a tones file");
  show_command->add_option("FILE", *file, "a tones file")->required();
  show_command->footer("\nExample:\n  choreoscope tones show my.toml");
  show_command->callback([file, &chosen] { chosen = [file](Session&) { return show(*file); }; });

  auto testing = std::make_shared<TestOptions>();
  auto* test_command = command->add_subcommand("test", "print precision, recall and F1 on labelled pixels");
  test_command->add_option("FILE", testing->file, "a tones file")->required();
  test_command->add_option("CSV", testing->table.csv, "labelled colours")->required();
  add_table_options(*test_command, testing->table);
  test_command->add_option("--name", testing->name, "the tone to test")->capture_default_str();
  test_command->add_option("--threshold", testing->threshold, "least posterior, 0.01 to 0.99")->capture_default_str();
  test_command->footer(kTestManual);
  test_command->callback([testing, &chosen] { chosen = [testing](Session&) { return test(*testing); }; });
}

}  // namespace choreo::cli

// SPDX-License-Identifier: Apache-2.0
#include "config/tones_file.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "config/text_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::config {
namespace {

using vision::GaussianTone;
using vision::HistogramTone;

constexpr std::uintmax_t kMostTonesBytes = 4U << 20;
constexpr std::size_t kMostTones = 64;
constexpr std::size_t kMostParts = 16;
constexpr auto kWhatItIs = "a tones file is what `choreoscope tones train` writes";

// Reads the nodes of one file, and says where in it one is wrong.
class Reader {
 public:
  explicit Reader(std::string name) : name_(std::move(name)) {}

  [[nodiscard]] std::string place(const toml::node& node) const {
    return fmt::format("{}:{}:{}", name_, node.source().begin.line, node.source().begin.column);
  }

  [[noreturn]] void refuse(const toml::node& node, const std::string& what, const std::string& hint = kWhatItIs) const {
    throw usage_error(what, place(node), hint);
  }

  [[nodiscard]] const toml::node& need(const toml::table& table, const char* key) const {
    if (const auto* node = table.get(key)) return *node;
    refuse(table, fmt::format("\"{}\" is missing here: part of a tones file, or none", key));
  }

  void only(const toml::table& table, const std::vector<std::string>& keys) const {
    for (const auto& [key, node] : table) {
      const std::string known(key.str());
      if (std::find(keys.begin(), keys.end(), known) != keys.end()) continue;
      refuse(node, fmt::format("unknown key \"{}\"", shortened(known)), hint_for_name(known, keys));
    }
  }

  [[nodiscard]] double number(const toml::node& node, double least, double most) const {
    std::optional<double> value;
    if (const auto* real = node.as_floating_point()) value = real->get();
    if (const auto* whole = node.as_integer()) value = double(whole->get());
    if (!value || !(*value >= least && *value <= most)) {
      refuse(node, value ? fmt::format("the number {} is out of range", *value) : "is no number",
             fmt::format("a number from {} to {} stands here", least, most));
    }
    return *value + 0.0;  // There is no negative zero.
  }

  [[nodiscard]] int whole(const toml::node& node, int least, int most) const {
    const auto* value = node.as_integer();
    if (value == nullptr || value->get() < least || value->get() > most) {
      refuse(node, "is no whole number in its range", fmt::format("from {} to {} stands here", least, most));
    }
    return static_cast<int>(value->get());
  }

  [[nodiscard]] std::vector<double> numbers(const toml::node& node, std::size_t count, double least,
                                            double most) const {
    const auto* array = node.as_array();
    if (array == nullptr || array->size() != count) refuse(node, fmt::format("is not a row of {} numbers", count));
    std::vector<double> out;
    for (const auto& each : *array) out.push_back(number(each, least, most));
    return out;
  }

  [[nodiscard]] std::string text(const toml::node& node) const {
    const auto* value = node.as_string();
    if (value == nullptr) refuse(node, "is no text");
    return value->get();
  }

  // The tables of an array of tables, of which there must be `count`.
  [[nodiscard]] std::vector<const toml::table*> tables(const toml::table& table, const char* key,
                                                       std::size_t count) const {
    const auto& node = need(table, key);
    const auto* array = node.as_array();
    if (array == nullptr) refuse(node, fmt::format("\"{}\" is no list of tables", key));
    std::vector<const toml::table*> out;
    for (const auto& each : *array) {
      if (!each.is_table()) refuse(each, fmt::format("\"{}\" is no list of tables", key));
      out.push_back(each.as_table());
    }
    if (out.size() != count) {
      refuse(node, fmt::format("{} of \"{}\" where {} were announced: part of a tones file", out.size(), key, count));
    }
    return out;
  }

 private:
  std::string name_;
};

std::shared_ptr<const vision::ToneModel> gaussian_of(const Reader& reader, const toml::table& table) {
  reader.only(table, {"model", "weight", "noise", "mean", "covariance"});
  GaussianTone::Parameters p;
  p.noise = reader.number(reader.need(table, "noise"), 0, 50);
  const auto mean = reader.numbers(reader.need(table, "mean"), 3, -10, 10);
  const auto& rows = reader.need(table, "covariance");
  if (!rows.is_array() || rows.as_array()->size() != 3) reader.refuse(rows, "is not three rows of numbers");
  for (int i = 0; i < 3; ++i) {
    p.mean[i] = mean[std::size_t(i)];
    const auto row = reader.numbers(*rows.as_array()->get(std::size_t(i)), 3, -10, 10);
    for (int j = 0; j < 3; ++j) p.covariance(i, j) = row[std::size_t(j)];
  }
  return std::make_shared<GaussianTone>(p);
}

std::shared_ptr<const vision::ToneModel> histogram_of(const Reader& reader, const toml::table& table) {
  reader.only(table, {"model", "weight", "noise", "smoothing", "value", "cells"});
  HistogramTone::Parameters p;
  p.noise = reader.number(reader.need(table, "noise"), 0, 50);
  p.smoothing = reader.number(reader.need(table, "smoothing"), 0.005, 0.5);
  const auto value = reader.numbers(reader.need(table, "value"), 2, -10, 10);
  p.value = {value[0], value[1]};
  p.weights.assign(std::size_t(HistogramTone::kCells) * HistogramTone::kCells, 0.0F);
  const auto& cells = reader.need(table, "cells");
  if (!cells.is_array()) reader.refuse(cells, "is no list of cells");
  for (const auto& cell : *cells.as_array()) {
    if (!cell.is_array() || cell.as_array()->size() != 3) reader.refuse(cell, "is not [column, row, weight]");
    const auto& three = *cell.as_array();
    const auto column = std::size_t(reader.whole(three[0], 0, HistogramTone::kCells - 1));
    const auto row = std::size_t(reader.whole(three[1], 0, HistogramTone::kCells - 1));
    p.weights[row * HistogramTone::kCells + column] = static_cast<float>(reader.number(three[2], 0, 1e11));
  }
  return std::make_shared<HistogramTone>(std::move(p));
}

vision::Tone::Part part_of(const Reader& reader, const toml::table& table) {
  vision::Tone::Part part;
  const auto& weight = reader.need(table, "weight");
  part.weight = reader.number(weight, 1e-6, 1e6);
  const auto& model = reader.need(table, "model");
  try {
    switch (vision::tone_kind_named(reader.text(model))) {
      case vision::ToneKind::kGaussian:
        part.model = gaussian_of(reader, table);
        break;
      case vision::ToneKind::kHistogram:
        part.model = histogram_of(reader, table);
        break;
    }
  } catch (const Error& error) {
    if (!error.where().empty()) throw;
    throw usage_error(error.what(), reader.place(table), error.hint());
  }
  return part;
}

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string text_of(const GaussianTone::Parameters& p) {
  std::string out =
      fmt::format("noise = {}\nmean = [{}, {}, {}]\ncovariance = [\n", p.noise, p.mean[0], p.mean[1], p.mean[2]);
  for (int i = 0; i < 3; ++i) {
    out += fmt::format("  [{}, {}, {}],\n", p.covariance(i, 0), p.covariance(i, 1), p.covariance(i, 2));
  }
  return out + "]\n";
}

std::string text_of(const HistogramTone::Parameters& p) {
  std::string out = fmt::format("noise = {}\nsmoothing = {}\nvalue = [{}, {}]\ncells = [\n", p.noise, p.smoothing,
                                p.value.mean, p.value.deviation);
  for (std::size_t i = 0; i < p.weights.size(); ++i) {
    if (p.weights[i] == 0) continue;
    out += fmt::format("  [{}, {}, {}],\n", i % HistogramTone::kCells, i / HistogramTone::kCells, p.weights[i]);
  }
  return out + "]\n";
}

}  // namespace

vision::ToneSet parse_tones(std::string_view text, const std::string& name) {
  toml::table table;
  try {
    table = toml::parse(text, std::string_view(name));
  } catch (const toml::parse_error& error) {
    throw usage_error(std::string(error.description()),
                      fmt::format("{}:{}:{}", name, error.source().begin.line, error.source().begin.column), kWhatItIs);
  }
  const Reader reader(name);
  const auto* version = table.get("choreoscope_tones");
  if (version == nullptr) throw usage_error("is no tones file", name + ":1", kWhatItIs);
  const int of = reader.whole(*version, 1, std::numeric_limits<int>::max());
  if (of > kTonesVersion) {
    reader.refuse(
        *version, fmt::format("is a tones file of version {}, later than this program", of),
        fmt::format("this program reads version {}; train again, or take a later choreoscope", kTonesVersion));
  }
  reader.only(table, {"choreoscope_tones", "count", "outliers", "tone"});
  vision::ToneSet set;
  set.outliers = reader.number(reader.need(table, "outliers"), 0.001, 1000);
  const auto count = std::size_t(reader.whole(reader.need(table, "count"), 1, int(kMostTones)));
  for (const auto* each : reader.tables(table, "tone", count)) {
    reader.only(*each, {"name", "prior", "parts", "part"});
    vision::Tone tone;
    const auto& called = reader.need(*each, "name");
    tone.name = reader.text(called);
    tone.prior = reader.number(reader.need(*each, "prior"), 0.001, 1000);
    const auto parts = std::size_t(reader.whole(reader.need(*each, "parts"), 1, int(kMostParts)));
    for (const auto* part : reader.tables(*each, "part", parts)) tone.parts.push_back(part_of(reader, *part));
    set.tones.push_back(std::move(tone));
    try {
      set.validate();
    } catch (const Error& error) {
      throw usage_error(error.what(), reader.place(called), error.hint());
    }
  }
  return set;
}

vision::ToneSet load_tones(const std::filesystem::path& path) {
  return parse_tones(read_text_file(path, kMostTonesBytes, "tones file"), path.string());
}

std::string print_tones(const vision::ToneSet& tones, const std::string& made_by) {
  std::string out = fmt::format("# Made by {}\nchoreoscope_tones = {}\ncount = {}\noutliers = {}\n", one_line(made_by),
                                kTonesVersion, tones.tones.size(), tones.outliers);
  for (const auto& tone : tones.tones) {
    out += fmt::format("\n[[tone]]\nname = {}\nprior = {}\nparts = {}\n", in_quotes(tone.name), tone.prior,
                       tone.parts.size());
    for (const auto& part : tone.parts) {
      out += "\n[[tone.part]]\n";
      if (const auto* gaussian = dynamic_cast<const GaussianTone*>(part.model.get())) {
        out += fmt::format("model = \"gaussian\"\nweight = {}\n{}", part.weight, text_of(gaussian->parameters()));
      } else if (const auto* histogram = dynamic_cast<const HistogramTone*>(part.model.get())) {
        out += fmt::format("model = \"histogram\"\nweight = {}\n{}", part.weight, text_of(histogram->parameters()));
      }
    }
  }
  return out;
}

}  // namespace choreo::config

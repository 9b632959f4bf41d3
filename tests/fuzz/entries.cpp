// SPDX-License-Identifier: Apache-2.0
#include "fuzz/entries.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "config/colour_table.hpp"
#include "config/config.hpp"
#include "config/schema.hpp"
#include "config/tones_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/time.hpp"
#include "devices/kinect_dump/dump_index.hpp"
#include "devices/openni2/protocol.hpp"
#include "devices/source_uri.hpp"
#include "devices/synthetic/synthetic_source.hpp"
#include "devices/take/take_format.hpp"
#include "pipeline/background.hpp"
#include "pipeline/frame_selection.hpp"
#include "vision/network/tflite_reader.hpp"

namespace choreo::fuzz {
namespace {

void promise(bool kept, const std::string& what) {
  if (!kept) throw std::logic_error("a promise is broken: " + what);
}

void promise_one_line(const std::string& text, const std::string& what) {
  const bool one = std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
  promise(one && is_utf8(text), what + " is one line that can be printed");
}

// Runs `parse` and says whether it accepted; an Error must be one that can be shown to the user.
template <typename Parse>
bool accepted(Parse parse) {
  try {
    parse();
    return true;
  } catch (const Error& error) {
    promise(error.fault() == Fault::kUsage, "a text that cannot be read is the user's mistake");
    promise(std::string_view(error.what()) != "", "a message says something");
    promise_one_line(error.what(), "what");
    promise_one_line(error.where(), "where");
    promise_one_line(error.hint(), "hint");
    return false;
  }
}

void promise_round_trip(const config::Config& config) {
  config.options().mask.validate();
  (void)pipeline::parse_background(config.options().background);
  config::Config again;
  again.load_text(config.show(), "shown.toml");
  for (const auto& field : config::schema()) {
    promise(field.print(again.options()) == field.print(config.options()), field.key + " reads back the same");
  }
}

}  // namespace

void config(std::string_view text) {
  static const auto untouched = config::Config().show();
  for (const bool file : {true, false}) {
    config::Config config;
    const bool good = accepted([&] { file ? config.load_text(text, "fuzz.toml") : config.set(text); });
    const bool changed = config.show() != untouched;
    promise(good || !changed, "what is refused changes nothing");
    if (changed) promise_round_trip(config);
  }
}

void openni2_message(std::string_view bytes) {
  const std::vector<std::uint8_t> sent(bytes.begin(), bytes.end());
  try {
    promise(devices::openni2::encode(devices::openni2::decode(sent)) == sent, "a message is written as it was read");
  } catch (const devices::openni2::BadMessage&) {
  }
}

void source_uri(std::string_view text) {
  using devices::parse_source_uri;
  devices::SourceUri uri;
  // Once as if nothing existed, once as if some paths did.
  (void)accepted([&] { (void)parse_source_uri(text, [](const std::string& path) { return path.size() % 3 == 1; }); });
  if (!accepted([&] { uri = parse_source_uri(text, [](const std::string&) { return false; }); })) return;
  promise(uri.text == text || uri.text == devices::without_password(text), "the source is kept as it was written");
  promise(devices::without_password(devices::without_password(text)) == devices::without_password(text),
          "what hides a password leaves none to hide");
  promise(!uri.location.empty() || uri.scheme == "freenect" || uri.scheme == "openni2", "a source is somewhere");
  promise(uri.location.find('\0') == std::string::npos, "no NUL byte comes to the operating system");
  for (const auto& [key, value] : uri.settings) {
    promise(!key.empty(), "a setting has a name");
    promise((key + value).find('\0') == std::string::npos, "no NUL byte comes from a setting");
  }
  (void)accepted([&] {
    devices::SettingReader reader(uri);
    static const std::vector<std::string> kTurns = {"0", "90", "180", "270"};
    const auto turn = reader.take_choice("rotate", "0", kTurns);
    promise(std::find(kTurns.begin(), kTurns.end(), turn) != kTurns.end(), "a choice is one of those offered");
    const auto fps = reader.take_number("fps", 30, 0.01, 1000);
    promise(fps >= 0.01 && fps <= 1000, "a number is in its range");
    const auto n = reader.take_integer("seed", 1, -3, 1000);
    promise(n >= -3 && n <= 1000, "a whole number is in its range");
    (void)reader.take_flag("loop", false);
    (void)reader.take_text("text", "");
    reader.refuse_the_rest();
  });
  (void)accepted([&] {
    const auto request = devices::performer_request(uri);
    request.settings.validate();
    promise(request.settings.size.width >= 16 && request.settings.size.width <= 3840, "a width that can be drawn");
    promise(!request.script.empty(), "a script that is known");
  });
}

void tflite(std::string_view bytes) {
  accepted([&] {
    const auto graph = vision::read_tflite({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    std::vector<bool> known(graph.tensors.size(), false);
    std::size_t numbers = 0;
    for (const auto& tensor : graph.tensors) {
      numbers += tensor.count();
      promise(tensor.constant.empty() || tensor.constant.size() == tensor.count(), "weights fill their shape");
    }
    known.at(std::size_t(graph.input)) = true;
    for (const auto& node : graph.nodes) {
      const bool weighed = node.operation == vision::NetworkOperation::kConvolution ||
                           node.operation == vision::NetworkOperation::kDepthwise;
      for (std::size_t k = 0; k < node.inputs.size(); ++k) {
        const auto input = std::size_t(node.inputs[k]);
        promise(weighed && k > 0 ? !graph.tensors.at(input).constant.empty() : bool(known.at(input)),
                "what is read was computed before");
      }
      promise(!known.at(std::size_t(node.output)), "nothing is computed twice");
      known.at(std::size_t(node.output)) = true;
    }
    promise(!graph.outputs.empty(), "something comes out");
    promise(numbers <= std::size_t{1} << 26U, "memory holds it");
    for (const auto& output : graph.outputs) {
      for (const int k : output.parts) promise(known.at(std::size_t(k)), "what comes out was computed");
    }
  });
}

void take(std::string_view text) {
  using namespace devices::take;
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  if (const auto stamp = stamp_of(bytes)) {
    const auto again = bytes_of(*stamp);
    promise(std::equal(again.begin(), again.end(), bytes.begin()), "a stamp is written as it was read");
  }
  for (const auto& mark : marks_of(text)) {
    const auto again = marks_of(line_of(mark));
    promise(again.size() == 1 && again[0].kind == mark.kind && again[0].sequence == mark.sequence,
            "a mark is written as it was read");
  }
  std::map<std::string, std::string, std::less<>> tags;
  for (auto rest = text; !rest.empty();) {
    const auto line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    const auto equals = line.find('=');
    if (equals != std::string_view::npos) tags[std::string(line.substr(0, equals))] = line.substr(equals + 1);
  }
  const auto finder = [](const auto& all) {
    return [&all](const char* name) {
      const auto at = all.find(name);
      return at == all.end() ? std::nullopt : std::optional<std::string>(at->second);
    };
  };
  if (const auto facts = file_facts(finder(tags))) {
    const auto written = tags_of(*facts);
    const std::map<std::string, std::string, std::less<>> again(written.begin(), written.end());
    const auto read = file_facts(finder(again));
    promise(read && read->nominal_fps == facts->nominal_fps, "a rate is written as it was read");
  }
  if (const auto facts = stream_facts(finder(tags))) {
    promise(facts->size.width >= 1 && facts->size.width <= 16384, "a width that can be held");
    promise(facts->size.height >= 1 && facts->size.height <= 16384, "a height that can be held");
    const auto written = tags_of(*facts);
    const std::map<std::string, std::string, std::less<>> again(written.begin(), written.end());
    const auto read = stream_facts(finder(again));
    promise(read && read->size == facts->size && read->fourcc == facts->fourcc && read->raw == facts->raw,
            "a track is written as it was read");
  }
}

void texts(std::string_view text) {
  (void)accepted([&] {
    const auto span = pipeline::parse_span(text);
    promise(span.from >= Nanoseconds{0} && span.from < span.to, "a span in seconds holds something");
    promise(span.first_frame >= 1 && span.first_frame <= span.last_frame, "a span in frames holds something");
    promise(span.every == 1, "a span says nothing of every");
  });
  (void)accepted([&] {
    const auto duration = parse_duration(text);
    promise(duration >= Nanoseconds{0} && duration <= std::chrono::hours(1000), "a duration is in its range");
  });
  (void)accepted([&] {
    const auto background = pipeline::parse_background(text);
    using Kind = pipeline::BackgroundSpec::Kind;
    promise((background.kind == Kind::kFirst) == (background.first > Nanoseconds{0}), "first:T has a T above 0");
    promise((background.kind == Kind::kPlate) == !background.plate.empty(), "a plate has a path");
  });
}

void kinect_index(std::string_view text) {
  using namespace devices::kinect_dump;
  Index index;
  const bool looks = looks_like_index(text);
  if (!accepted([&] { index = parse_index(text, "INDEX.txt"); })) return;
  promise(looks || text.find('\n') == std::string_view::npos, "what is accepted looks like it");
  for (const auto* stream : {&index.colour, &index.depth}) {
    Nanoseconds last{-1};
    for (const auto& picture : *stream) {
      promise(picture.name.find('/') == std::string::npos, "a name stays in its folder");
      promise(picture.name.find('\0') == std::string::npos, "no NUL byte comes to the operating system");
      promise(picture.time > last, "times increase");
      last = picture.time;
    }
  }
  std::optional<std::pair<std::size_t, std::size_t>> before;
  for (const auto& pair : pairs_by_time(index)) {
    promise(!before || (pair.first > before->first && pair.second > before->second), "no picture is in two pairs");
    const auto apart = index.colour.at(pair.first).time - index.depth.at(pair.second).time;
    promise(std::chrono::abs(apart) <= kPairWithin, "a pair is of one moment");
    before = pair;
  }
}

void tones(std::string_view text) {
  vision::ToneSet set;
  if (!accepted([&] { set = config::parse_tones(text, "fuzz.toml"); })) return;
  promise(!set.tones.empty(), "there are tones");
  set.validate();
  const auto printed = config::print_tones(set, "fuzz");
  promise(config::print_tones(config::parse_tones(printed, "printed.toml"), "fuzz") == printed, "tones read back");
  for (const double level : {0.0, 90.0, 255.0}) {
    for (const double p : set.posteriors(vision::tone_colour({level, 0.5 * level, 255 - level}))) {
      promise(p >= 0 && p <= 1, "a posterior is a probability");
    }
  }
}

void colours(std::string_view text) {
  std::string columns;
  if (text.starts_with("!")) {
    columns = text.substr(1, text.find('\n') - 1);
    text.remove_prefix(std::min(text.size(), columns.size() + 2));
  }
  config::ColourTable table;
  if (!accepted([&] { table = config::parse_colour_table(text, "fuzz.csv", columns); })) return;
  promise(!table.bgr.empty(), "there are colours");
  promise(table.bgr.size() == table.label.size(), "each colour has its label");
}

}  // namespace choreo::fuzz

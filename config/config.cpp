// SPDX-License-Identifier: Apache-2.0
#include "config/config.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "config/schema.hpp"
#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::config {
namespace {

constexpr std::uintmax_t kMostConfigBytes = 1U << 20;

const Field* find(const std::string& key) {
  const auto& fields = schema();
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.key == key; });
  return found == fields.end() ? nullptr : &*found;
}

bool is_section(const std::string& name) {
  const auto& fields = schema();
  return std::any_of(fields.begin(), fields.end(), [&](const Field& f) { return f.key.starts_with(name + "."); });
}

std::vector<std::string> known_keys() {
  std::vector<std::string> keys;
  for (const auto& field : schema()) keys.push_back(field.key);
  return keys;
}

[[noreturn]] void refuse_key(const std::string& key, const std::string& where) {
  const auto what = fmt::format("unknown setting \"{}\"", shortened(key));
  auto keys = known_keys();
  if (const auto near = nearest_name(key, keys)) {
    throw usage_error(what, where, fmt::format("did you mean \"{}\"?", *near));
  }
  // A key may be right and its section wrong or missing.
  const auto last = key.substr(key.rfind('.') + 1);
  for (const auto& known : keys) {
    const auto name = known.substr(known.rfind('.') + 1);
    const auto most = last.size() / 4;
    // What is much longer is not compared: it may be a megabyte.
    if (last.size() > name.size() + most || edit_distance(name, last) > most) continue;
    throw usage_error(what, where, fmt::format("did you mean \"{}\"?", known));
  }
  throw usage_error(what, where, "`choreoscope config show` lists every setting");
}

std::string written(const toml::node& node) {
  std::ostringstream out;
  if (const auto* s = node.as_string()) return "\"" + shortened(s->get()) + "\"";
  node.visit([&](const auto& value) { out << value; });
  auto text = out.str();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return shortened(text);
}

void apply(Options& options, const Field& field, const toml::node& node, const std::string& where) {
  if (field.set(options, node)) return;
  throw usage_error(fmt::format("{} is {}", field.key, written(node)), where,
                    fmt::format("{} is {}", field.key, field.range));
}

std::string place(const std::string& name, const toml::source_region& source) {
  return fmt::format("{}:{}:{}", name, source.begin.line, source.begin.column);
}

}  // namespace

void Config::load_file(const std::filesystem::path& path) {
  const auto name = path.string();
  std::error_code problem;
  const auto status = std::filesystem::status(path, problem);
  if (status.type() == std::filesystem::file_type::not_found) {
    throw usage_error("no such configuration file", name, "`choreoscope config show` prints one");
  }
  if (std::filesystem::is_directory(status)) throw usage_error("is a folder, not a configuration file", name);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw usage_error("the configuration file cannot be read", name);
  std::string text;
  // Read, not asked for: a pipe has no size.
  std::vector<char> buffer(kMostConfigBytes + 1);
  file.read(buffer.data(), std::streamsize(buffer.size()));
  text.assign(buffer.data(), std::size_t(file.gcount()));
  if (file.bad()) throw usage_error("the configuration file cannot be read", name);
  if (text.size() > kMostConfigBytes) throw usage_error("is larger than 1 MiB: no configuration file", name);
  load_text(text, name);
}

void Config::load_text(std::string_view text, const std::string& name) {
  toml::table table;
  try {
    table = toml::parse(text, std::string_view(name));
  } catch (const toml::parse_error& error) {
    throw usage_error(std::string(error.description()), place(name, error.source()),
                      "the file is not TOML; write key = value under [section] headings");
  }
  auto options = options_;
  auto origins = origins_;
  for (const auto& [section_key, section_node] : table) {
    const std::string section(section_key.str());
    if (const auto* field = find(section)) {
      apply(options, *field, section_node, place(name, section_node.source()));
      origins[section] = fmt::format("{}:{}", name, section_node.source().begin.line);
      continue;
    }
    const auto* section_table = section_node.as_table();
    if (section_table == nullptr || !is_section(section)) {
      if (section_table != nullptr) {
        // Name the setting inside: its section is what is mistyped or missing.
        for (const auto& [key, node] : *section_table) {
          refuse_key(section + "." + std::string(key.str()), place(name, key.source()));
        }
      }
      refuse_key(section, place(name, section_key.source()));
    }
    for (const auto& [key, node] : *section_table) {
      const auto full = section + "." + std::string(key.str());
      const auto* field = find(full);
      if (field == nullptr) refuse_key(full, place(name, key.source()));
      apply(options, *field, node, place(name, node.source()));
      origins[full] = fmt::format("{}:{}", name, node.source().begin.line);
    }
  }
  options_ = std::move(options);
  origins_ = std::move(origins);
}

void Config::set(std::string_view assignment, const std::string& option) {
  const auto equals = assignment.find('=');
  const auto where = fmt::format("{} {}", option, shortened(assignment));
  if (equals == std::string_view::npos || equals == 0) {
    throw usage_error("is not of the form key=value", where, "for instance --set mask.steps=3");
  }
  const std::string key(assignment.substr(0, equals));
  const auto value = assignment.substr(equals + 1);
  const auto* field = find(key);
  if (field == nullptr) refuse_key(key, where);
  if (value.find('\n') == std::string_view::npos) {
    try {
      const auto table = toml::parse(fmt::format("value = {}", value));
      if (table.size() == 1 && table.contains("value")) {
        apply(options_, *field, *table.get("value"), where);
        origins_[key] = option;
        return;
      }
    } catch (const toml::parse_error&) {
      // Not a TOML value; perhaps a bare word.
    }
  }
  if (!field->text) {
    throw usage_error(fmt::format("{} is \"{}\"", key, shortened(value)), where,
                      fmt::format("{} is {}", key, field->range));
  }
  apply(options_, *field, toml::value<std::string>(std::string(value)), where);
  origins_[key] = option;
}

void Config::set_text(const std::string& key, const std::string& value, const std::string& option) {
  const auto* field = find(key);
  apply(options_, *field, toml::value<std::string>(value), option);
  origins_[key] = option;
}

std::string Config::origin(const std::string& key) const {
  const auto found = origins_.find(key);
  return found == origins_.end() ? "default" : found->second;
}

std::string Config::show() const {
  std::string out;
  std::string section;
  for (const auto& field : schema()) {
    const auto dot = field.key.find('.');
    const auto here = dot == std::string::npos ? "" : field.key.substr(0, dot);
    if (here != section) {
      out += fmt::format("{}[{}]\n", out.empty() ? "" : "\n", here);
      section = here;
    }
    out += fmt::format("# {}\n# {}\n", field.help, field.range);
    const auto name = dot == std::string::npos ? field.key : field.key.substr(dot + 1);
    out += fmt::format("{} = {}  # {}\n", name, field.print(options_), one_line(origin(field.key)));
  }
  return out;
}

std::string Config::values() const {
  std::string out;
  for (const auto& field : schema()) out += fmt::format("{} = {}\n", field.key, field.print(options_));
  return out;
}

namespace {

std::map<std::string, std::string> values_by_key(std::string_view lines) {
  std::map<std::string, std::string> values;
  while (!lines.empty()) {
    const auto line = lines.substr(0, lines.find('\n'));
    lines.remove_prefix(std::min(lines.size(), line.size() + 1));
    const auto sign = line.find(" = ");
    if (sign != std::string_view::npos) values.emplace(line.substr(0, sign), line.substr(sign + 3));
  }
  return values;
}

}  // namespace

std::string differing(std::string_view was, std::string_view is) {
  const auto before = values_by_key(was);
  std::string out;
  for (const auto& [key, value] : values_by_key(is)) {
    const auto old = before.find(key);
    if (old == before.end() || old->second == value || key.starts_with("plot.")) continue;
    out += fmt::format("{}{} was {} and is {}", out.empty() ? "" : ", ", key, one_line(old->second), value);
  }
  return out;
}

}  // namespace choreo::config

// SPDX-License-Identifier: Apache-2.0
#include "config/field_kinds.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"

namespace choreo::config {

std::optional<double> number_of(const toml::node& node) {
  if (const auto* value = node.as_floating_point()) {
    const double number = value->get();
    if (!std::isfinite(number)) return std::nullopt;
    return std::fpclassify(number) == FP_SUBNORMAL ? 0.0 : number + 0.0;
  }
  if (const auto* value = node.as_integer()) return double(value->get());
  return std::nullopt;
}

std::string toml_string(const std::string& text) {
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

std::optional<std::vector<double>> numbers_of(const toml::node& node) {
  const auto* array = node.as_array();
  if (array == nullptr) return std::nullopt;
  std::vector<double> numbers;
  for (const auto& item : *array) {
    const auto value = number_of(item);
    if (!value) return std::nullopt;
    numbers.push_back(*value);
  }
  return numbers;
}

std::optional<std::string> text_of(const toml::node& node, const std::function<bool(const std::string&)>& fits) {
  const auto* value = node.as_string();
  if (value == nullptr || !is_utf8(value->get()) || !fits(value->get())) return std::nullopt;
  return value->get();
}

std::function<bool(const std::string&)> one_of(std::vector<std::string> choices) {
  return [choices = std::move(choices)](const std::string& s) {
    return std::find(choices.begin(), choices.end(), s) != choices.end();
  };
}

}  // namespace choreo::config

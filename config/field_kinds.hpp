// SPDX-License-Identifier: Apache-2.0
// The kinds of settings: how a number, a choice, a path or a zone is read, checked and printed.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "config/schema.hpp"

namespace choreo::config {

/// A finite number; nothing for what is none. Integers are numbers too: 2 may stand for 2.0. There is no negative zero,
/// which would read back as another text, nor numbers so small that they would not read back at all.
[[nodiscard]] std::optional<double> number_of(const toml::node& node);
/// A list of numbers; nothing for what is none.
[[nodiscard]] std::optional<std::vector<double>> numbers_of(const toml::node& node);
/// A text as TOML would have it.
[[nodiscard]] std::string toml_string(const std::string& text);
/// Whether a text is valid UTF-8 and says yes to `fits`; nothing where it is no text.
[[nodiscard]] std::optional<std::string> text_of(const toml::node& node,
                                                 const std::function<bool(const std::string&)>& fits);
[[nodiscard]] std::function<bool(const std::string&)> one_of(std::vector<std::string> choices);

/// From `least` to `most`.
struct Range {
  double least;
  double most;
  bool open_below = false;  ///< The least value itself is not allowed.
  [[nodiscard]] bool holds(double x) const { return (open_below ? x > least : x >= least) && x <= most; }
};

// In all kinds `at` gives the place of the value in the options.
template <typename At>
Field number(std::string key, At at, Range range, std::string range_text, std::string help) {
  return {std::move(key),
          std::move(range_text),
          std::move(help),
          false,
          [=](Options& o, const toml::node& node) {
            const auto value = number_of(node);
            if (!value || !range.holds(*value)) return false;
            at(o) = *value;
            return true;
          },
          [=](const Options& o) { return fmt::format("{}", at(const_cast<Options&>(o))); }};
}

template <typename At>
Field number_or_auto(std::string key, At at, Range range, std::string range_text, std::string help) {
  return {std::move(key),
          std::move(range_text),
          std::move(help),
          true,
          [=](Options& o, const toml::node& node) {
            if (const auto* word = node.as_string()) {
              if (word->get() != "auto") return false;
              at(o) = std::nullopt;
              return true;
            }
            const auto value = number_of(node);
            if (!value || !range.holds(*value)) return false;
            at(o) = *value;
            return true;
          },
          [=](const Options& o) {
            const auto& value = at(const_cast<Options&>(o));
            return value ? fmt::format("{}", *value) : std::string("\"auto\"");
          }};
}

template <typename At>
Field integer(std::string key, At at, int least, int most, std::string range_text, std::string help) {
  return {std::move(key),
          std::move(range_text),
          std::move(help),
          false,
          [=](Options& o, const toml::node& node) {
            const auto* value = node.as_integer();
            if (value == nullptr || value->get() < least || value->get() > most) return false;
            at(o) = static_cast<int>(value->get());
            return true;
          },
          [=](const Options& o) { return fmt::format("{}", at(const_cast<Options&>(o))); }};
}

template <typename At>
Field flag(std::string key, At at, std::string help) {
  return {std::move(key),
          "true or false",
          std::move(help),
          false,
          [=](Options& o, const toml::node& node) {
            const auto* value = node.as_boolean();
            if (value == nullptr) return false;
            at(o) = value->get();
            return true;
          },
          [=](const Options& o) { return std::string(at(const_cast<Options&>(o)) ? "true" : "false"); }};
}

template <typename At>
Field text(std::string key, At at, std::function<bool(const std::string&)> fits, std::string range_text,
           std::string help) {
  return {std::move(key),
          std::move(range_text),
          std::move(help),
          true,
          [=, fits = std::move(fits)](Options& o, const toml::node& node) {
            auto value = text_of(node, fits);
            if (!value) return false;
            at(o) = *std::move(value);
            return true;
          },
          [=](const Options& o) { return toml_string(at(const_cast<Options&>(o))); }};
}

}  // namespace choreo::config

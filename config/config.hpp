// SPDX-License-Identifier: Apache-2.0
// From TOML files and `--set key=value` to typed options, with the origin of every value.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "config/options.hpp"

namespace choreo::config {

/// Options and where each of their values came from.
///
/// Later calls override earlier ones. Every error is usage_error with file:line:column (or the option) and a hint that
/// names the nearest key or the range.
class Config {
 public:
  /// Reads a TOML file of at most 1 MiB.
  void load_file(const std::filesystem::path& path);

  /// Reads TOML text; `name` stands in messages and origins.
  void load_text(std::string_view text, const std::string& name);

  /// Takes one `key=value`; a bare word will do where the setting is a text.
  /// @param option  stands in messages and origins.
  void set(std::string_view assignment, const std::string& option = "--set");

  /// Sets a value that a command line option of its own gives.
  void set_text(const std::string& key, const std::string& value, const std::string& option);

  [[nodiscard]] const Options& options() const { return options_; }

  /// "default", "stage.toml:3" or "--set".
  [[nodiscard]] std::string origin(const std::string& key) const;

  /// Every setting as commented TOML with its origin; reads back as the same configuration.
  [[nodiscard]] std::string show() const;

  /// The same bare: "mask.threshold = 18" and a line end for every setting.
  [[nodiscard]] std::string values() const;

 private:
  Options options_;
  std::map<std::string, std::string> origins_;
};

/// How the settings that decide on results differ, those of plots and windows aside.
/// @param was, is  as of `Config::values`, perhaps of another version: what only one of them has is left alone.
/// @return "mask.threshold was 18 and is 20, mask.steps was 1 and is 2"; empty where they are the same.
[[nodiscard]] std::string differing(std::string_view was, std::string_view is);

}  // namespace choreo::config

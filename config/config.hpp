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

 private:
  Options options_;
  std::map<std::string, std::string> origins_;
};

}  // namespace choreo::config

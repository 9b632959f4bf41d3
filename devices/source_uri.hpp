// SPDX-License-Identifier: Apache-2.0
// How a SOURCE is written: a path or URI with settings behind a question mark.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace choreo::devices {

/// A SOURCE taken apart: `scheme://location?key=value&key=value`, or a path with the same settings behind it.
struct SourceUri {
  std::string text;    ///< As the user wrote it, of an address `without_password`: it stands in messages and files.
  std::string scheme;  ///< Lower case; empty for a plain path.
  /// Path or address, percent-decoded where there is a scheme; empty only for freenect:// and openni2://, any device.
  std::string location;
  std::map<std::string, std::string, std::less<>> settings;
};

/// The text with "***" in place of what nobody else should read: the password in "rtsp://user:password@host" and the
/// values of settings behind a question mark that are called password, pwd, token, key and the like.
[[nodiscard]] std::string without_password(std::string_view text);

/// Takes a SOURCE apart. A path that exists as written is a path, whatever characters its name contains. Of a network
/// address (http, rtsp, ...) only rotate, flip, patience and silence are taken out, of rtsp also transport and listen;
/// the rest belongs to the server.
/// @param exists  says whether a path exists.
/// @throws Error (usage) on an empty text, a NUL byte, a malformed setting or one given twice.
[[nodiscard]] SourceUri parse_source_uri(std::string_view text, bool (*exists)(const std::string& path));

/// Reads a SOURCE's settings one by one and refuses what nobody asked for.
///
/// Every take_ function removes its key, returns the fallback where it is absent, and throws Error (usage) with the
/// allowed range where the value does not fit.
class SettingReader {
 public:
  explicit SettingReader(const SourceUri& uri) : text_(uri.text), settings_(uri.settings) {}

  [[nodiscard]] double take_number(const std::string& key, double fallback, double least, double most);
  [[nodiscard]] long long take_integer(const std::string& key, long long fallback, long long least, long long most);
  [[nodiscard]] bool take_flag(const std::string& key, bool fallback);  ///< 1, true, yes, on; 0, false, no, off.
  [[nodiscard]] std::string take_choice(const std::string& key, std::string fallback,
                                        std::span<const std::string> choices);
  [[nodiscard]] std::string take_text(const std::string& key, std::string fallback);

  /// All that no other take_ function has asked for: settings whose names only the device knows.
  [[nodiscard]] std::map<std::string, std::string> take_rest();

  /// @throws Error (usage) where a setting was given that no take_ function asked for, naming the nearest known one.
  void refuse_the_rest() const;

 private:
  std::optional<std::string> take(const std::string& key);

  std::string text_;
  std::map<std::string, std::string, std::less<>> settings_;
  std::vector<std::string> known_;
};

}  // namespace choreo::devices

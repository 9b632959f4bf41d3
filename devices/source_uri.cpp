// SPDX-License-Identifier: Apache-2.0
#include "devices/source_uri.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::devices {
namespace {

constexpr std::string_view kHowToWrite =
    "write a path or URI with settings behind a question mark, such as clip.mkv?rotate=90 or "
    "synthetic://walking?seed=2";

// What the server behind such an address does with its query is its own business.
constexpr std::array<std::string_view, 9> kNetworkSchemes = {"http", "https", "rtsp", "rtsps", "rtmp",
                                                             "srt",  "udp",   "tcp",  "rtp"};
constexpr std::array<std::string_view, 4> kOwnSettings = {"rotate", "flip", "patience", "silence"};
constexpr std::array<std::string_view, 2> kOwnRtspSettings = {"transport", "listen"};
constexpr std::array<std::string_view, 8> kSecrets = {"password", "passwd", "pass",   "pwd",
                                                      "token",    "key",    "secret", "auth"};

template <std::size_t N>
bool is_among(std::string_view name, const std::array<std::string_view, N>& names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string in_lower_case(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

// Of these, no place means the first device there is.
constexpr std::array<std::string_view, 2> kFirstOfSchemes = {"freenect", "openni2"};

bool may_name_no_place(std::string_view scheme) {
  return std::find(kFirstOfSchemes.begin(), kFirstOfSchemes.end(), scheme) != kFirstOfSchemes.end();
}

bool is_scheme(std::string_view s) {
  // One letter is not a scheme, as "c:clip.mkv" is a file name.
  return s.size() > 1 && std::isalpha(static_cast<unsigned char>(s[0])) != 0 &&
         std::all_of(s.begin(), s.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '+' || c == '-' || c == '.'; });
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string percent_decoded(std::string_view text, std::string_view whole) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    const int high = i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
    const int low = i + 2 < text.size() ? hex_digit(text[i + 2]) : -1;
    const int value = high * 16 + low;
    if (high < 0 || low < 0 || value == 0) {
      throw usage_error(fmt::format("source \"{}\": '%' stands before two hexadecimal digits other than 00", whole), {},
                        "write a percent sign itself as %25");
    }
    out += static_cast<char>(value);
    i += 2;
  }
  return out;
}

void parse_settings(SourceUri& uri, std::string_view query) {
  while (!query.empty()) {
    const auto end = std::min(query.find('&'), query.size());
    const auto item = query.substr(0, end);
    query.remove_prefix(std::min(end + 1, query.size()));
    if (item.empty()) continue;
    const auto equals = item.find('=');
    if (equals == std::string_view::npos || equals == 0) {
      throw usage_error(fmt::format("source \"{}\": setting \"{}\" is not of the form key=value", uri.text, item), {},
                        std::string(kHowToWrite));
    }
    auto key = percent_decoded(item.substr(0, equals), uri.text);
    auto value = percent_decoded(item.substr(equals + 1), uri.text);
    if (uri.settings.contains(key)) {
      throw usage_error(fmt::format("source \"{}\": setting \"{}\" is given twice", uri.text, key));
    }
    uri.settings.emplace(std::move(key), std::move(value));
  }
}

// Takes our own settings out of a network address and leaves the rest of its query in place.
void parse_network(SourceUri& uri, std::string_view address) {
  const auto question = address.find('?');
  uri.location = std::string(address.substr(0, question));
  if (question == std::string_view::npos) return;
  std::string ours;
  std::string theirs;
  auto query = address.substr(question + 1);
  while (!query.empty()) {
    const auto end = std::min(query.find('&'), query.size());
    const auto item = query.substr(0, end);
    query.remove_prefix(std::min(end + 1, query.size()));
    const auto key = item.substr(0, item.find('='));
    const bool own = is_among(key, kOwnSettings) || (uri.scheme.starts_with("rtsp") && is_among(key, kOwnRtspSettings));
    auto& kept = own ? ours : theirs;
    if (!kept.empty()) kept += '&';
    kept += item;
  }
  if (!theirs.empty()) uri.location += "?" + theirs;
  parse_settings(uri, ours);
}

// Up to where a word lasts in a message: addresses are often quoted.
constexpr std::string_view kEndOfAddress = " \t\r\n\"'<>";

// The values of settings that are called like secrets, of one address.
std::string without_secret_settings(std::string_view address) {
  auto at = address.find('?');
  if (at == std::string_view::npos) return std::string(address);
  std::string out(address.substr(0, ++at));
  address.remove_prefix(at);
  while (!address.empty()) {
    const auto end = std::min(address.find_first_of("&?#"), address.size());
    const auto item = address.substr(0, end);
    const auto equals = item.find('=');
    if (equals != std::string_view::npos && is_among(in_lower_case(item.substr(0, equals)), kSecrets)) {
      out += item.substr(0, equals + 1);
      out += "***";
    } else {
      out += item;
    }
    if (end < address.size()) out += address[end];
    address.remove_prefix(std::min(end + 1, address.size()));
  }
  return out;
}

}  // namespace

std::string without_password(std::string_view text) {
  std::string out;
  for (;;) {
    const auto begin = text.find("://");
    if (begin == std::string_view::npos) return out += text;
    out += text.substr(0, begin + 3);
    text.remove_prefix(begin + 3);
    const auto authority = text.substr(0, text.find_first_of("/?#"));
    const auto at = authority.rfind('@');
    const auto colon = at == std::string_view::npos ? at : authority.substr(0, at).find(':');
    if (colon != std::string_view::npos) {
      out += authority.substr(0, colon + 1);
      out += "***";
      text.remove_prefix(at);
    }
    const auto address = text.substr(0, std::min(text.find_first_of(kEndOfAddress), text.find("://")));
    out += without_secret_settings(address);
    text.remove_prefix(address.size());
  }
}

SourceUri parse_source_uri(std::string_view text, bool (*exists)(const std::string& path)) {
  SourceUri uri;
  uri.text = std::string(text);
  if (text.empty()) throw usage_error("the source is empty", {}, std::string(kHowToWrite));
  if (text.find('\0') != std::string_view::npos) throw usage_error("the source contains a NUL byte");

  if (exists(uri.text)) {
    uri.location = uri.text;
    return uri;
  }
  const std::string written(text);
  // The last question mark begins the settings: what stands before it may contain others. Where that is a path as
  // written, it is no URI, however much a colon in it looks like one.
  const auto question = text.rfind('?');
  if (question != std::string_view::npos && exists(written.substr(0, question))) {
    uri.location = written.substr(0, question);
    parse_settings(uri, text.substr(question + 1));
    return uri;
  }
  const auto colon = text.find(':');
  const bool has_scheme = colon != std::string_view::npos && is_scheme(text.substr(0, colon)) &&
                          text.substr(0, colon).find('/') == std::string_view::npos;
  auto rest = text;
  if (has_scheme) {
    uri.text = without_password(text);
    uri.scheme = in_lower_case(text.substr(0, colon));
    if (is_among(uri.scheme, kNetworkSchemes)) {
      // FFmpeg knows its protocols in lower case only.
      parse_network(uri, uri.scheme + written.substr(colon));
      return uri;
    }
    rest.remove_prefix(colon + 1);
    if (rest.starts_with("//")) rest.remove_prefix(2);
  }
  const auto settings_begin = rest.rfind('?');
  const auto location = rest.substr(0, settings_begin);
  uri.location = has_scheme ? percent_decoded(location, uri.text) : std::string(location);
  if (settings_begin != std::string_view::npos) parse_settings(uri, rest.substr(settings_begin + 1));
  if (uri.location.empty() && !may_name_no_place(uri.scheme)) {
    throw usage_error(fmt::format("source \"{}\" names no place", uri.text), {}, std::string(kHowToWrite));
  }
  return uri;
}

std::optional<std::string> SettingReader::take(const std::string& key) {
  known_.push_back(key);
  const auto found = settings_.find(key);
  if (found == settings_.end()) return std::nullopt;
  auto value = std::move(found->second);
  settings_.erase(found);
  return value;
}

double SettingReader::take_number(const std::string& key, double fallback, double least, double most) {
  const auto text = take(key);
  if (!text) return fallback;
  const auto value = parse_number(*text);
  if (!value || *value < least || *value > most) {
    throw usage_error(fmt::format("source \"{}\": {} is \"{}\"", text_, key, *text), {},
                      fmt::format("{} is a number from {} to {} (default {})", key, least, most, fallback));
  }
  return *value;
}

long long SettingReader::take_integer(const std::string& key, long long fallback, long long least, long long most) {
  const auto text = take(key);
  if (!text) return fallback;
  const auto value = parse_integer(*text);
  if (!value || *value < least || *value > most) {
    throw usage_error(fmt::format("source \"{}\": {} is \"{}\"", text_, key, *text), {},
                      fmt::format("{} is a whole number from {} to {} (default {})", key, least, most, fallback));
  }
  return *value;
}

bool SettingReader::take_flag(const std::string& key, bool fallback) {
  const auto text = take(key);
  if (!text) return fallback;
  if (*text == "1" || *text == "true" || *text == "yes" || *text == "on") return true;
  if (*text == "0" || *text == "false" || *text == "no" || *text == "off") return false;
  throw usage_error(fmt::format("source \"{}\": {} is \"{}\"", text_, key, *text), {},
                    fmt::format("{} is 1 or 0 (default {})", key, fallback ? 1 : 0));
}

std::string SettingReader::take_choice(const std::string& key, std::string fallback,
                                       std::span<const std::string> choices) {
  const auto text = take(key);
  if (!text) return fallback;
  if (std::find(choices.begin(), choices.end(), *text) == choices.end()) {
    throw usage_error(fmt::format("source \"{}\": {} is \"{}\"", text_, key, *text), {},
                      fmt::format("{} is one of {} (default {})", key, join(choices), fallback));
  }
  return *text;
}

std::string SettingReader::take_text(const std::string& key, std::string fallback) {
  return take(key).value_or(std::move(fallback));
}

std::map<std::string, std::string> SettingReader::take_rest() {
  std::map<std::string, std::string> rest(settings_.begin(), settings_.end());
  settings_.clear();
  return rest;
}

void SettingReader::refuse_the_rest() const {
  if (settings_.empty()) return;
  const auto& key = settings_.begin()->first;
  throw usage_error(fmt::format("source \"{}\": unknown setting \"{}\"", text_, key), {}, hint_for_name(key, known_));
}

}  // namespace choreo::devices

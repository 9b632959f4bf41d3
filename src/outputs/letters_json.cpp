// SPDX-License-Identifier: Apache-2.0
#include "outputs/letters_json.hpp"

#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace choreo::outputs {
namespace {

std::string json_text(std::string_view text) {
  return nlohmann::json(std::string(text)).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string quoted_or_null(std::string_view text) { return text.empty() ? "null" : json_text(text); }

}  // namespace

std::string letters_json(std::span<const recognition::HeldSign> signs, std::string_view text,
                         std::optional<double> since) {
  std::string json = "{\n  \"letters\": [";
  const char* before = "\n";
  for (const auto& s : signs) {
    if (s.sign == "REST") continue;
    fmt::format_to(std::back_inserter(json),
                   "{}    {{\"letter\": {}, \"from\": {:.3f}, \"to\": {:.3f}, \"confidence\": {:.3f}}}", before,
                   json_text(s.sign), s.from, s.to, s.confidence);
    before = ",\n";
  }
  if (*before == ',') json += "\n  ";
  json += "],\n  \"text\": " + json_text(text);
  if (since) fmt::format_to(std::back_inserter(json), ",\n  \"since\": {:.3f}", *since);
  return json + "\n}\n";
}

std::string pictures_json(std::span<const PictureReading> pictures) {
  std::string json = "{\n  \"pictures\": [";
  const char* before = "\n";
  for (const auto& p : pictures) {
    fmt::format_to(std::back_inserter(json),
                   "{}    {{\"file\": {}, \"letter\": {}, \"confidence\": {:.3f}, \"runner_up\": {}}}", before,
                   json_text(p.file), quoted_or_null(p.reading.sign.value_or("")), p.reading.confidence,
                   quoted_or_null(p.reading.runner_up));
    before = ",\n";
  }
  if (*before == ',') json += "\n  ";
  return json + "]\n}\n";
}

}  // namespace choreo::outputs

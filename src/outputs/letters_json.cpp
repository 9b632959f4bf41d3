// SPDX-License-Identifier: Apache-2.0
#include "outputs/letters_json.hpp"

#include <cmath>

#include <nlohmann/json.hpp>

namespace choreo::outputs {
namespace {

using Json = nlohmann::ordered_json;

double rounded(double value) { return std::round(value * 1000) / 1000; }

std::string text_of(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace

std::string letters_json(std::span<const ReadLetter> letters, std::string_view text) {
  Json json;
  json["letters"] = Json::array();
  for (const auto& l : letters) {
    json["letters"].push_back({{"letter", l.letter},
                               {"from", rounded(l.from)},
                               {"to", rounded(l.to)},
                               {"confidence", rounded(l.confidence)}});
  }
  json["text"] = text;
  return text_of(json);
}

std::string pictures_json(std::span<const ReadPicture> pictures) {
  Json json;
  json["pictures"] = Json::array();
  for (const auto& p : pictures) {
    json["pictures"].push_back({{"file", p.file},
                                {"letter", p.letter ? Json(*p.letter) : Json()},
                                {"confidence", rounded(p.confidence)},
                                {"runner_up", p.runner_up.empty() ? Json() : Json(p.runner_up)}});
  }
  return text_of(json);
}

}  // namespace choreo::outputs

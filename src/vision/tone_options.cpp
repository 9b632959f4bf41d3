// SPDX-License-Identifier: Apache-2.0
#include "vision/tone_options.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::vision {
namespace {

void check(double value, double least, double most, const char* name, const char* unit) {
  if (value >= least && value <= most) return;
  throw usage_error(fmt::format("{} is {}", name, value), {}, fmt::format("from {} to {}{}", least, most, unit));
}

}  // namespace

void ToneOptions::validate() const {
  check(skin_prior, 0.001, 1000, "tones.skin_prior", "");
  check(outliers, 0.001, 1000, "tones.outliers", "");
  check(threshold, 0.01, 0.99, "tones.threshold", "");
  check(noise, 0, 50, "tones.noise", " grey levels");
  check(learn_s, 0, 60, "tones.learn_s", " s");
  if (adapt_s != 0) check(adapt_s, 0.5, 3600, "tones.adapt_s", " s, or 0 (never adapts)");
  check(rebuild_s, 0, 60, "tones.rebuild_s", " s");
  if (arms.empty()) throw usage_error("tones.arms names no tone", {}, "for instance [\"skin\"]");
  for (const auto& name : arms) {
    if (name.empty()) throw usage_error("tones.arms names a tone \"\"", {}, "for instance [\"skin\"]");
  }
  if (!learn_skin && file.empty()) {
    throw usage_error("tones.skin is \"file\" and tones.file is empty", {},
                      "name a file that `choreoscope tones train` wrote, or let the skin be learned");
  }
}

void ToneOptions::validate(std::vector<std::string> given) const {
  validate();
  if (learn_skin) given.insert(given.begin(), "skin");
  for (const auto& name : arms) {
    if (std::find(given.begin(), given.end(), name) != given.end()) continue;
    const auto what = fmt::format("names \"{}\", which is no tone", shortened(name));
    if (const auto near = nearest_name(name, given)) {
      throw usage_error(what, "tones.arms", fmt::format("did you mean \"{}\"?", *near));
    }
    const auto known = given.empty() ? std::string() : fmt::format("known: {}; ", join(given));
    throw usage_error(
        what, "tones.arms",
        fmt::format("{}make it with choreoscope tones train --picture P --mask M --name {} --out FILE, and "
                    "give it with --set tones.file=FILE",
                    known, file.empty() ? shortened(name) : shortened(name) + " --merge " + file));
  }
}

ToneKind tone_kind_named(const std::string& name) {
  if (name == "gaussian") return ToneKind::kGaussian;
  if (name == "histogram") return ToneKind::kHistogram;
  static const std::array<std::string, 2> kNames = {"gaussian", "histogram"};
  throw usage_error(fmt::format("unknown model \"{}\"", shortened(name)), {}, hint_for_name(name, kNames));
}

const char* name_of(ToneKind kind) { return kind == ToneKind::kGaussian ? "gaussian" : "histogram"; }

}  // namespace choreo::vision

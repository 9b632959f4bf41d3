// SPDX-License-Identifier: Apache-2.0
#include "cli/signal_chain.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "config/tones_file.hpp"
#include "outputs/letters_json.hpp"
#include "pipeline/face_models.hpp"

namespace choreo::cli {
namespace {

// Of the body: a face and two arms are a fifth, somebody in a swimsuit three quarters.
constexpr double kMostlyTone = 0.6;
constexpr double kSomeTone = 0.002;  // A hand is more than that; less is noise.

double percent(std::uint64_t part, std::uint64_t whole) { return 100.0 * double(part) / double(whole); }

std::vector<outputs::Ring> arms_of(const vision::Arms& seen, double scale) {
  std::vector<outputs::Ring> out;
  const std::size_t arms = seen.found == vision::ArmCase::kTwoArms                                            ? 2
                           : seen.found == vision::ArmCase::kOneArm || seen.found == vision::ArmCase::kJoined ? 1
                                                                                                              : 0;
  for (std::size_t k = 0; k < arms; ++k) {
    const auto& m = seen.blob[k].moments;
    const double per = scale * scale / m.m00;
    out.push_back(outputs::ring_of(scale * m.centroid, per * m.mu20, per * m.mu11, per * m.mu02));
  }
  return out;
}

// From the elbow to the hand.
std::vector<outputs::Ring> forearms_of(const vision::PersonLook& look, double scale) {
  using Name = vision::PersonPointName;
  constexpr double kHand = 1.3, kSlender = 0.2;
  std::vector<outputs::Ring> out;
  for (const auto& [from, to] :
       {std::pair(Name::kLeftElbow, Name::kLeftWrist), {Name::kRightElbow, Name::kRightWrist}}) {
    const auto elbow = scale * look[from].at;
    const auto along = kHand * (scale * look[to].at - elbow);
    const double half = cv::norm(along) / 2;
    out.push_back({elbow + along / 2, {half, kSlender * half}, std::atan2(along.y, along.x) * 180 / CV_PI});
  }
  return out;
}

}  // namespace

void SignalOptions::declare(CLI::App& command) {
  command
      .add_option("--state", state,
                  "what stands for the body: mask, its silhouette, or particles, its face and bare arms\n"
                  "(default mask; particles with --recognise)")
      ->type_name("STATE")
      ->check(CLI::IsMember({"mask", "particles"}));
  command.add_option("--recognise", recognise, "read the signs of: semaphore")
      ->type_name("WHAT")
      ->check(CLI::IsMember({"semaphore"}));
}

std::unique_ptr<vision::FaceDetector> load_faces(const config::Options& settings) {
  pipeline::FaceModelOptions models;
  if (!settings.cascades.empty()) models.cascades = settings.cascades;
  models.model = settings.face_model;
  models.haar = settings.haar;
  return pipeline::load_face_detector(models);
}

pipeline::ToneReaderOptions tone_reader_options(const config::Options& settings) {
  pipeline::ToneReaderOptions options;
  options.semaphore = settings.semaphore;
  options.least_face = settings.face.search.least_share;
  options.most_face = settings.face.search.most_share;
  options.tones = settings.tones;
  options.arms = settings.arms;
  options.bounds = settings.bounds;
  if (!settings.tones.file.empty()) options.given = config::load_tones(settings.tones.file);
  return options;
}

void SignalTally::add(const pipeline::Observation& o) {
  ++frames_;
  ++cases_[std::size_t(o.arms.found)];
  several_faces_ += o.faces > 1 ? 1 : 0;
  if (!o.mask.body) return;
  ++bodies_;
  if (!body_s_) body_s_ = to_seconds(o.time);
  const auto found = o.arms.found;
  if (!arms_s_ && found != vision::ArmCase::kNoFace && found != vision::ArmCase::kNoArm) arms_s_ = to_seconds(o.time);
  some_tone_ += o.tone_share > kSomeTone ? 1 : 0;
  all_tone_ += o.tone_share > kMostlyTone ? 1 : 0;
}

std::optional<std::string> SignalTally::late_start() const {
  constexpr double kAtOnce_s = 1;
  if (looks_ || !arms_s_ || *arms_s_ - *body_s_ < kAtOnce_s) return std::nullopt;
  return fmt::format(
      "signs are read from {:.1f} s on: somebody was there from {:.1f} s, and the face was still to be found, the skin "
      "to be learned",
      *arms_s_, *body_s_);
}

std::vector<std::string> SignalTally::warnings(const config::Options& settings) const {
  auto lines = of_tones(settings);
  if (looks_) {
    for (auto& line : lines) line += "; signs are read by the person network all the same";
  }
  return lines;
}

std::vector<std::string> SignalTally::of_tones(const config::Options& settings) const {
  std::vector<std::string> lines;
  if (!colour_) {
    lines.emplace_back(
        "the pictures have no colour, and tones need it: nothing is known of their arms, and the silhouette stands for "
        "the "
        "body");
  }
  if (late_ > 0) {
    lines.push_back(fmt::format(
        "{} of {} searches for faces were not ready in time and do not count: film fewer frames a second, or let them "
        "take more frames (face.delay_frames)",
        late_, searches_));
  }
  if (bodies_ == 0) return lines;  // That is said already.
  const auto faceless = cases_[std::size_t(vision::ArmCase::kNoFace)];
  if (several_faces_ > 0) {
    lines.push_back(fmt::format(
        "several faces in {:.0f} % of the frames: {} counts (face.choose)", percent(several_faces_, frames_),
        settings.face.track.choose == vision::FaceChoice::kLargest ? "the largest" : "the one that was there first"));
  }
  if (faceless == frames_) {
    if (2 * late_ > searches_) return lines;  // That is why.
    lines.emplace_back(
        "no face was ever seen, so nothing is known of the arms: somebody is to look at the camera, larger than "
        "face.least_share of the picture's height");
    return lines;
  }
  if (some_tone_ == 0) {
    lines.push_back(fmt::format("none of the body has the tone of {}: see tones.arms, tones.threshold",
                                fmt::join(settings.tones.arms, ", ")));
  } else if (2 * all_tone_ > bodies_) {
    lines.push_back(fmt::format(
        "most of the body has the tone of {} in {:.0f} % of the frames, so arms cannot be told from it: wear another "
        "colour, or give the arms one of their own (choreoscope tones train)",
        fmt::join(settings.tones.arms, ", "), percent(all_tone_, bodies_)));
  } else if (two_arms() == 0) {
    lines.emplace_back("two arms were never seen apart: sleeves that end above the wrist, or see tones.arms");
  }
  return lines;
}

SignalChain::SignalChain(const config::Options& settings, bool reads, bool looks,
                         std::function<void(std::uint64_t)> on_late, std::optional<Nanoseconds> history)
    : looks_(looks) {
  auto options = settings.face;
  options.waits = on_late == nullptr;
  options.on_late = std::move(on_late);
  auto face = std::make_unique<pipeline::FaceStage>(load_faces(settings), std::move(options));
  face_ = face.get();
  by_tone_.push_back(std::move(face));

  pipeline::ParticleStageOptions particles;
  particles.tones = settings.tones;
  if (!settings.tones.file.empty()) particles.given = config::load_tones(settings.tones.file);
  particles.arms = settings.arms;
  particles.bounds = settings.bounds;
  by_tone_.push_back(std::make_unique<pipeline::ParticleStage>(std::move(particles)));

  if (!reads) return;
  auto semaphore = std::make_unique<pipeline::SemaphoreStage>(
      settings.semaphore, settings.bounds, looks ? pipeline::ReadsSigns::kOfLooks : pipeline::ReadsSigns::kOfParticles,
      history);
  semaphore_ = semaphore.get();
  reader_ = std::move(semaphore);
}

void SignalChain::add_to(std::vector<std::unique_ptr<pipeline::Stage>>& stages, bool colour) {
  if (colour) std::ranges::move(by_tone_, std::back_inserter(stages));
  if (reader_ && (colour || looks_)) stages.push_back(std::move(reader_));
}

void SignalChain::finish() {
  if (semaphore_ != nullptr) semaphore_->finish();
}

bool SignalChain::read_a_letter() const { return semaphore_ != nullptr && semaphore_->letters() > 0; }

outputs::SignalOverlay overlay_of(const pipeline::Observation& o, cv::Size picture) {
  outputs::SignalOverlay overlay;
  const double scale = double(picture.height) / std::max(1, o.picture.rows);
  if (o.face) {
    const double half = scale * o.face->width / 2;
    overlay.faces.push_back({scale * o.face->centre, {half, half}});
  }
  if (o.signal && o.signal->of_looks) {
    if (o.person) overlay.arms = forearms_of(o.person->look, scale);
  } else {
    overlay.arms = arms_of(o.arms, scale);
  }
  if (!o.signal) return overlay;
  overlay.text = o.signal->text;
  if (o.signal->held) overlay.letter = o.signal->held->sign;
  if (o.signal->now.sign) {
    overlay.beside =
        fmt::format("{} {:.2f}, then {}", *o.signal->now.sign, o.signal->now.confidence, o.signal->now.runner_up);
  }
  return overlay;
}

void tell_signs(std::span<const recognition::HeldSign> signs) {
  for (const auto& sign : signs) {
    if (sign.sign == "REST") continue;
    fmt::print("{:.3f} to {:.3f} s: {} ({:.2f})\n", sign.from, sign.to, sign.sign, sign.confidence);
    std::fflush(stdout);  // Whoever reads along through a pipe waits for it.
  }
}

void tell_reading(const SignalChain& chain, const SignalTally& tally, Console& console) {
  if (const auto late = tally.late_start()) console.say(*late);
  if (!chain.read_a_letter()) console.say("no letter was read");
  fmt::print("{}{}\n", chain.semaphore()->since() ? "..." : "", chain.semaphore()->text());
}

std::string letters_json(const SignalChain& chain) {
  const auto* semaphore = chain.semaphore();
  if (semaphore == nullptr) return outputs::letters_json({}, {});
  return outputs::letters_json(semaphore->signs(), semaphore->text(), semaphore->since());
}

}  // namespace choreo::cli

// SPDX-License-Identifier: Apache-2.0
#include "cli/signal_chain.hpp"

#include <utility>

#include <fmt/format.h>

#include "config/tones_file.hpp"
#include "pipeline/face_models.hpp"

namespace choreo::cli {
namespace {

// Of the body: a face and two arms are a fifth, somebody in a swimsuit three quarters.
constexpr double kMostlyTone = 0.6;

double percent(std::uint64_t part, std::uint64_t whole) { return 100.0 * double(part) / double(whole); }

}  // namespace

void SignalOptions::declare(CLI::App& command) {
  command
      .add_option("--state", state,
                  "what stands for the body: mask, its silhouette, or particles, its face and bare arms (default mask; "
                  "particles with --recognise)")
      ->type_name("STATE")
      ->check(CLI::IsMember({"mask", "particles"}));
  command.add_option("--recognise", recognise, "read the signs of: semaphore")
      ->type_name("WHAT")
      ->check(CLI::IsMember({"semaphore"}));
}

void SignalTally::add(const pipeline::Observation& o) {
  ++frames_;
  ++cases_[std::size_t(o.arms.found)];
  several_faces_ += o.faces > 1 ? 1 : 0;
  if (!o.mask.body) return;
  ++bodies_;
  some_tone_ += o.tone_share > 0 ? 1 : 0;
  all_tone_ += o.tone_share > kMostlyTone ? 1 : 0;
}

std::vector<std::string> SignalTally::warnings(const config::Options& settings) const {
  std::vector<std::string> lines;
  if (bodies_ == 0) return lines;  // That is said already.
  const auto faceless = cases_[std::size_t(vision::ArmCase::kNoFace)];
  if (several_faces_ > 0) {
    lines.push_back(fmt::format(
        "several faces in {:.0f} % of the frames: {} counts (face.choose)", percent(several_faces_, frames_),
        settings.face.track.choose == vision::FaceChoice::kLargest ? "the largest" : "the one that was there first"));
  }
  if (faceless == frames_) {
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

SignalChain::SignalChain(const config::Options& settings, bool reads, std::function<void(std::uint64_t)> on_late) {
  pipeline::FaceModelOptions models;
  if (!settings.cascades.empty()) models.cascades = settings.cascades;
  models.model = settings.face_model;
  models.haar = settings.haar;
  auto options = settings.face;
  options.waits = on_late == nullptr;
  options.on_late = std::move(on_late);
  auto face = std::make_unique<pipeline::FaceStage>(pipeline::load_face_detector(models), std::move(options));
  face_ = face.get();
  stages_.push_back(std::move(face));

  pipeline::ParticleStageOptions particles;
  particles.tones = settings.tones;
  if (!settings.tones.file.empty()) particles.given = config::load_tones(settings.tones.file);
  particles.arms = settings.arms;
  particles.bounds = settings.bounds;
  stages_.push_back(std::make_unique<pipeline::ParticleStage>(std::move(particles)));

  if (!reads) return;
  auto semaphore = std::make_unique<pipeline::SemaphoreStage>(settings.semaphore, settings.bounds);
  semaphore_ = semaphore.get();
  stages_.push_back(std::move(semaphore));
}

void SignalChain::add_to(std::vector<std::unique_ptr<pipeline::Stage>>& stages) {
  for (auto& stage : stages_) stages.push_back(std::move(stage));
  stages_.clear();
}

void SignalChain::finish() {
  if (semaphore_ != nullptr) semaphore_->finish();
}

std::string letter_of(const pipeline::Signal& signal) {
  if (signal.held) return std::string(signal.held->sign);
  return signal.now.sign ? std::string(*signal.now.sign) : "no letter";
}

}  // namespace choreo::cli

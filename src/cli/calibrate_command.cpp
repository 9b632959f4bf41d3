// SPDX-License-Identifier: Apache-2.0
// choreoscope calibrate: how far this performer's arms reach, from a stretch of them, as settings.
#include <chrono>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "body/particle_calibration.hpp"
#include "cli/commands.hpp"
#include "cli/one_picture.hpp"
#include "cli/people.hpp"
#include "cli/preparation.hpp"
#include "cli/signal_chain.hpp"
#include "cli/source_options.hpp"
#include "core/text.hpp"
#include "devices/source_uri.hpp"
#include "outputs/output_set.hpp"
#include "pipeline/stages/silhouette_stages.hpp"
#include "pipeline/steady_clock.hpp"

namespace choreo::cli {
namespace {

namespace fs = std::filesystem;

struct CalibrateOptions {
  SourceOptions source;
  std::string out;
};

constexpr auto kCalibrateManual = R"(
The performer looks at the camera for three seconds, with bare forearms, and
then stretches both arms to the sides, up and down, for a second or two each. A
device is watched for 30 s, or until Ctrl-C or as long as --span says; a
recording to its end.

What it prints and writes are the settings particles.alpha_max, c_max and
eta_max, in face widths: the largest lengths that were held in more than 2 % of
the frames in which both arms were seen, kept near those of the Vitruvian
figure. FILE goes beside other settings:
  choreoscope live v4l2:// --config stage --config FILE --state particles

Examples:
  choreoscope calibrate v4l2:// -o anna.toml
  choreoscope calibrate stretch.mp4 -o anna.toml
  choreoscope calibrate v4l2:// -o anna.toml --config gloves.toml

Exit status: 0 done, 1 failed while running, 2 refused (no face, no two arms,
not stretched, too short), 130 interrupted: FILE is written where enough was
seen.)";

constexpr auto kWhatToDo =
    "look at the camera for three seconds, with bare forearms, then stretch both arms to the sides, up and down, a "
    "second or two each";
constexpr auto kWatched = std::chrono::seconds(30);

// The last stage: collects the reach of every frame with two arms.
class ReachStage final : public pipeline::Stage {
 public:
  [[nodiscard]] std::string name() const override { return "reach"; }
  void process(pipeline::Observation& o) override {
    tally.add(o);
    if (o.particles && o.arms.found == vision::ArmCase::kTwoArms) calibration.add(o.particles->parts());
    bodies += o.mask.body ? 1 : 0;
  }

  SignalTally tally{false};
  body::ParticleCalibration calibration;
  std::uint64_t bodies = 0;
};

// What must have been seen before the bounds mean anything.
void require_a_stretch(const ReachStage& reach, const config::Options& settings, const devices::SourceInfo& info) {
  const auto frames = reach.tally.frames();
  const auto& source = info.name;
  if (frames == 1 && is_one_picture(info)) {
    throw usage_error("is one picture, and a calibration takes a film", source, kHowPicturesAreRead);
  }
  if (reach.bodies == 0) {
    throw usage_error(fmt::format("no body was ever seen in {}", counted(frames, "frame")), source,
                      settings.segmentation == "person" || settings.segmentation == "auto"
                          ? "the person network sees who is larger than a tenth of the picture's height"
                          : "somebody who never moves is taken for the wall: give a plate with --background");
  }
  const auto reasons = reach.tally.warnings(settings);
  if (reach.tally.two_arms() == 0 && !reasons.empty()) throw usage_error(reasons.back(), source, kWhatToDo);
  if (reach.calibration.frames() < body::ParticleCalibration::kLeastFrames) {
    throw usage_error(
        fmt::format("both arms were seen in {} of {}: too few for a calibration, which takes {}",
                    reach.calibration.frames(), counted(frames, "frame"), body::ParticleCalibration::kLeastFrames),
        source, kWhatToDo);
  }
  const auto far = reach.calibration.reached();
  const body::ParticleBounds vitruvian;
  if (far.alpha_max >= vitruvian.alpha_max / 2 && far.eta_max >= vitruvian.eta_max / 2) return;
  throw usage_error(
      fmt::format("the arms were not stretched: half their distance came to {:.2f} face widths and their middle to "
                  "{:.2f} from the face, of {:.2f} and {:.2f} at the least",
                  far.alpha_max, far.eta_max, vitruvian.alpha_max / 2, vitruvian.eta_max / 2),
      source, kWhatToDo);
}

struct Line {
  const char* name;
  double body::ParticleBounds::*member;
};
constexpr Line kLines[] = {{"alpha_max", &body::ParticleBounds::alpha_max},
                           {"c_max", &body::ParticleBounds::c_max},
                           {"eta_max", &body::ParticleBounds::eta_max}};

std::string file_of(const body::ParticleBounds& bounds, const std::string& seen, const std::string& source) {
  std::string text = fmt::format("# choreoscope calibrate {}\n# {}\n\n[particles]\n", one_line(source), seen);
  for (const auto& [name, member] : kLines) {
    text +=
        fmt::format("{} = {:.4f}  # the Vitruvian figure: {}\n", name, bounds.*member, body::ParticleBounds{}.*member);
  }
  return text;
}

// Bounds that are none of the performer's.
void warn_of_limits(const body::ParticleCalibration& calibration, Console& console) {
  const auto reached = calibration.reached();
  const auto bounds = calibration.bounds();
  for (const auto& [name, member] : kLines) {
    if (reached.*member == bounds.*member) continue;
    const auto* cause = reached.*member < bounds.*member ? "hands or flags alone are that short"
                                                         : "was something else taken for an arm?";
    console.warn(
        fmt::format("{} came to {:.4f} and is kept at {:.4f}: {}", name, reached.*member, bounds.*member, cause));
  }
}

// Arms that were raised a little pass for a performer of short arms.
void warn_of_half_a_stretch(const body::ParticleCalibration& calibration, Console& console) {
  constexpr double kFully = 0.8;
  const auto far = calibration.reached().alpha_max;
  const auto vitruvian = body::ParticleBounds{}.alpha_max;
  if (far >= kFully * vitruvian) return;
  console.warn(
      fmt::format("half the distance of the arms came to {:.2f} face widths, that of the Vitruvian figure to "
                  "{:.2f}: were both stretched to the sides?",
                  far, vitruvian));
}

int calibrate(const CalibrateOptions& options, Session& session) {
  auto& console = session.console;
  const pipeline::SteadyClock clock;
  const fs::path path = options.out;
  if (!path.has_filename()) {
    throw usage_error(fmt::format("-o \"{}\" names no file", shortened(options.out)), {}, "for instance bounds.toml");
  }
  const auto config = options.source.configuration();
  const auto& settings = config.options();
  Preparation prepared(options.source, settings, session, clock);
  const auto name = prepared.summary.source.name;
  outputs::OutputSet files(path.has_parent_path() ? path.parent_path() : fs::path("."));
  files.check(path.filename().string());
  SignalChain chain(settings, false, false, nullptr);
  if (prepared.summary.source.live) {
    if (!options.source.span) prepared.selection.to = kWatched;
    console.say(std::string(kWhatToDo) + "; Ctrl-C ends");
  }
  if (!prepared.has_colour()) {
    throw usage_error("the pictures have no colour, and tones need it: nothing is known of arms", name,
                      "take a camera that sees colours");
  }
  auto masker = prepared.learn();

  std::vector<std::unique_ptr<pipeline::Stage>> stages;
  stages.push_back(std::make_unique<pipeline::PictureStage>(prepared.summary.working_size, masker.uses_depth()));
  if (masker.wants_person()) {
    stages.push_back(person_stage(load_people(settings), settings, true, masker.of_person(), false));
  }
  stages.push_back(std::make_unique<pipeline::MaskStage>(std::move(masker), others_of(settings)));
  chain.add_to(stages, true);
  auto owned = std::make_unique<ReachStage>();
  const auto& reach = *owned;
  stages.push_back(std::move(owned));
  const auto run =
      pipeline::run(*prepared.source, prepared.selection, stages, {prepared.summary.threads}, clock, prepared.stop);
  if (run.problem) std::rethrow_exception(run.problem);
  const bool stopped = prepared.stop.stop_requested();
  if (reach.tally.frames() == 0 && !stopped) {
    throw usage_error(fmt::format("no frame of \"{}\" is chosen: it has {}", name, counted(run.frames_read, "frame")),
                      options.source.span ? "--span " + *options.source.span : "",
                      "choose a span inside the recording");
  }
  if (stopped && reach.calibration.frames() < body::ParticleCalibration::kLeastFrames) throw Interrupted{};
  require_a_stretch(reach, settings, prepared.summary.source);

  const auto seen = fmt::format("both arms in {} of {} frames", reach.calibration.frames(), reach.tally.frames());
  const auto bounds = reach.calibration.bounds();
  outputs::write_file(files.add(path.filename().string()),
                      file_of(bounds, seen, devices::without_password(options.source.source)));
  files.commit();
  for (const auto& warning : prepared.source->warnings()) console.warn(warning);
  for (const auto& warning : reach.tally.warnings(settings)) console.warn(warning);
  warn_of_half_a_stretch(reach.calibration, console);
  warn_of_limits(reach.calibration, console);
  for (const auto& [setting, member] : kLines) fmt::print("particles.{} = {:.4f}\n", setting, bounds.*member);
  fmt::print("{}: {}\n", path.string(), seen);
  return stopped ? kInterrupted : kDone;
}

}  // namespace

void declare_calibrate(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<CalibrateOptions>();
  auto* command = app.add_subcommand("calibrate", "find how far a performer's arms reach, from a stretch of them");
  options->source.declare(*command);
  command
      ->add_option("-o,--out", options->out, "the settings to write, as TOML; folders are made where they are missing")
      ->required()
      ->type_name("FILE");
  command->footer(kCalibrateManual);
  command->callback(
      [options, &chosen] { chosen = [options](Session& session) { return calibrate(*options, session); }; });
}

}  // namespace choreo::cli

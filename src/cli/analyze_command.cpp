// SPDX-License-Identifier: Apache-2.0
// choreoscope analyze: a recording in, its Z and Z* plots, matrices and tables out.
#include <algorithm>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/kept_states.hpp"
#include "cli/people.hpp"
#include "cli/picture_set_results.hpp"
#include "cli/preparation.hpp"
#include "cli/recording.hpp"
#include "cli/results.hpp"
#include "cli/signal_chain.hpp"
#include "cli/source_options.hpp"
#include "core/text.hpp"
#include "outputs/particles_csv.hpp"
#include "pipeline/stages/silhouette_stages.hpp"
#include "pipeline/steady_clock.hpp"

namespace choreo::cli {
namespace {

struct AnalyzeOptions {
  SourceOptions source;
  SignalOptions signals;
  std::string out;
  std::vector<std::string> save;

  [[nodiscard]] bool saves(const char* what) const { return std::find(save.begin(), save.end(), what) != save.end(); }
};

constexpr auto kAnalyzeManual = R"(
What it writes into DIR:
  plot.png       Z in red and Z* in cyan, time to the right and down; white on
                 the diagonal is a mirror-symmetric pose, red an asymmetric one
  triangle.png   the same with the identity axis horizontal and the lag upwards
  z.npy          similarity of every pair of frames, float32, N x N, NaN where
  zstar.npy      there is no body; and the same with mirror images
  times.npy      float64, N: seconds since the source's first frame
  frames.csv     one row a frame: body, area, centroid, box, motion, symmetry
  masks.npy      with --save masks: uint8 0/1, N x H x W
  particles.csv  with --save particles: one row a frame: face, arms and the
                 particle state, in face widths
  joints.csv     with --save joints: one row a frame: 33 points of the person,
                 in pixels and in metres, by the person network;
                 joints_smooth.csv beside it where person.smooth_hz is set
  letters.json   with --recognise semaphore: letters with times, and the text
  summary.json   source, sizes, settings, warnings, timings
A set of pictures (a folder whose names are no numbered sequence, or with
?stills=1) read with --recognise semaphore gives instead of all these, and
takes no --save, --state, --span, --every or --background:
  letters.json   the letter that each picture shows, or null
  pictures.png   all pictures with what was seen of the arms
Each picture is read by itself.
Nothing is written under these names before all of it is complete.

Examples:
  choreoscope analyze rehearsal.mp4 --out out/rehearsal
  choreoscope analyze stage.mkv --out out/stage --background empty-stage.png
  choreoscope analyze long.mkv --out out/long --every 5 --span 60:180
  choreoscope analyze 'synthetic://jumping-jacks?seed=3' --out out/jacks
  choreoscope analyze clip.mkv --out out/clip --set mask.threshold=18
  choreoscope analyze signals.mp4 --out out/signals --recognise semaphore
  choreoscope analyze photographs --out out/photos --recognise semaphore

Exit status: 0 done, 1 failed while running, 2 refused (usage, configuration,
source), 130 interrupted: what was computed until then is written.)";

// Pictures of a set do not follow one another, have no states, and tell of their background by themselves.
void refuse_what_sets_lack(const AnalyzeOptions& options) {
  const std::pair<const char*, bool> given[] = {{"--save", !options.save.empty()},
                                                {"--state", !options.signals.state.empty()},
                                                {"--span", options.source.span.has_value()},
                                                {"--every", options.source.every != 1},
                                                {"--background", options.source.background.has_value()}};
  for (const auto& [option, is_given] : given) {
    if (!is_given) continue;
    throw usage_error("means nothing for a set of pictures", option,
                      "leave it out: a set gives letters.json and pictures.png, nothing else");
  }
}

// Cameras number photographs as films are numbered: whoever gave separate pictures is told how to say so.
std::string unread_pictures(const devices::SourceInfo& source) {
  std::error_code problem;
  const bool has_settings = !std::filesystem::exists(source.name, problem);
  return fmt::format(
      "no letter was read: numbered pictures are read as a video's frames; for separate pictures append {}stills=1 to "
      "SOURCE",
      has_settings ? '&' : '?');
}

int analyze(const AnalyzeOptions& options, Session& session) {
  auto& console = session.console;
  const pipeline::SteadyClock clock;
  const auto config = options.source.configuration();
  const auto& settings = config.options();
  const bool save_masks = options.saves("masks");
  const bool save_particles = options.saves("particles");
  const bool save_joints = options.saves("joints");
  Preparation prepared(options.source, settings, session, clock, false, options.signals.reads());
  auto& summary = prepared.summary;
  const auto& stop = prepared.stop;
  if (options.out.empty()) throw usage_error("is empty", "--out", "name the folder to write to");
  if (summary.source.stills && options.signals.reads()) {
    refuse_what_sets_lack(options);
    const auto tones = tone_reader_options(settings);
    if (prepared.can_look()) {
      auto people = load_people(settings);
      const bool mirrored = settings.semaphore.mirrored;
      const auto read = [&](const cv::Mat& picture) { return pipeline::read_by_network(picture, people, mirrored); };
      return analyze_pictures(*prepared.source, read, options.out, session);
    }
    const auto faces = load_faces(settings);
    const pipeline::ToneReader reader(*faces, tones);
    return analyze_pictures(
        *prepared.source, [&](const cv::Mat& picture) { return reader.read(picture); }, options.out, session);
  }
  outputs::OutputSet files(options.out);
  std::vector<std::string> more;
  if (save_masks) more.emplace_back("masks.npy");
  if (save_particles) more.emplace_back("particles.csv");
  if (save_joints) std::ranges::copy(JointsRecord::files(settings), std::back_inserter(more));
  if (options.signals.reads()) more.emplace_back("letters.json");
  announce_files(summary, files, settings, more);
  const auto frames = expected_frames(summary, prepared.selection, std::size_t(settings.matrix_rows));
  files.require_space(space_for(frames, save_masks ? summary.working_size : cv::Size()),
                      fmt::format("the matrices of {} frames", frames));
  // Files that cannot be used are refused before anything is read.
  const bool looks = save_joints || prepared.looks_for_people() || (options.signals.reads() && prepared.can_look());
  std::optional<SignalChain> chain;
  if (options.signals.particles() || options.signals.reads() || save_particles) {
    chain.emplace(settings, options.signals.reads(), looks, nullptr);
  }
  std::optional<vision::PersonSearch> people;
  if (looks) people.emplace(load_people(settings));
  SignalTally tally(looks && options.signals.reads());
  const bool arms = chain && prepared.has_colour();
  if (chain && !arms) tally.no_colour();
  auto masker = prepared.learn();
  // Said at once, whatever is being done: people press again where nothing answers.
  const std::stop_callback answer(
      stop, [&] { console.warn_later("interrupted: what was read is finished and written; again to leave nothing"); });

  std::optional<outputs::NpyPictures> masks;
  if (save_masks) masks.emplace(files.add("masks.npy"), summary.working_size);
  // Files lie about their length and spans reach beyond it: the bar is for people, and need not be exact.
  const auto end = std::min(summary.source.duration.value_or(Nanoseconds::max()), prepared.selection.to);
  const auto seen = [&](const pipeline::Observation& o) {
    if (arms) tally.add(o);
    const auto to_do = to_seconds(end - prepared.selection.from);
    console.progress("reading frames",
                     end == Nanoseconds::max() ? -1.0 : to_seconds(o.time - prepared.selection.from) / to_do);
  };
  std::vector<std::unique_ptr<pipeline::Stage>> stages;
  stages.push_back(std::make_unique<pipeline::PictureStage>(summary.working_size, masker.uses_depth()));
  const JointsRecord* joints = nullptr;
  if (people) {
    const bool masks_of_people = prepared.looks_for_people();
    stages.push_back(person_stage(*std::move(people), settings, masks_of_people, !masks_of_people || masker.of_person(),
                                  options.signals.reads()));
    if (save_joints) {
      auto joints_record = std::make_unique<JointsRecord>(JointsRecord::Keeps::kAll);
      joints = joints_record.get();
      stages.push_back(std::move(joints_record));
    }
  }
  stages.push_back(std::make_unique<pipeline::MaskStage>(std::move(masker), others_of(settings)));
  stages.push_back(std::make_unique<pipeline::StateStage>(settings.motion_window_s));
  if (chain) chain->add_to(stages, arms);
  std::unique_ptr<KeptStates> states;
  summary.particles = arms && options.signals.particles();
  if (summary.particles) {
    states = std::make_unique<KeptParticles>();
  } else {
    states = std::make_unique<KeptMasks>(prepared.kernel);
  }
  auto owned_record = std::make_unique<RecordStage>(
      *states, save_particles, std::size_t(settings.matrix_rows),
      ThumbnailKeeper(settings.plot.thumbnails, settings.plot.thumbnails_at_s), masks ? &*masks : nullptr, seen);
  auto& record = *owned_record;
  stages.push_back(std::move(owned_record));
  summary.run = pipeline::run(*prepared.source, prepared.selection, stages, {summary.threads}, clock, stop);
  console.finish_progress();
  if (summary.run.problem) std::rethrow_exception(summary.run.problem);
  if (record.rows().empty()) {
    if (summary.run.interrupted) throw Interrupted{};
    throw usage_error(fmt::format("no frame of \"{}\" is chosen: it has {}", summary.source.name,
                                  counted(summary.run.frames_read, "frame")),
                      options.source.span ? "--span " + *options.source.span : "",
                      "choose a span inside the recording");
  }

  summary.thinned_to_every = record.kept_every();
  const auto comparer = states->comparer();
  summary.canvas = states->canvas();
  summary.sudden_changes_s = record.sudden_changes_s();
  record.masks_tally().tell(summary);
  if (save_particles) {
    outputs::write_file(files.add("particles.csv"), outputs::particles_csv(record.particle_rows()));
  }
  if (joints != nullptr) joints->write(files, settings);
  if (options.signals.reads()) {
    chain->finish();
    outputs::write_file(files.add("letters.json"), letters_json(*chain));
  }
  auto signal_warnings = tally.warnings(settings);
  if (options.signals.reads() && summary.source.numbered_pictures && !chain->read_a_letter()) {
    signal_warnings.push_back(unread_pictures(summary.source));
  }
  write_results(summary, config, *comparer,
                {record.rows(), record.thumbnails().chosen(), record.bodies(), record.cut_bodies(),
                 prepared.source->warnings(), std::move(signal_warnings)},
                masks ? &*masks : nullptr, files, session, clock);
  tell_results(summary, files, console);
  if (options.signals.reads()) tell_reading(*chain, tally, console);
  // Also where all frames were read before: whoever stops a batch wants the batch to stop.
  return stop.stop_requested() ? kInterrupted : kDone;
}

}  // namespace

void declare_analyze(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<AnalyzeOptions>();
  auto* command = app.add_subcommand("analyze", "turn a recording into its Z and Z* plots, matrices and tables");
  options->source.declare(*command);
  options->signals.declare(*command);
  command->get_option("--recognise")
      ->description(
          "read the signs of: semaphore. Numbered images are the frames of a video; of separate pictures\n"
          "(folder?stills=1) each has a letter");
  command->add_option("--out", options->out, "the folder to write to; made where it is missing")
      ->required()
      ->type_name("DIR");
  command->add_option("--save", options->save, "also write: masks, particles, joints; --save masks,joints for two")
      ->type_name("WHAT")
      ->allow_extra_args(false)
      ->delimiter(',')
      ->check(CLI::IsMember({"masks", "particles", "joints"}));
  command->footer(kAnalyzeManual);
  command->callback(
      [options, &chosen] { chosen = [options](Session& session) { return analyze(*options, session); }; });
}

}  // namespace choreo::cli

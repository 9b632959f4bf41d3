// SPDX-License-Identifier: Apache-2.0
// choreoscope live: a row of Z and Z* a frame, while the body moves.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <opencv2/imgproc.hpp>

#include "cli/commands.hpp"
#include "cli/live_history.hpp"
#include "cli/live_record.hpp"
#include "cli/memory.hpp"
#include "cli/people.hpp"
#include "cli/preparation.hpp"
#include "cli/results.hpp"
#include "cli/signal_chain.hpp"
#include "cli/source_options.hpp"
#include "cli/take_recording.hpp"
#include "core/text.hpp"
#include "outputs/joints_overlay.hpp"
#include "outputs/live_window.hpp"
#include "outputs/signal_overlay.hpp"
#include "pipeline/pacing.hpp"
#include "pipeline/stages/silhouette_stages.hpp"
#include "pipeline/steady_clock.hpp"
#include "pipeline/working_size.hpp"

namespace choreo::cli {
namespace {

struct LiveOptions {
  SourceOptions source;
  SignalOptions signals;
  bool joints = false;
  std::string pace = "live";
  std::string history = "10min";
  bool headless = false;
  bool full_screen = false;
  std::string out;
  std::string record;
};

constexpr auto kLiveManual = R"(
Every frame is compared with the frames of the last minutes, once for Z and Z*
together, and the triangle in the window scrolls. Settings that differ from
those of analyze: working.rows is 120 (480 where arms are looked at) and
background.from is "first:2s" where nothing else is said (--set, --config,
--background).

  --pace live    as a camera: the newest frame wins, what it overtakes is
                 counted as dropped; a recording, also from a pipe or an
                 address, is played at its own time, and where it cannot be
                 read so fast a warning says so
  --pace replay  at its own time at the earliest, and no frame is lost
  --pace max     as fast as it goes, and no frame is lost

A device has a pace of its own: of one the newest frame always wins.

Keys in the window: q or Esc ends, f full screen, + and - change the span of
time, j shows joints and hides them (--joints), l prints the latencies. So does
the signal SIGUSR1, window or not:
  kill -USR1 $(pidof choreoscope)

With --out DIR the frames that are in the history at the end are written as
analyze writes them, and with the same settings to the last bit:
  choreoscope analyze show.mkv --set working.rows=120 --background first:2s ...

With --record TAKE.mkv everything that the source gives is recorded as it came
(choreoscope record --help), with marks at the frames that the run processed:
  choreoscope live 'TAKE.mkv?frames=processed' --pace max ...
with the same settings gives the same results to the last bit.

The history takes 5 MB a minute at 30 frames a second and 120 rows of 160; of
particles less than 1 MB.

With --recognise semaphore the letter that is shown stands over the picture, and
the text below it; without a window every letter is a line on standard output
as soon as it ends. letters.json and the text at the end are of the history; the
text comes after "..." where there was more. The person network sees the arms,
in sleeves or bare, with flags or without. Where it is not, look at the camera
for three seconds first, with bare forearms: the skin's colour is learned from
the face.

Examples:
  choreoscope live rehearsal.mp4
  choreoscope live 'synthetic://jumping-jacks?duration=60' --history 1min
  choreoscope live show.mkv --headless --pace max --out out/show
  choreoscope live v4l2:// --recognise semaphore

Exit status: 0 done or the window was closed, 1 failed while running, 2 refused,
130 interrupted: what is in the history is written.)";

// What there is of somebody, in a few words.
std::string seen_of(const pipeline::Observation& o) {
  if (o.mask.learning) return "learning the wall";
  if (!o.state) return "no body";
  if (o.signal && o.signal->of_looks) return o.person ? "arms are seen" : "no arms";
  if (o.skin_learned < 1 && o.face) return fmt::format("learning the skin, {:.0f} %", 100 * o.skin_learned);
  if (std::isfinite(o.zstar_row.back())) return fmt::format("Z*(t,t) {:.2f}", o.zstar_row.back());
  switch (o.arms.found) {
    case vision::ArmCase::kNoFace:
      return "no face";
    case vision::ArmCase::kNoArm:
      return "no arms";
    default:
      return "one arm";
  }
}

// What the window says beside the key, twice a second.
class FigureLines {
 public:
  explicit FigureLines(const pipeline::RunMonitor& monitor) : monitor_(monitor) {}

  /// The lines, or nothing where the last ones are fresh enough.
  std::optional<std::vector<std::string>> next(const pipeline::Observation& o, Nanoseconds now) {
    ++frames_;
    if (last_ && now - *last_ < std::chrono::milliseconds(500)) return std::nullopt;
    const double rate = last_ ? double(frames_) / to_seconds(now - *last_) : 0.0;
    last_ = now;
    frames_ = 0;
    const auto latency = monitor_.latency();
    std::vector<std::string> lines;
    lines.push_back(seen_of(o));
    if (rate > 0) lines.push_back(fmt::format("{:.1f} frames/s", rate));
    lines.push_back(
        fmt::format("latency {:.1f} ms, p99 {:.1f} ms", 1e3 * to_seconds(latency.p50), 1e3 * to_seconds(latency.p99)));
    lines.push_back(fmt::format("{} dropped", monitor_.dropped()));
    lines.push_back(fmt::format("{} rows of history", o.z_row.size()));
    return lines;
  }

 private:
  const pipeline::RunMonitor& monitor_;
  std::uint64_t frames_ = 0;
  std::optional<Nanoseconds> last_;
};

// SIGUSR1 asks for a report as long as this lives.
class ReportOnSignal {
 public:
  ReportOnSignal(Interrupt& interrupt, std::function<void()> report) : interrupt_(interrupt) {
    interrupt_.on_report(std::move(report));
  }
  ~ReportOnSignal() { interrupt_.on_report({}); }
  ReportOnSignal(const ReportOnSignal&) = delete;
  ReportOnSignal& operator=(const ReportOnSignal&) = delete;

 private:
  Interrupt& interrupt_;
};

std::size_t ring_capacity(Nanoseconds length, double nominal_fps) {
  constexpr double kUndeclared = 30;
  return std::size_t(
      std::max(1.0, std::ceil(to_seconds(length) * (nominal_fps > 0 ? nominal_fps : kUndeclared) - 1e-6)));
}

Nanoseconds history_length(const LiveOptions& options) {
  constexpr auto kLongest = std::chrono::hours(24);
  Nanoseconds length{0};
  try {
    length = parse_duration(options.history);
  } catch (const Error& error) {
    throw usage_error(error.what(), "--history", error.hint());
  }
  if (length < std::chrono::seconds(1) || length > kLongest) {
    throw usage_error(fmt::format("is {}", options.history), "--history",
                      "--history is a duration from 1s to 24h, such as 10min");
  }
  return length;
}

// A ring that swaps would make every frame wait for the disk, and one that is killed at the end would leave nothing.
void require_memory(const LiveOptions& options, std::uint64_t ring) {
  // With results to write, the rows are compared from a copy that is laid out otherwise.
  auto bytes = options.out.empty() ? ring : 3 * ring;
  if (!options.record.empty()) bytes += default_take_options().queue_bytes;
  const auto free = available_memory();
  if (!free || bytes <= *free / 10 * 8) return;  // The rest is for pictures and everybody else.
  throw usage_error(fmt::format("is {}, which takes {:.1f} GB of memory, and {:.1f} GB are free", options.history,
                                1e-9 * double(bytes), 1e-9 * double(*free)),
                    "--history", "shorten --history, or lower working.rows with --set");
}

std::unique_ptr<outputs::LiveWindow> open_window(const LiveOptions& options, const Summary& summary,
                                                 Nanoseconds history, Session& session, std::stop_source& closed,
                                                 const std::function<void()>& report, std::atomic<bool>& joints) {
  if (options.headless) return nullptr;
  if (!outputs::display_is_there()) {
    session.console.warn("there is no display: running as with --headless");
    return nullptr;
  }
  outputs::LiveWindowOptions window;
  window.title = summary.source.name + " - choreoscope";
  window.full_screen = options.full_screen;
  if (options.signals.reads()) window.leading = outputs::Leading::kVideo;  // Its letter is read from across a room.
  window.video = summary.source.size;
  window.history_s = to_seconds(history);
  window.on_close = [&closed] { closed.request_stop(); };
  window.on_report = report;
  window.on_joints = [&options, &session, &joints] {
    if (!options.joints) session.console.say("nobody looks for joints: start with --joints");
    joints = !joints;
  };
  window.on_lost = [&session](const std::string& why) {
    session.console.warn(why + ": the run goes on without its window");
  };
  return std::make_unique<outputs::LiveWindow>(std::move(window));
}

// A replay with other settings than those of its run has other results, and nothing else would say so.
void tell_other_settings(const devices::SourceInfo& source, const std::string& settings, Console& console) {
  if (source.settings.empty()) return;
  const auto others = config::differing(source.settings, settings);
  if (others.empty()) return;
  console.warn(fmt::format("the run that recorded this had other settings, and so other results: {}", others));
}

// Nothing where nothing is to be recorded.
std::unique_ptr<outputs::TakeWriter> start_recording(const LiveOptions& options, const devices::SourceInfo& source,
                                                     const std::string& settings, Console& console) {
  if (options.record.empty()) return nullptr;
  auto take = default_take_options();
  take.marks = true;
  take.settings = settings;
  // What is no device waits for the disk.
  if (!source.live) take.full = outputs::FullQueue::kWait;
  take.on_trouble = [&console](const std::string& why) {
    console.warn("the recording broke off, the run goes on: " + why);
  };
  return std::make_unique<outputs::TakeWriter>(options.record, source, take);
}

int live(const LiveOptions& options, Session& session) {
  auto& console = session.console;
  const pipeline::SteadyClock clock;
  const auto pace = pipeline::parse_pace(options.pace);
  const auto length = history_length(options);
  // A face and arms take more pixels than a silhouette, whose rows are all compared with every frame.
  const auto configured = [&](bool arms) {
    return options.source.configuration({{"working.rows", arms ? "480" : "120"}, {"background.from", "first:2s"}},
                                        "default of live");
  };
  const bool wants_arms = options.signals.particles() || options.signals.reads();
  auto config = configured(wants_arms);
  const auto& settings = config.options();
  Preparation prepared(options.source, settings, session, clock, !options.record.empty());
  auto& summary = prepared.summary;
  std::optional<outputs::OutputSet> files;
  if (!options.out.empty()) {
    files.emplace(options.out);
    std::vector<std::string> more;
    if (options.signals.reads()) more.emplace_back("letters.json");
    if (options.joints) std::ranges::copy(JointsRecord::files(settings), std::back_inserter(more));
    announce_files(summary, *files, settings, more);
  }
  const bool keeps_up = pace == pipeline::Pace::kLive || summary.source.live;
  std::unique_ptr<outputs::TakeWriter> take;
  const bool looks =
      options.joints || prepared.looks_for_people() || (options.signals.reads() && prepared.can_look());
  std::optional<SignalChain> chain;
  if (wants_arms) {
    std::function<void(std::uint64_t)> on_late;  // What does not keep up with a camera waits for faces, too.
    if (keeps_up) {
      on_late = [&take](std::uint64_t frame) {
        if (take) take->late_face(frame);
      };
    }
    chain.emplace(settings, options.signals.reads(), looks, std::move(on_late), length);
  }
  std::unique_ptr<pipeline::PersonStage> owned_person;
  if (looks) {
    std::function<void(std::uint64_t)> on_late;
    if (keeps_up) {
      on_late = [&take](std::uint64_t frame) {
        if (take) take->late_person(frame);
      };
    }
    owned_person = person_stage_beside(settings, options.signals.reads(), std::move(on_late));
  }
  const auto* person = owned_person.get();
  SignalTally tally(looks && options.signals.reads());
  const bool arms = chain && prepared.has_colour();
  if (chain && !arms) {
    tally.no_colour();
    config = configured(false);
    prepared.settings_changed();
  }
  const bool particles = arms && options.signals.particles();
  summary.particles = particles;
  const auto capacity = ring_capacity(length, summary.source.nominal_fps / double(summary.every));
  auto history_bytes = capacity * LiveHistory::bytes_per_row(particles, summary.working_size, prepared.kernel);
  if (options.joints && files) history_bytes += JointsRecord::bytes_of(capacity, to_seconds(length), settings);
  require_memory(options, history_bytes);
  if (files) {
    const auto expected = expected_frames(summary, prepared.selection, capacity);
    const auto frames = expected > 0 ? expected : capacity;
    files->require_space(space_for(frames, {}), fmt::format("the matrices of {} frames", frames));
  }
  take = start_recording(options, summary.source, config.values(), console);
  tell_other_settings(summary.source, config.values(), console);
  // What gives its frames once gives the first of them while the background is learned; the rest gives them anew.
  const auto record_source = [&] {
    if (take) prepared.source = std::make_unique<RecordedSource>(std::move(prepared.source), *take);
  };
  if (!summary.source.repeatable) record_source();
  auto masker = [&] {
    try {
      return prepared.learn();
    } catch (const Error&) {
      if (take) take->discard();  // There was no run.
      throw;
    }
  }();

  LiveHistory history(particles, summary.working_size, capacity, prepared.kernel);
  pipeline::RowCost row_cost;
  pipeline::RunMonitor monitor;
  const auto report = [&] {
    console.say(latency_heading());
    for (const auto& [name, latency] : monitor.stages()) console.say(latency_line(name, latency));
    console.say(latency_line("end to end", monitor.latency()));
    if (row_cost.full().count > 0) console.say(latency_line("row, full", row_cost.full()));
    console.say(fmt::format("{}, {} dropped", counted(monitor.latency().count, "frame"), monitor.dropped()));
  };

  // Ctrl-C and the window's closing both end the reading.
  std::stop_source ended;
  const std::stop_callback interrupted(prepared.stop, [&] {
    ended.request_stop();
    console.warn_later("interrupted: what was read is finished; again to leave nothing");
  });
  std::atomic<bool> joints_shown = true;  // The window's thread changes it.
  const auto window = open_window(options, summary, length, session, ended, report, joints_shown);
  const ReportOnSignal on_signal(session.interrupt, report);
  std::shared_ptr<void> shows_losses;
  if (window) {
    shows_losses =
        prepared.news.show_with([&window](std::vector<std::string> lines) { window->tell(std::move(lines)); });
  }
  FigureLines figures(monitor);
  std::uint64_t told = 0;
  const auto show = [&](const pipeline::Observation& o) {
    if (take) take->processed(o.frame->sequence);
    if (arms) tally.add(o);
    if (options.headless && o.signal) {
      tell_signs(o.signal->ended);
      told += o.signal->ended.size();
    }
    if (!window) return;
    constexpr int kShownRows = 480;  // More pixels than the video's corner of the page has.
    auto picture = pipeline::at_working_size(o.frame->bgr, pipeline::working_size(o.frame->bgr.size(), kShownRows));
    if (arms) {
      // Type that is drawn into few pixels is ragged in a large window.
      const auto size = picture.size() * kShownRows / picture.rows;
      if (picture.rows < kShownRows) cv::resize(picture, picture, size, 0, 0, cv::INTER_LINEAR);
      picture = outputs::drawn_over(picture, overlay_of(o, picture.size()));
    }
    if (o.person && options.joints && joints_shown) {
      const auto& look = o.person->smooth ? *o.person->smooth : o.person->look;
      picture = outputs::joints_drawn_over(picture, look, double(picture.cols) / o.picture.cols);
    }
    window->show(picture, o.mask.mask, to_seconds(o.time), o.z_row, o.zstar_row);
    if (auto lines = figures.next(o, clock.now())) window->tell(std::move(*lines));
  };

  std::vector<std::unique_ptr<pipeline::Stage>> stages;
  stages.push_back(std::make_unique<pipeline::PictureStage>(summary.working_size, masker.uses_depth()));
  if (owned_person) {
    stages.push_back(std::move(owned_person));
  }
  stages.push_back(std::make_unique<pipeline::MaskStage>(std::move(masker), others_of(settings)));
  stages.push_back(std::make_unique<pipeline::StateStage>(settings.motion_window_s));
  if (chain) chain->add_to(stages, arms);
  stages.push_back(history.stage(length, clock, &row_cost));
  const JointsRecord* joints = nullptr;
  if (options.joints && files) {
    auto joints_record = std::make_unique<JointsRecord>(JointsRecord::Keeps::kHistory);
    joints = joints_record.get();
    stages.push_back(std::move(joints_record));
  }
  auto owned_record = std::make_unique<LiveRecordStage>(
      ThumbnailKeeper(settings.plot.thumbnails, settings.plot.thumbnails_at_s), particles, show);
  auto& record = *owned_record;
  stages.push_back(std::move(owned_record));

  prepared.source =
      pipeline::at_pace(pace, std::move(prepared.source), clock, pipeline::sleep_until, prepared.selection);
  if (summary.source.repeatable) record_source();
  pipeline::RunnerOptions run;
  run.threads = summary.threads;
  run.queue_capacity = 2;  // A few frames in flight: each waiting one is a frame time of latency.
  run.at_reader = keeps_up ? pipeline::Overflow::kDropOldest : pipeline::Overflow::kBlock;
  run.monitor = &monitor;
  summary.run = pipeline::run(*prepared.source, prepared.selection, stages, run, clock, ended.get_token());
  std::exception_ptr recording_problem;
  try {
    const auto recorded = take ? take->close() : outputs::TakeReport{};
    if (recorded.frames > 0) {
      warn_of_gaps(recorded, console);
      console.say(take_line(options.record, recorded));
    }
  } catch (const Error&) {
    recording_problem = std::current_exception();
  }
  summary.run.interrupted = prepared.stop.stop_requested();
  const auto& ring = history.ring();
  summary.live = LiveSummary{options.pace,        to_seconds(length), ring.capacity(), ring.bytes_per_row(),
                             ring.memory_bytes(), ring.size(),        row_cost.full(), row_cost.filling()};
  if (chain) {
    chain->finish();
    tally.searched(chain->face().asked(), chain->face().late());
    if (options.headless && options.signals.reads()) {
      const std::span signs(chain->semaphore()->signs());
      tell_signs(signs.last(std::min<std::size_t>(signs.size(), chain->semaphore()->ended() - told)));
    }
  }

  if (summary.run.frames > 0) {
    for (const auto& line : live_table(summary)) console.say(line);
  }
  // What was seen until a failure is worth as much as what was seen until Ctrl-C; unless it was the last stage that
  // failed, which then lacks rows that the history has.
  const auto& ran = summary.run.stages;
  const bool whole = ran[ran.size() - 2].frames == ran.back().frames && ring.size() == record.rows().size();
  summary.sudden_changes_s = record.sudden_changes_s();
  record.masks_tally().tell(summary);
  const auto gathered = [&]() -> Gathered {
    return {record.rows(),           {}, record.bodies(), record.cut_bodies(), prepared.source->warnings(),
            tally.warnings(settings)};
  };
  if (!files && ring.size() > 0) {
    sum_up(summary, settings, gathered());
    tell_frames(summary, console);
  } else if (files && whole && ring.size() > 0) {
    const auto comparer = history.comparer(record);
    summary.canvas = history.canvas();
    if (options.signals.reads()) outputs::write_file(files->add("letters.json"), letters_json(*chain));
    if (joints != nullptr) joints->write(*files, settings);
    auto results = gathered();
    results.thumbnails = record.thumbnails().chosen(results.rows.front().time_s);
    write_results(summary, config, *comparer, std::move(results), nullptr, *files, session, clock);
    tell_results(summary, *files, console);
  }
  if (options.signals.reads()) tell_reading(*chain, tally, console);
  if (person != nullptr) {
    const auto seconds = to_seconds(summary.run.wall);
    const auto few = few_looks(*person, settings, seconds, summary.run.frames);
    if (few && keeps_up) console.warn(*few);
  }
  if (summary.run.problem) std::rethrow_exception(summary.run.problem);
  if (ring.size() == 0 && !ended.stop_requested()) {
    throw usage_error(fmt::format("no frame of \"{}\" is chosen: it has {}", summary.source.name,
                                  counted(summary.run.frames_read, "frame")),
                      options.source.span ? "--span " + *options.source.span : "",
                      "choose a span inside the recording");
  }
  if (recording_problem) std::rethrow_exception(recording_problem);
  return prepared.stop.stop_requested() ? kInterrupted : kDone;
}

}  // namespace

void declare_live(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<LiveOptions>();
  auto* command = app.add_subcommand("live", "show Z and Z* against the last minutes while the body moves");
  options->source.declare(*command);
  options->signals.declare(*command);
  command->add_flag("--joints", options->joints, "look for the person's joints and show them (docs/people.md)");
  command->add_option("--pace", options->pace, "live, replay or max; see below (default live)")->type_name("PACE");
  command->add_option("--history", options->history, "how far back a frame is compared (1s to 24h, default 10min)")
      ->type_name("T");
  auto* headless = command->add_flag("--headless", options->headless, "no window");
  command->add_flag("--full-screen", options->full_screen, "the window fills the screen, for a projector")
      ->excludes(headless);
  auto* out = command->add_option("--out", options->out, "the folder to write to at the end; made where it is missing")
                  ->type_name("DIR");
  auto* record =
      command->add_option("--record", options->record, "record what the source gives, in .mkv")->type_name("TAKE");
  command->footer(kLiveManual);
  command->callback([options, out, record, &chosen] {
    if (out->count() > 0 && options->out.empty()) throw usage_error("is empty", "--out", "name the folder to write to");
    if (record->count() > 0 && options->record.empty()) throw usage_error("is empty", "--record", "name a file");
    chosen = [options](Session& session) { return live(*options, session); };
  });
}

}  // namespace choreo::cli

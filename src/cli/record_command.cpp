// SPDX-License-Identifier: Apache-2.0
// choreoscope record: what a device gives, into a file, as it came.
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/device_news.hpp"
#include "cli/drivers.hpp"
#include "cli/take_recording.hpp"
#include "core/text.hpp"
#include "devices/fourcc.hpp"
#include "devices/media/kinect_depth.hpp"
#include "outputs/kinect_dump_writer.hpp"
#include "pipeline/steady_clock.hpp"

namespace choreo::cli {
namespace {

struct RecordOptions {
  std::string source;
  std::string out;
  std::string streams = "colour,depth";
  std::string codec = "auto";
  std::string duration;
  bool force = false;
  std::string only_of_takes;  // An option that was given and makes no sense for a dump.
};

constexpr auto kRecordManual = R"(
What the device gives is stored, never converted: JPEG packets as they are, raw
pictures and depth without loss, with the exact time and number of every frame.
The take is a Matroska file that any player shows. While it is being recorded it
is called TAKE.unfinished.mkv, and stays readable under that name after a crash.
Ctrl-C ends the recording and finishes the file.

  --codec auto     ffv1 where this machine keeps up with it, else ffvhuff
  --codec ffv1     the smallest file, about 16 ms a 640x480 picture and core
  --codec ffvhuff  about 2 ms, and a fifth to a quarter larger

SOURCE is anything that can be read, so this also imports dumps and recordings.
Everything reads a take again: analyze take.mkv, live take.mkv, record take.mkv.

An output that ends in / is a folder, and gets a Kinect's dump as libfreenect's
fakenect plays it: 640x480 pictures with depth. Depth that lies on the colour
already is to be read back with kinect-dump:DIR?depth=raw.

Examples:
  choreoscope record v4l2:///dev/video0 -o rehearsal.mkv
  choreoscope record v4l2:///dev/video0 -o short.mkv --duration 10s --force
  choreoscope record 'synthetic://walking?seed=2' -o walking.mkv --codec ffvhuff
  choreoscope record take.mkv -o dump/

Exit status: 0 done, 1 failed while recording (what came before is in
TAKE.unfinished.mkv), 2 refused, 130 interrupted: the take is finished.)";

outputs::TakeOptions take_options(const RecordOptions& options) {
  auto take = default_take_options();
  try {
    take.codec = outputs::parse_take_codec(options.codec);
  } catch (const Error& error) {
    throw usage_error(error.what(), "--codec", error.hint());
  }
  take.colour = take.depth = false;
  std::string_view rest = options.streams;
  while (true) {
    const auto name = rest.substr(0, rest.find(','));
    if (name != "colour" && name != "depth") {
      throw usage_error(fmt::format("\"{}\" is no stream", one_line(name)), "--streams",
                        "write colour, depth or colour,depth");
    }
    (name == "colour" ? take.colour : take.depth) = true;
    if (name.size() == rest.size()) break;
    rest.remove_prefix(name.size() + 1);
  }
  take.force = options.force;
  take.if_there = "choose another name, or replace it with --force";
  return take;
}

std::optional<Nanoseconds> duration_of(const RecordOptions& options) {
  if (options.duration.empty()) return std::nullopt;
  Nanoseconds duration{0};
  try {
    duration = parse_duration(options.duration);
  } catch (const Error& error) {
    throw usage_error(error.what(), "--duration", error.hint());
  }
  if (duration <= Nanoseconds{0}) throw usage_error("is no time at all", "--duration", "write 10s or 2min");
  return duration;
}

// Where the frames go.
class Recording {
 public:
  virtual ~Recording() = default;
  virtual void add(const devices::FramePtr& frame) = 0;
  // Says what was recorded. @return how many frames.
  virtual std::uint64_t finish(Console& console) = 0;
};

class TakeRecording final : public Recording {
 public:
  TakeRecording(const RecordOptions& options, const devices::SourceInfo& source, outputs::TakeOptions take)
      : path_(options.out), writer_(options.out, source, std::move(take)) {}
  void add(const devices::FramePtr& frame) override { writer_.add(frame); }
  std::uint64_t finish(Console& console) override {
    const auto report = writer_.close();
    warn_of_gaps(report, console);
    if (report.frames > 0) fmt::print("{}\n", take_line(path_, report));
    return report.frames;
  }

 private:
  std::string path_;
  outputs::TakeWriter writer_;
};

class DumpRecording final : public Recording {
 public:
  DumpRecording(const RecordOptions& options, const devices::SourceInfo& source)
      : path_(options.out), turned_(!source.raw_orientation.is_identity()), writer_(options.out) {}
  void add(const devices::FramePtr& frame) override {
    // Dumps know no times before 0, which a take's clock may have.
    if (!first_) first_ = frame->device_time;
    const auto time = frame->device_time - *first_ + std::chrono::seconds(1);
    writer_.write_colour(frame->bgr, time);
    ++frames_;
    // The words are as the device gave them: of a turned source they would not lie where its colours are.
    if (frame->raw_depth && frame->raw_depth->fourcc == devices::kKinectDepth && !turned_) {
      writer_.write_words(frame->raw_depth->bytes, time);
    } else if (!frame->depth.empty()) {
      writer_.write_depth(frame->depth, time);
    } else {
      return;
    }
    ++depths_;
  }
  std::uint64_t finish(Console& console) override {
    if (frames_ > 0) fmt::print("{}: {} colour and {} depth pictures\n", path_, frames_, depths_);
    if (frames_ > 0 && depths_ == 0) console.warn("there was no depth: fakenect plays only dumps that have both");
    return frames_;
  }

 private:
  std::string path_;
  bool turned_;
  outputs::KinectDumpWriter writer_;
  std::optional<Nanoseconds> first_;
  std::uint64_t frames_ = 0;
  std::uint64_t depths_ = 0;
};

// What a dump cannot do, before anything is opened.
void require_dump_options(const RecordOptions& options) {
  if (!options.out.ends_with('/') || options.only_of_takes.empty()) return;
  throw usage_error("is of takes alone, and \"" + options.out + "\" will be a dump", options.only_of_takes,
                    "leave it out, or record a take: -o take.mkv");
}

void require_a_kinects_size(const devices::SourceInfo& source) {
  if (source.size == devices::kKinectSize) return;
  throw usage_error(fmt::format("\"{}\" has pictures of {}x{}: a dump has 640x480", source.name, source.size.width,
                                source.size.height),
                    {}, "record it as a take: -o take.mkv");
}

// Reads until the end, a stop or the duration. @return what broke the source, if anything.
std::exception_ptr read_all(devices::Source& source, std::optional<Nanoseconds> duration, Recording& recording,
                            Console& console, const std::function<void()>& begins, const std::stop_token& stop) {
  const auto whole = duration ? duration : source.info().duration;
  std::optional<Nanoseconds> first;
  try {
    while (const auto frame = source.read(stop)) {
      if (!first) {
        first = frame->device_time;
        begins();
      }
      const auto time = frame->device_time - *first;
      if (duration && time >= *duration) break;
      if (!frame->overtaken) recording.add(frame);
      console.progress("recording", whole ? to_seconds(time) / to_seconds(*whole) : -1.0);
    }
  } catch (const Error&) {
    return std::current_exception();
  }
  return nullptr;
}

int record(const RecordOptions& options, Session& session) {
  auto& console = session.console;
  const pipeline::SteadyClock clock;
  auto take = take_options(options);
  require_dump_options(options);
  const auto duration = duration_of(options);
  const auto interrupt = session.interrupt.orderly();
  std::stop_source ended;
  const std::stop_callback interrupted(interrupt, [&] { ended.request_stop(); });

  const auto registry = all_drivers(clock);
  devices::OpenOptions open;
  open.stop = interrupt;
  open.keep_raw = true;
  open.every_frame = true;
  DeviceNews news(console);
  open.on_event = [&](const devices::DeviceEvent& event) {
    news.hear(devices::without_password(options.source), event);
  };
  std::unique_ptr<devices::Source> source;
  try {
    source = registry.open(options.source, open);
  } catch (const Error&) {
    if (interrupt.stop_requested()) throw Interrupted{};
    throw;
  }
  // What is no device waits for the encoder.
  const bool live = source->info().live;
  take.full = live ? outputs::FullQueue::kLeaveOut : outputs::FullQueue::kWait;
  take.on_trouble = [&](const std::string&) { ended.request_stop(); };
  std::unique_ptr<Recording> recording;
  if (options.out.ends_with('/')) {
    require_a_kinects_size(source->info());
    recording = std::make_unique<DumpRecording>(options, source->info());
  } else {
    recording = std::make_unique<TakeRecording>(options, source->info(), std::move(take));
  }
  // A device that is lost gives no frame by whose time one could see that the duration is over.
  std::jthread timer;
  const auto begins = [&] {
    if (!duration || !live) return;
    timer = std::jthread([&, until = clock.now() + *duration + std::chrono::seconds(1)](const std::stop_token& stop) {
      if (pipeline::sleep_until(until, stop)) ended.request_stop();
    });
  };
  const auto problem = read_all(*source, duration, *recording, console, begins, ended.get_token());
  console.finish_progress();
  const auto frames = recording->finish(console);
  for (const auto& warning : source->warnings()) console.warn(warning);
  if (problem) std::rethrow_exception(problem);
  if (frames == 0) {
    if (interrupt.stop_requested()) throw Interrupted{};
    throw failure(fmt::format("\"{}\" gave no frame to record", source->info().name));
  }
  if (!interrupt.stop_requested()) return kDone;
  console.warn("interrupted: the recording is finished");
  return kInterrupted;
}

}  // namespace

void declare_record(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<RecordOptions>();
  auto* command = app.add_subcommand("record", "record what a device gives, as it came");
  command->add_option("SOURCE", options->source, "as of analyze: a device, a recording, synthetic://SCRIPT")
      ->required();
  command->add_option("-o,--out", options->out, "the take to write, in .mkv; DIR/ for a Kinect's dump")
      ->required()
      ->type_name("TAKE");
  auto* streams = command->add_option("--streams", options->streams, "colour, depth or both (default colour,depth)")
                      ->type_name("WHAT");
  auto* codec = command->add_option("--codec", options->codec, "auto, ffv1 or ffvhuff; see below (default auto)")
                    ->type_name("CODEC");
  command->add_option("--duration", options->duration, "end after so long: 10s, 2min (default: at the source's end)")
      ->type_name("T");
  auto* force = command->add_flag("--force", options->force, "replace a finished take of this name");
  command->footer(kRecordManual);
  command->callback([options, streams, codec, force, &chosen] {
    for (const auto* option : {streams, codec, force}) {
      if (option->count() > 0) options->only_of_takes = option->get_name();
    }
    chosen = [options](Session& session) { return record(*options, session); };
  });
}

}  // namespace choreo::cli

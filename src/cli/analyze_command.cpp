// SPDX-License-Identifier: Apache-2.0
// choreoscope analyze: a recording in, its Z and Z* plots, matrices and tables out.
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <tbb/global_control.h>

#include "cli/commands.hpp"
#include "cli/drivers.hpp"
#include "cli/recording.hpp"
#include "cli/source_options.hpp"
#include "cli/summary.hpp"
#include "devices/image_folder/picture_check.hpp"
#include "outputs/output_set.hpp"
#include "pipeline/stages/silhouette_stages.hpp"
#include "pipeline/steady_clock.hpp"
#include "pipeline/working_size.hpp"
#include "similarity/all_pairs.hpp"
#include "similarity/mask_comparer.hpp"

namespace choreo::cli {
namespace {

struct AnalyzeOptions {
  SourceOptions source;
  std::string out;
  std::vector<std::string> save;
};

constexpr auto kManual = R"(
What it writes into DIR:
  plot.png       Z in red and Z* in cyan, time to the right and down; white on
                 the diagonal is a mirror-symmetric pose, red an asymmetric one
  triangle.png   the same with the identity axis horizontal and the lag upwards
  z.npy          similarity of every pair of frames, float32, N x N, NaN where
  zstar.npy      there is no body; and the same with mirror images
  times.npy      float64, N: seconds since the source's first frame
  frames.csv     one row a frame: body, area, centroid, box, motion, symmetry
  masks.npy      with --save masks: uint8 0/1, N x H x W
  summary.json   source, sizes, settings, warnings, timings
Nothing is written under these names before all of it is complete.

Examples:
  choreoscope analyze rehearsal.mp4 --out out/rehearsal
  choreoscope analyze stage.mkv --out out/stage --background empty-stage.png
  choreoscope analyze long.mkv --out out/long --every 5 --span 60:180
  choreoscope analyze 'synthetic://jumping-jacks?seed=3' --out out/jacks
  choreoscope analyze clip.mkv --out out/clip --set mask.threshold=18

Exit status: 0 done, 1 failed while running, 2 refused (usage, configuration,
source), 130 interrupted: what was computed until then is written.)";

// A picture of the empty room; colour, 8 bit, whatever the file has.
cv::Mat read_plate(const std::string& path) {
  cv::Mat plate;
  try {
    // A pipe or a device may never end.
    std::error_code problem;
    std::ifstream file;
    if (std::filesystem::is_regular_file(path, problem)) file.open(path, std::ios::binary);
    const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    // Half a picture would be half a room.
    if (devices::is_whole_picture(bytes)) plate = cv::imdecode(bytes, cv::IMREAD_COLOR);
  } catch (const std::ios_base::failure&) {
    // A folder, or a disk that does not answer: the picture stays empty.
  } catch (const cv::Exception&) {
    // The same.
  }
  if (plate.empty()) {
    throw usage_error(fmt::format("the plate \"{}\" is no picture that can be read", path), {},
                      "--background takes auto, first:1s, or the path of a PNG, JPEG, TIFF or the like");
  }
  return plate;
}

std::vector<std::string> warnings_of(const Summary& s, const config::Options& settings, const RecordStage& record,
                                     std::vector<std::string> of_source) {
  auto warnings = std::move(of_source);
  const auto& size = s.source.size;
  if (std::max(size.width, size.height) > 4096) {
    warnings.push_back(fmt::format("frames of {} x {} pixels are looked at at {} x {} (working.rows)", size.width,
                                   size.height, s.working_size.width, s.working_size.height));
  }
  if (!s.sudden_changes_s.empty()) {
    // A strobe would fill the screen: the first few say enough, and the summary has them all.
    constexpr std::size_t kShown = 5;
    const auto shown = std::min(kShown, s.sudden_changes_s.size());
    const std::span first(s.sudden_changes_s.data(), shown);
    warnings.push_back(fmt::format("the whole picture changed at {:.2f} s{}: the background was learned anew",
                                   fmt::join(first, ", "),
                                   shown < s.sudden_changes_s.size()
                                       ? fmt::format(" and {} times more", s.sudden_changes_s.size() - shown) : ""));
  }
  const auto beyond = std::find_if(settings.plot.thumbnails_at_s.begin(), settings.plot.thumbnails_at_s.end(),
                                   [&](double t) { return t > s.last_time_s; });
  if (beyond != settings.plot.thumbnails_at_s.end()) {
    warnings.push_back(fmt::format("plot.thumbnails_at_s: {} s lies behind the last frame, at {:.3f} s", *beyond,
                                   s.last_time_s));
  }
  // One cause, one warning: the later ones would only repeat the first that applies.
  if (s.frames == 1) {
    warnings.emplace_back("there is only one frame: nothing to compare it with");
  } else if (record.bodies() == 0) {
    warnings.emplace_back("no body was ever seen: Z and Z* are all NaN (see mask.threshold and mask.min_body_percent)");
  } else {
    if (s.background.uncertain()) {
      warnings.push_back(fmt::format(
          "the background is uncertain: {:.0f} % of the body stands before wall that was never seen, {:.0f} % of its pixels "
          "were decided by inference; give a plate with --background, or leave the room empty for a second; if something "
          "else moves, see mask.roi and mask.ignore", 100.0 * s.background.unseen, 100.0 * s.inferred));
    }
    if (record.cut_bodies() > 0) {
      warnings.push_back(fmt::format("the body is cut by the picture's border in {} of {} frames", record.cut_bodies(),
                                     record.bodies()));
    }
  }
  return warnings;
}

outputs::PlotOptions plot_options(const Summary& s, const config::PlotSettings& settings, outputs::PlotForm form) {
  outputs::PlotOptions options;
  options.form = form;
  options.channels = settings.channels == "z"       ? outputs::PlotChannels::kZ
                     : settings.channels == "zstar" ? outputs::PlotChannels::kZstar
                                                    : outputs::PlotChannels::kBoth;
  options.width_px = settings.width_px;
  if (settings.contrast == "auto") options.range.reset();
  options.dark = settings.page == "dark";
  // Where a recording lies is nobody's business who reads the paper.
  options.title = std::filesystem::path(s.source.name.substr(0, s.source.name.find('?'))).filename().string();
  if (options.title.empty() || s.source.name.find("://") != std::string::npos) options.title = s.source.name;
  if (s.background.uncertain()) {
    options.subtitle = fmt::format("uncertain background: {:.0f} % of the body before wall never seen", 100.0 * s.background.unseen);
  }
  return options;
}

int analyze(const AnalyzeOptions& options, Session& session) {
  auto& console = session.console;
  const auto config = options.source.configuration();
  const auto& settings = config.options();
  const auto selection = options.source.selection();
  const bool save_masks = std::find(options.save.begin(), options.save.end(), "masks") != options.save.end();
  const auto kernel = similarity::choose_and_count([] {
    const auto* forced = std::getenv("CHOREO_FORCE_ISA");
    return std::string(forced == nullptr ? "" : forced);
  }());

  Summary summary;
  summary.threads = options.source.threads > 0 ? options.source.threads : cv::getNumberOfCPUs();
  summary.instruction_set = kernel.name;
  const tbb::global_control cores(tbb::global_control::max_allowed_parallelism, std::size_t(summary.threads));
  cv::setNumThreads(summary.threads);

  const pipeline::SteadyClock clock;
  const auto registry = all_drivers();
  const auto stop = session.interrupt.orderly();
  const auto open = [&] {
    try {
      return registry.open(options.source.source, {options.source.threads, stop});
    } catch (const Error&) {
      if (stop.stop_requested()) throw Interrupted{};
      throw;
    }
  };
  auto source = open();
  summary.source = source->info();
  summary.span = options.source.span.value_or("");
  summary.every = selection.every;
  summary.working_size = pipeline::working_size(summary.source.size, settings.working_rows);

  const auto spec = pipeline::parse_background(settings.background);
  const auto plate = spec.kind == pipeline::BackgroundSpec::Kind::kPlate ? read_plate(spec.plate) : cv::Mat();
  if (options.out.empty()) throw usage_error("is empty", "--out", "name the folder to write to");
  outputs::OutputSet files(options.out);
  summary.files = {"plot.png", "triangle.png", "z.npy", "zstar.npy", "times.npy", "frames.csv", "summary.json"};
  if (settings.plot.svg) summary.files.insert(summary.files.end(), {"plot.svg", "triangle.svg"});
  if (save_masks) summary.files.emplace_back("masks.npy");
  for (const auto& name : summary.files) files.check(name);

  // 1. The wall.
  auto start = clock.now();
  auto learned = pipeline::learn_background(
      std::move(source), spec, plate, settings.working_rows, open,
      [&](double share) { console.progress("learning the background", share); }, stop,
      settings.mask.infer_unseen);
  console.finish_progress();
  if (!learned) throw Interrupted{};
  // Said at once, whatever is being done: people press again where nothing answers.
  const std::stop_callback answer(stop, [&] {
    console.warn("interrupted: what was read is finished and written; again to leave nothing");
  });
  summary.learn_wall = clock.now() - start;
  summary.background = learned->estimate;
  summary.background_pictures = learned->pictures;

  // 2. The frames.
  std::optional<outputs::NpyPictures> masks;
  if (save_masks) masks.emplace(files.add("masks.npy"), summary.working_size);
  vision::BodyMasker masker(learned->estimate, settings.mask);
  summary.threshold = masker.threshold();
  // Files lie about their length and spans reach beyond it: the bar is for people, and need not be exact.
  const auto end = std::min(summary.source.duration.value_or(Nanoseconds::max()), selection.to);
  const auto seen = [&](Nanoseconds time) {
    const auto to_do = to_seconds(end - selection.from);
    console.progress("reading frames", end == Nanoseconds::max() ? -1.0 : to_seconds(time - selection.from) / to_do);
  };
  std::vector<std::unique_ptr<pipeline::Stage>> stages;
  stages.push_back(std::make_unique<pipeline::PictureStage>(summary.working_size));
  stages.push_back(std::make_unique<pipeline::MaskStage>(std::move(masker)));
  stages.push_back(std::make_unique<pipeline::StateStage>(settings.motion_window_s));
  auto owned_record = std::make_unique<RecordStage>(ThumbnailKeeper(settings.plot.thumbnails, settings.plot.thumbnails_at_s),
                                                    masks ? &*masks : nullptr, seen);
  auto& record = *owned_record;
  stages.push_back(std::move(owned_record));
  summary.run = pipeline::run(*learned->source, selection, stages, {summary.threads}, clock, stop);
  console.finish_progress();
  if (summary.run.problem) std::rethrow_exception(summary.run.problem);
  auto& rows = record.rows();
  if (rows.empty()) {
    if (summary.run.interrupted) throw Interrupted{};
    throw usage_error(fmt::format("no frame of \"{}\" is chosen: it has {} frames", summary.source.name,
                                  summary.run.frames_read), options.source.span ? "--span " + *options.source.span : "",
                      "choose a span inside the recording");
  }

  // 3. All pairs.
  start = clock.now();
  const similarity::MaskComparer comparer(record.states(), kernel);
  summary.canvas = comparer.canvas();
  const std::size_t n = rows.size();
  const outputs::NpyMatrix z(files.add("z.npy"), n, n);
  const outputs::NpyMatrix zstar(files.add("zstar.npy"), n, n);
  const bool complete = similarity::all_pairs(comparer, z.view(), zstar.view(), session.interrupt.now(),
                                              [&](double share) { console.progress("comparing all pairs", share); });
  console.finish_progress();
  if (!complete) throw Interrupted{};
  std::vector<double> times;
  for (std::size_t i = 0; i < n; ++i) {
    rows[i].zstar_tt = zstar.view()(i, i);
    times.push_back(rows[i].time_s);
  }
  summary.pairs_wall = clock.now() - start;

  // 4. Tables and plots.
  start = clock.now();
  outputs::write_npy(files.add("times.npy"), times);
  outputs::write_file(files.add("frames.csv"), outputs::frames_csv(rows));
  if (masks) masks->close();
  const auto thumbnails = record.thumbnails().chosen();
  for (const auto& [name, form] : {std::pair{"plot", outputs::PlotForm::kSquare}, std::pair{"triangle", outputs::PlotForm::kTriangle}}) {
    if (session.interrupt.now().stop_requested()) throw Interrupted{};
    console.progress("drawing", form == outputs::PlotForm::kSquare ? 0.0 : 0.5);
    const outputs::Plot plot({z.view(), zstar.view(), times, thumbnails}, plot_options(summary, settings.plot, form));
    plot.write_png(files.add(std::string(name) + ".png"));
    if (settings.plot.svg) plot.write_svg(files.add(std::string(name) + ".svg"));
  }
  console.finish_progress();
  summary.plots_wall = clock.now() - start;

  // 5. What is to be known about it.
  summary.frames = n;
  summary.frames_without_body = n - record.bodies();
  summary.frames_with_body_cut = record.cut_bodies();
  summary.inferred = record.body_pixels() > 0 ? record.inferred_pixels() / record.body_pixels() : 0;
  summary.first_time_s = times.front();
  summary.last_time_s = times.back();
  summary.sudden_changes_s = record.sudden_changes_s();
  summary.interrupted = summary.run.interrupted;
  summary.warnings = warnings_of(summary, settings, record, learned->source->warnings());
  outputs::write_file(files.add("summary.json"), to_json(summary, config));
  if (session.interrupt.now().stop_requested()) throw Interrupted{};
  // What an earlier run wrote and this one did not would belong to another recording.
  for (const auto* name : {"masks.npy", "plot.svg", "triangle.svg"}) {
    if (std::find(summary.files.begin(), summary.files.end(), name) == summary.files.end()) files.supersede(name);
  }
  files.commit();

  for (const auto& line : timing_table(summary)) console.say(line);
  for (const auto& warning : summary.warnings) console.warn(warning);
  fmt::print("{} frame{}, {} with a body\n", n, n == 1 ? "" : "s", record.bodies());
  for (const auto& name : summary.files) fmt::print("{}\n", (files.folder() / name).string());
  // Also where all frames were read before: whoever stops a batch wants the batch to stop.
  return stop.stop_requested() ? kInterrupted : kDone;
}

}  // namespace

void declare_analyze(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<AnalyzeOptions>();
  auto* command = app.add_subcommand("analyze", "turn a recording into its Z and Z* plots, matrices and tables");
  options->source.declare(*command);
  command->add_option("--out", options->out, "the folder to write to; made where it is missing")->required()->type_name("DIR");
  command->add_option("--save", options->save, "also write: masks")->type_name("WHAT")->allow_extra_args(false)->check(CLI::IsMember({"masks"}));
  command->footer(kManual);
  command->callback([options, &chosen] { chosen = [options](Session& session) { return analyze(*options, session); }; });
}

}  // namespace choreo::cli

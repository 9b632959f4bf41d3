// SPDX-License-Identifier: Apache-2.0
#include "cli/results.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "cli/one_picture.hpp"
#include "similarity/all_pairs.hpp"

namespace choreo::cli {
namespace {

// What a run may write, and an earlier run may have left.
constexpr const char* kAllFiles[] = {"plot.png",     "triangle.png", "z.npy",      "zstar.npy",         "times.npy",
                                     "frames.csv",   "masks.npy",    "plot.svg",   "triangle.svg",      "particles.csv",
                                     "letters.json", "pictures.png", "joints.csv", "joints_smooth.csv", "summary.json"};

constexpr double kSomeOfThePicture = 0.01;

// As mask.ignore has them, of each part that is worth it, and of the largest.
std::vector<std::string> zones_of(const cv::Mat& area) {
  cv::Mat labels, statistics, centroids;
  const int count = cv::connectedComponentsWithStats(area, labels, statistics, centroids, 8, CV_32S, cv::CCL_SAUF);
  int largest = 0;
  for (int part = 1; part < count; ++part) largest = std::max(largest, statistics.at<int>(part, cv::CC_STAT_AREA));
  std::vector<std::string> zones;
  for (int part = 1; part < count; ++part) {
    const int pixels = statistics.at<int>(part, cv::CC_STAT_AREA);
    if (pixels < largest && pixels < kSomeOfThePicture / 4 * double(area.total())) continue;
    const double left = statistics.at<int>(part, cv::CC_STAT_LEFT), top = statistics.at<int>(part, cv::CC_STAT_TOP);
    zones.push_back(fmt::format("[{:.2f}, {:.2f}, {:.2f}, {:.2f}]", left / area.cols, top / area.rows,
                                (left + statistics.at<int>(part, cv::CC_STAT_WIDTH)) / area.cols,
                                (top + statistics.at<int>(part, cv::CC_STAT_HEIGHT)) / area.rows));
  }
  return zones;
}

std::vector<std::string> warnings_of(const Summary& s, const config::Options& settings, const Gathered& gathered) {
  auto warnings = gathered.source_warnings;
  const auto& size = s.source.size;
  if (std::max(size.width, size.height) > 4096) {
    warnings.push_back(fmt::format("frames of {} x {} pixels are looked at at {} x {} (working.rows)", size.width,
                                   size.height, s.working_size.width, s.working_size.height));
  }
  if (s.thinned_to_every > 1) {
    warnings.push_back(
        fmt::format("of {} frames every {}{} is kept, so that the matrices have at most {} rows (matrix.most_rows)",
                    s.run.frames, s.thinned_to_every, s.thinned_to_every == 2 ? "nd" : "th", settings.matrix_rows));
  }
  if (!s.sudden_changes_s.empty()) {
    // A strobe would fill the screen: the first few say enough, and the summary has them all.
    constexpr std::size_t kShown = 5;
    const auto shown = std::min(kShown, s.sudden_changes_s.size());
    const std::span first(s.sudden_changes_s.data(), shown);
    warnings.push_back(fmt::format(
        "the whole picture changed at {:.2f} s{}: the background was learned anew", fmt::join(first, ", "),
        shown < s.sudden_changes_s.size() ? fmt::format(" and {} times more", s.sudden_changes_s.size() - shown) : ""));
  }
  const auto beyond = std::find_if(settings.plot.thumbnails_at_s.begin(), settings.plot.thumbnails_at_s.end(),
                                   [&](double t) { return t > s.last_time_s; });
  if (beyond != settings.plot.thumbnails_at_s.end()) {
    warnings.push_back(
        fmt::format("plot.thumbnails_at_s: {} s lies behind the last frame, at {:.3f} s", *beyond, s.last_time_s));
  }
  warnings.insert(warnings.end(), gathered.signal_warnings.begin(), gathered.signal_warnings.end());
  if (s.background.camera == vision::CameraKind::kShakes) {
    const bool plate = settings.background != "auto" && !settings.background.starts_with("first:");
    warnings.emplace_back(
        !plate ? "the camera shakes: every picture was brought to where it was in one of them"
               : "the camera shakes, or stands elsewhere than the plate was taken from: every picture was "
                 "brought there");
  }
  if (s.camera_moved > 0) {
    warnings.push_back(
        fmt::format("the camera moved in {} % of the frames, or the room was not found again: in these a body is what "
                    "the person network sees, and by colour there is none",
                    s.camera_moved < 0.01 ? "less than 1" : fmt::format("{:.0f}", 100 * s.camera_moved)));
  }
  // One cause, one warning: the later ones would only repeat the first that applies.
  if (s.frames == 1) {
    warnings.emplace_back("there is only one frame: nothing to compare it with" +
                          (is_one_picture(s.source) ? std::string("; ") + kHowPicturesAreRead : ""));
  } else if (gathered.bodies == 0) {
    warnings.emplace_back(
        "no body was ever seen: Z and Z* are all NaN; somebody who never moves is taken for the wall: give a plate "
        "with "
        "--background, or see mask.threshold and mask.min_body_percent");
  } else {
    if (s.uncertain()) {
      warnings.push_back(fmt::format(
          "the background is uncertain: {:.0f} % of the body stands before wall that was never seen, {:.0f} % of "
          "its pixels were decided by inference; give a plate with --background, or leave the room empty for "
          "a second; if something else moves, see mask.roi and mask.ignore",
          100.0 * s.background.unseen, 100.0 * s.inferred));
    }
    if (const auto& dynamic = s.background.dynamic; dynamic.share() > kSomeOfThePicture) {
      warnings.push_back(
          fmt::format("{:.0f} % of the picture moves in place, as leaves in the wind do, and is body where its colours "
                      "are new; mask.ignore = [{}] leaves it out, and whoever passes there",
                      100 * dynamic.share(), fmt::join(zones_of(dynamic.area()), ", ")));
    }
    if (gathered.cut_bodies > 0) {
      warnings.push_back(fmt::format("the body is cut by the picture's border in {} of {} frames", gathered.cut_bodies,
                                     gathered.bodies));
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
  if (s.particles) options.gap = "no face or arms";
  // Where a recording lies is nobody's business who reads the paper.
  options.title = std::filesystem::path(s.source.name.substr(0, s.source.name.find('?'))).filename().string();
  if (options.title.empty() || s.source.name.find("://") != std::string::npos) options.title = s.source.name;
  if (s.uncertain()) {
    options.subtitle =
        fmt::format("uncertain background: {:.0f} % of the body before wall never seen, {:.0f} % decided by inference",
                    100.0 * s.background.unseen, 100.0 * s.inferred);
  }
  return options;
}

struct PlotOnItsWay {
  outputs::PlotOptions options;
  similarity::RasterReducer reducer;
};

}  // namespace

void announce_files(Summary& summary, const outputs::OutputSet& files, const config::Options& settings,
                    const std::vector<std::string>& more) {
  summary.files = {"plot.png", "triangle.png", "z.npy", "zstar.npy", "times.npy", "frames.csv", "summary.json"};
  if (settings.plot.svg) summary.files.insert(summary.files.end(), {"plot.svg", "triangle.svg"});
  summary.files.insert(summary.files.end(), more.begin(), more.end());
  for (const auto& name : summary.files) files.check(name);
}

std::size_t expected_frames(const Summary& summary, const pipeline::FrameSelection& selection, std::size_t most) {
  const auto& source = summary.source;
  if (!source.duration || source.nominal_fps <= 0) return 0;
  const double seconds = to_seconds(std::min(*source.duration, selection.to) - selection.from);
  double frames = std::max(0.0, std::ceil(seconds * source.nominal_fps));
  frames = std::min(frames, double(selection.last_frame) - double(selection.first_frame) + 1.0);
  return std::size_t(std::min(double(most), std::ceil(frames / double(selection.every))));
}

std::uintmax_t space_for(std::size_t frames, cv::Size masks) {
  const std::uintmax_t n = frames;
  return 2 * n * n * sizeof(float) + n * std::uintmax_t(masks.area());
}

void write_results(Summary& summary, const config::Config& config, const similarity::Comparer& states,
                   Gathered gathered, outputs::NpyPictures* masks, outputs::OutputSet& files, Session& session,
                   const Clock& clock) {
  auto& console = session.console;
  const auto& settings = config.options();
  auto& rows = gathered.rows;
  const std::size_t n = rows.size();

  std::vector<double> times;
  for (const auto& row : rows) times.push_back(row.time_s);
  auto start = clock.now();
  outputs::NpyMatrix z(files.add("z.npy"), n, n);
  outputs::NpyMatrix zstar(files.add("zstar.npy"), n, n);
  // The plots are reduced while the rows are there: nobody ever holds a whole matrix.
  std::vector<PlotOnItsWay> plots;
  for (const auto form : {outputs::PlotForm::kSquare, outputs::PlotForm::kTriangle}) {
    const auto options = plot_options(summary, settings.plot, form);
    plots.push_back({options, {form, times, outputs::raster_width_px(options)}});
  }
  const bool complete = similarity::pairs_by_bands(
      states,
      [&](similarity::Range band, MatrixView<const float> z_rows, MatrixView<const float> zstar_rows) {
        z.write_symmetric(band.begin, z_rows);
        zstar.write_symmetric(band.begin, zstar_rows);
        for (std::size_t i = 0; i < band.size(); ++i) {
          rows[band.begin + i].zstar_tt = zstar_rows(i, band.begin + i);
          for (auto& plot : plots) plot.reducer.add_row(band.begin + i, z_rows.row(i), zstar_rows.row(i));
        }
      },
      session.interrupt.now(), [&](double share) { console.progress("comparing all pairs", share); });
  console.finish_progress();
  if (!complete) throw Interrupted{};
  summary.pairs_wall = clock.now() - start;

  start = clock.now();
  outputs::write_npy(files.add("times.npy"), times);
  outputs::write_file(files.add("frames.csv"), outputs::frames_csv(rows));
  if (masks != nullptr) masks->close();
  for (auto& [options, reducer] : plots) {
    if (session.interrupt.now().stop_requested()) throw Interrupted{};
    const bool square = options.form == outputs::PlotForm::kSquare;
    console.progress("drawing", square ? 0.0 : 0.5);
    const std::string name = square ? "plot" : "triangle";
    const outputs::Plot plot(reducer.finish(), n, gathered.thumbnails, options);
    plot.write_png(files.add(name + ".png"));
    if (settings.plot.svg) plot.write_svg(files.add(name + ".svg"));
  }
  console.finish_progress();
  summary.plots_wall = clock.now() - start;

  sum_up(summary, settings, gathered);
  outputs::write_file(files.add("summary.json"), to_json(summary, config));
  if (session.interrupt.now().stop_requested()) throw Interrupted{};
  supersede_others(files, summary.files);
  files.commit();
}

void supersede_others(outputs::OutputSet& files, std::span<const std::string> written) {
  for (const auto* name : kAllFiles) {
    if (std::find(written.begin(), written.end(), name) == written.end()) files.supersede(name);
  }
}

void sum_up(Summary& summary, const config::Options& settings, const Gathered& gathered) {
  summary.frames = gathered.rows.size();
  summary.frames_without_body = summary.frames - gathered.bodies;
  summary.frames_with_body_cut = gathered.cut_bodies;
  summary.first_time_s = gathered.rows.front().time_s;
  summary.last_time_s = gathered.rows.back().time_s;
  summary.interrupted = summary.run.interrupted;
  summary.warnings = warnings_of(summary, settings, gathered);
}

void tell_frames(const Summary& summary, Console& console) {
  for (const auto& warning : summary.warnings) console.warn(warning);
  if (!summary.body.empty()) console.say("body: " + summary.body);
  fmt::print("{} frame{}, {} with a body\n", summary.frames, summary.frames == 1 ? "" : "s",
             summary.frames - summary.frames_without_body);
}

void tell_results(const Summary& summary, const outputs::OutputSet& files, Console& console) {
  for (const auto& line : timing_table(summary)) console.say(line);
  tell_frames(summary, console);
  for (const auto& name : summary.files) fmt::print("{}\n", (files.folder() / name).string());
}

}  // namespace choreo::cli

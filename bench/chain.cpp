// SPDX-License-Identifier: Apache-2.0
// The whole chain of a live run: picture, mask, state, and a row of Z and Z* against ten minutes of history.
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "film.hpp"
#include "pipeline/core_limit.hpp"
#include "pipeline/runner.hpp"
#include "pipeline/stages/history_stage.hpp"
#include "pipeline/stages/silhouette_stages.hpp"
#include "pipeline/steady_clock.hpp"
#include "pipeline/working_size.hpp"
#include "report.hpp"
#include "similarity/mask_history.hpp"
#include "vision/body_masker.hpp"

namespace choreo::bench {
namespace {

constexpr int kLiveRows = 120;
constexpr double kCameraFps = 30;

Film film_of(cv::Size size, int frames) {
  devices::synthetic::PerformerSettings settings;
  settings.size = size;
  settings.noise = kFilmNoise;
  settings.empty = 0;
  settings.fps = kCameraFps;
  return {"jumping-jacks", settings, frames};
}

struct Chain {
  double fps = 0;            ///< As fast as it goes.
  pipeline::Latency camera;  ///< With a camera's 30 frames a second.
  Nanoseconds row{0};        ///< Of which the row of Z and Z*, with the ring full; the median.
  std::uint64_t dropped = 0;
};

// The ring as it is after ten minutes.
void fill(similarity::MaskHistory& history, const Film& film, cv::Size working) {
  auto masker = masker_for(film, working);
  std::vector<std::unique_ptr<const body::MaskState>> states;
  for (std::size_t i = 0; i < film.pictures().size(); ++i) {
    const auto result = masker.process(pipeline::at_working_size(film.pictures()[i], working), double(i) / kCameraFps);
    if (result.body) states.push_back(std::make_unique<const body::MaskState>(result.mask));
  }
  for (std::size_t i = 0; i < history.capacity(); ++i) history.remember(states[i % states.size()].get());
}

// The history is full from the start: no row goes by time, one by number with every frame.
pipeline::RunReport run_chain(Film& film, similarity::MaskHistory& history, cv::Size working, int threads, Pace pace,
                              std::uint64_t frames, pipeline::RowCost& cost) {
  const pipeline::SteadyClock clock;
  std::vector<std::unique_ptr<pipeline::Stage>> stages;
  stages.push_back(std::make_unique<pipeline::PictureStage>(working));
  stages.push_back(std::make_unique<pipeline::MaskStage>(masker_for(film, working)));
  stages.push_back(std::make_unique<pipeline::StateStage>(0.15));
  stages.push_back(std::make_unique<pipeline::HistoryStage>(history, kHistory, clock, &cost));
  return run_film(film, stages, threads, pace, frames, clock);
}

Chain measure(Film& film, int threads, const Settings& settings) {
  const pipeline::CoreLimit cores(threads);
  const auto working = pipeline::working_size(film.info().size, kLiveRows);
  similarity::MaskHistory history(working, kHistoryFrames, similarity::choose_and_count());
  fill(history, film, working);
  Chain chain;
  pipeline::RowCost cost;
  const auto fast = run_chain(film, history, working, threads, Pace::kMax, settings.quick ? 300 : 1500, cost);
  chain.fps = double(fast.frames) / to_seconds(fast.wall);
  pipeline::RowCost camera_cost;
  const auto camera = run_chain(film, history, working, threads, Pace::kCamera, settings.quick ? 75 : 600, camera_cost);
  chain.camera = camera.latency;
  chain.dropped = camera.stages[1].dropped;
  chain.row = camera_cost.full().p50;
  return chain;
}

}  // namespace

void chain(const Settings& settings, Report& report) {
  report.notes.push_back(
      fmt::format("frames filmed beforehand, masks at {} rows, 10 min of history ({} rows, full), mask and Z and Z*",
                  kLiveRows, kHistoryFrames));
  report.notes.emplace_back(
      "frames/s: as fast as they go; latency: with a camera's 30 frames a second, the newest frame wins");
  for (const auto size : {cv::Size(640, 480), cv::Size(1920, 1080)}) {
    auto film = film_of(size, settings.quick ? 15 : 60);
    for (const int threads : {1, 2}) {
      const auto c = measure(film, threads, settings);
      const auto name = fmt::format("{} x {}, {} thread{}", size.width, size.height, threads, threads == 1 ? "" : "s");
      const auto ms = [](Nanoseconds t) { return 1e3 * to_seconds(t); };
      report.lines.push_back({name + ", frames/s", "", fmt::format("{:.0f}", c.fps), "", "", ""});
      report.lines.push_back(
          {name + ", p50 / p99 / max", "",
           fmt::format("{:.1f} / {:.1f} / {:.1f} ms", ms(c.camera.p50), ms(c.camera.p99), ms(c.camera.max)), "", "",
           ""});
      report.lines.push_back(
          {name + ", a row, dropped", "", fmt::format("{:.2f} ms, {}", ms(c.row), c.dropped), "", "", ""});
      const auto key = fmt::format("{}x{}", size.width, size.height) + (threads == 1 ? "_1_thread" : "");
      report.figures["chain_fps_" + key] = c.fps;
      report.figures["chain_p99_ms_" + key] = ms(c.camera.p99);
    }
  }
}

}  // namespace choreo::bench

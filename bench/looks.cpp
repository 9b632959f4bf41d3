// SPDX-License-Identifier: Apache-2.0
// The whole chain of `live --recognise semaphore` with the person network: picture, looks at the person and their arms,
// mask, letter, and a row of Z and Z* against ten minutes of history.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "devices/synthetic/semaphore_script.hpp"
#include "film.hpp"
#include "pipeline/core_limit.hpp"
#include "pipeline/person_models.hpp"
#include "pipeline/runner.hpp"
#include "pipeline/stages/history_stage.hpp"
#include "pipeline/stages/person_stage.hpp"
#include "pipeline/stages/semaphore_stage.hpp"
#include "pipeline/stages/silhouette_stages.hpp"
#include "pipeline/steady_clock.hpp"
#include "report.hpp"
#include "similarity/mask_history.hpp"
#include "vision/body_masker.hpp"

namespace choreo::bench {
namespace {

const cv::Size kPicture(640, 480);
constexpr double kFps = 60;
constexpr double kLettersPerMinute = 30;
constexpr std::string_view kText = "CHAPEL";

// How long after a letter's hold time was over it is known, by the frames' own times.
class LetterStage final : public pipeline::Stage {
 public:
  LetterStage(double film_s, double hold_s) : film_s_(film_s), hold_s_(hold_s) {}

  [[nodiscard]] std::string name() const override { return "letter"; }
  void process(pipeline::Observation& o) override {
    const auto& held = o.signal->held;
    if (!held || held->sign == "REST" || held->from == last_) return;
    last_ = held->from;
    const double time_s = to_seconds(o.time), loop = std::floor(held->from / film_s_) * film_s_;
    for (const auto& sign : devices::synthetic::spelled(kText, kLettersPerMinute)) {
      if (sign.sign.name != held->sign) continue;
      const double late = time_s - (loop + sign.from + hold_s_);
      if (std::abs(late) < 1) late_s_.push_back(late);
    }
  }
  [[nodiscard]] const std::vector<double>& late_s() const { return late_s_; }

 private:
  double film_s_, hold_s_, last_ = -1;
  std::vector<double> late_s_;
};

struct Run {
  pipeline::RunReport report;
  std::vector<double> late_s;
  std::uint64_t looks = 0;
  int late_looks = 0;
};

Run run_chain(Film& film, int threads, std::uint64_t frames) {
  const pipeline::CoreLimit cores(threads);
  const pipeline::SteadyClock clock;
  similarity::MaskHistory history(kPicture / 4, kHistoryFrames, similarity::choose_and_count());
  pipeline::RowCost cost;
  std::atomic<int> late{0};
  pipeline::PersonStageOptions looks;
  looks.arms_per_s = looks.looks_per_s;
  looks.waits = false;
  looks.on_late = [&late](std::uint64_t) { ++late; };
  const recognition::SemaphoreOptions options;
  auto person = std::make_unique<pipeline::PersonStage>(pipeline::load_person_search({}), std::move(looks));
  auto letters = std::make_unique<LetterStage>(double(film.pictures().size()) / kFps, options.hold_s);
  const auto& person_stage = *person;
  const auto& letter_stage = *letters;
  std::vector<std::unique_ptr<pipeline::Stage>> stages;
  stages.push_back(std::make_unique<pipeline::PictureStage>(kPicture / 4));
  stages.push_back(std::move(person));
  stages.push_back(std::make_unique<pipeline::MaskStage>(masker_for(film, kPicture / 4)));
  stages.push_back(std::make_unique<pipeline::StateStage>(0.15));
  stages.push_back(
      std::make_unique<pipeline::SemaphoreStage>(options, body::ParticleBounds{}, pipeline::ReadsSigns::kOfLooks));
  stages.push_back(std::move(letters));
  stages.push_back(std::make_unique<pipeline::HistoryStage>(history, kHistory, clock, &cost));
  Run run;
  run.report = run_film(film, stages, threads, Pace::kCamera, frames, clock);
  if (run.report.problem) std::rethrow_exception(run.report.problem);
  run.late_s = letter_stage.late_s();
  run.looks = person_stage.looks();
  run.late_looks = late;
  return run;
}

}  // namespace

void looks(const Settings& settings, Report& report) {
  if (const auto missing = pipeline::missing_person_models({}); !missing.empty()) {
    report.notes.push_back(missing + " is not here");
    return;
  }
  devices::synthetic::PerformerSettings s;
  s.size = kPicture;
  s.fps = kFps;
  s.noise = kFilmNoise;
  s.empty = 0;
  s.room = "cluttered";
  s.text = kText;
  s.letters_per_minute = kLettersPerMinute;
  const int film_frames = settings.smoke ? 10 : int(kFps * 60 / kLettersPerMinute * double(kText.size()));
  Film film("semaphore", s, film_frames);
  report.notes.push_back(fmt::format(
      "a signaller filmed beforehand, {} x {}, a camera's {:.0f} frames/s, ten looks a second at the person, each made "
      "twice for the arms; masks and rows of Z and Z* at {} x {}",
      kPicture.width, kPicture.height, kFps, kPicture.width / 4, kPicture.height / 4));
  for (const int threads : {1, 2}) {
    const std::uint64_t frames = settings.smoke ? 10 : settings.quick ? 720 : 3600;
    const auto run = run_chain(film, threads, frames);
    const auto name = fmt::format("{} thread{}", threads, threads == 1 ? "" : "s");
    const auto ms = [](Nanoseconds t) { return 1e3 * to_seconds(t); };
    const auto& latency = run.report.latency;
    report.lines.push_back(
        {name + ", p50 / p99 / max of a frame", "",
         fmt::format("{:.1f} / {:.1f} / {:.1f} ms", ms(latency.p50), ms(latency.p99), ms(latency.max)),
         fmt::format("{:.1f} ms", 1e3 / kFps), "", ""});
    report.lines.push_back({"  dropped, looks, of these late", "",
                            fmt::format("{} of {}, {}, {}", run.report.stages[1].dropped, run.report.frames_read,
                                        run.looks, run.late_looks),
                            "", "", ""});
    const double most = run.late_s.empty() ? 0 : *std::ranges::max_element(run.late_s);
    report.lines.push_back({"  letters known after their hold time, at most", "",
                            fmt::format("{:.2f} s ({} letters)", most, run.late_s.size()), "0.20 s", "", ""});
    const auto key = threads == 1 ? "_1_thread" : "";
    report.figures[fmt::format("looks_p99_ms_at_60{}", key)] = ms(latency.p99);
    report.figures[fmt::format("looks_dropped_at_60{}", key)] = run.report.stages[1].dropped;
    report.figures[fmt::format("looks_letter_late_s{}", key)] = most;
  }
}

}  // namespace choreo::bench

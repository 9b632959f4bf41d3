// SPDX-License-Identifier: Apache-2.0
// The whole chain of `live --recognise semaphore`: picture, mask, face, arms, letter, and a row of Z and Z* of particle
// states against ten minutes of history; then each stage beside plain OpenCV.
#include <algorithm>
#include <atomic>
#include <ctime>
#include <functional>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "film.hpp"
#include "limits.hpp"
#include "pipeline/core_limit.hpp"
#include "pipeline/face_models.hpp"
#include "pipeline/runner.hpp"
#include "pipeline/stages/face_stage.hpp"
#include "pipeline/stages/history_stage.hpp"
#include "pipeline/stages/particle_stage.hpp"
#include "pipeline/stages/semaphore_stage.hpp"
#include "pipeline/stages/silhouette_stages.hpp"
#include "pipeline/steady_clock.hpp"
#include "report.hpp"
#include "signal_peers.hpp"
#include "similarity/and_count.hpp"
#include "similarity/particle_history.hpp"
#include "timing.hpp"
#include "vision/body_masker.hpp"

namespace choreo::bench {
namespace {

const cv::Size kPicture(640, 480);
constexpr double kMotionWindow_s = 0.15;

volatile std::uint64_t sink = 0;

double process_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

Film signaller(double fps, const Settings& settings) {
  devices::synthetic::PerformerSettings s;
  s.size = kPicture;
  s.fps = fps;
  s.noise = kFilmNoise;
  s.empty = 0;
  s.room = "cluttered";
  s.skin = "medium";
  s.build = "medium";
  s.text = "SPEED";
  s.letters_per_minute = 30;
  return {"semaphore", s, settings.smoke ? 45 : settings.quick ? 150 : 300};
}

std::unique_ptr<pipeline::FaceStage> face_stage(bool waits, std::atomic<int>* late) {
  pipeline::FaceStageOptions options;
  options.waits = waits;
  if (late != nullptr) options.on_late = [late](std::uint64_t) { ++*late; };
  return std::make_unique<pipeline::FaceStage>(pipeline::load_face_detector({}), std::move(options));
}

// All observations of one loop of the film, with the skin learned.
std::vector<pipeline::ObservationPtr> seen_by(Film& film) {
  std::vector<std::unique_ptr<pipeline::Stage>> stages;
  stages.push_back(std::make_unique<pipeline::PictureStage>(kPicture));
  stages.push_back(std::make_unique<pipeline::MaskStage>(masker_for(film, kPicture)));
  stages.push_back(std::make_unique<pipeline::StateStage>(kMotionWindow_s));
  stages.push_back(face_stage(true, nullptr));
  stages.push_back(std::make_unique<pipeline::ParticleStage>(pipeline::ParticleStageOptions{}));
  const auto loop = film.pictures().size();
  film.rewind(2 * loop);
  std::vector<pipeline::ObservationPtr> all;
  while (auto frame = film.read({})) {
    auto o = std::make_unique<pipeline::Observation>();
    o->index = frame->sequence;
    o->time = frame->device_time;
    o->frame = std::move(frame);
    for (const auto& stage : stages) stage->process(*o);
    if (o->index >= loop) all.push_back(std::move(o));
  }
  return all;
}

std::vector<body::ParticleState> states_of(const std::vector<pipeline::ObservationPtr>& seen) {
  std::vector<body::ParticleState> states;
  for (const auto& o : seen) {
    if (o->particles) states.push_back(*o->particles);
  }
  if (states.empty()) throw failure("the signaller's arms were never seen: there is nothing to measure");
  return states;
}

struct Run {
  pipeline::RunReport report;
  double cpu_s = 0;  ///< Of all threads, a frame.
  int late = 0;
  Nanoseconds row{0};
};

// The history is full from the start: no row goes by time, one by number with every frame.
Run run_chain(Film& film, const std::vector<body::ParticleState>& past, int threads, Pace pace, std::uint64_t frames) {
  const pipeline::CoreLimit cores(threads);
  const pipeline::SteadyClock clock;
  similarity::ParticleHistory history(kHistoryFrames);
  for (std::size_t i = 0; i < kHistoryFrames; ++i) history.remember(&past[i % past.size()]);
  std::atomic<int> late{0};
  pipeline::RowCost cost;
  std::vector<std::unique_ptr<pipeline::Stage>> stages;
  stages.push_back(std::make_unique<pipeline::PictureStage>(kPicture));
  stages.push_back(std::make_unique<pipeline::MaskStage>(masker_for(film, kPicture)));
  stages.push_back(std::make_unique<pipeline::StateStage>(kMotionWindow_s));
  stages.push_back(face_stage(pace == Pace::kMax, &late));
  stages.push_back(std::make_unique<pipeline::ParticleStage>(pipeline::ParticleStageOptions{}));
  stages.push_back(std::make_unique<pipeline::SemaphoreStage>(recognition::SemaphoreOptions{}, body::ParticleBounds{},
                                                              pipeline::ReadsSigns::kOfParticles));
  stages.push_back(std::make_unique<pipeline::HistoryStage>(history, kHistory, clock, &cost));
  Run result;
  const double begin = process_seconds();
  result.report = run_film(film, stages, threads, pace, frames, clock);
  result.cpu_s = (process_seconds() - begin) / double(std::max<std::uint64_t>(1, result.report.frames));
  if (result.report.problem) std::rethrow_exception(result.report.problem);
  result.late = late;
  result.row = cost.full().p50;
  return result;
}

// Nothing but arithmetic, in registers: its tail is the machine's own.
class ArithmeticStage final : public pipeline::Stage {
 public:
  explicit ArithmeticStage(Nanoseconds time) {
    constexpr std::uint64_t kProbe = 200'000;
    const pipeline::SteadyClock clock;
    auto shortest = Nanoseconds::max();
    for (int i = 0; i < 50; ++i) {
      const auto start = clock.now();
      run(kProbe);
      shortest = std::min(shortest, clock.now() - start);
    }
    rounds_ = static_cast<std::uint64_t>(double(kProbe) * to_seconds(time) / to_seconds(shortest));
  }

  [[nodiscard]] std::string name() const override { return "arithmetic"; }
  void process(pipeline::Observation&) override { run(rounds_); }

 private:
  static void run(std::uint64_t rounds) {
    auto x = sink;
    for (std::uint64_t i = 0; i < rounds; ++i) x = x * 6364136223846793005U + 1442695040888963407U;
    sink = x;
  }

  std::uint64_t rounds_ = 0;
};

// The latency of a camera's frames on which nothing is done but arithmetic of that length, one thread.
pipeline::Latency arithmetic_at_pace(Film& film, Nanoseconds time, std::uint64_t frames) {
  const pipeline::SteadyClock clock;
  std::vector<std::unique_ptr<pipeline::Stage>> stages;
  stages.push_back(std::make_unique<ArithmeticStage>(time));
  return run_film(film, stages, 1, Pace::kCamera, frames, clock).latency;
}

std::string ms(double seconds) { return fmt::format("{:.2f} ms", 1e3 * seconds); }
double ms_of(Nanoseconds t) { return 1e3 * to_seconds(t); }
std::string told(const pipeline::Latency& latency) {
  return fmt::format("{:.1f} / {:.1f} / {:.1f} ms", ms_of(latency.p50), ms_of(latency.p99), ms_of(latency.max));
}

void whole(Film& film, const std::vector<body::ParticleState>& past, const Settings& settings, Report& report) {
  const double fps = film.info().nominal_fps;
  const std::uint64_t frames = settings.smoke ? 10 : settings.quick ? 600 : 3000;
  for (const int threads : {1, 2}) {
    const auto name = fmt::format("{} thread{}", threads, threads == 1 ? "" : "s");
    const auto key = threads == 1 ? "_1_thread" : "";
    if (fps <= 30) {
      const auto fast = run_chain(film, past, threads, Pace::kMax, frames);
      const double rate = double(fast.report.frames) / to_seconds(fast.report.wall);
      report.lines.push_back({name + ", frames/s", "", fmt::format("{:.0f}", rate), "", "", ""});
      report.lines.push_back({name + ", processor time a frame", "", ms(fast.cpu_s), "", "", ""});
      report.figures[fmt::format("signals_fps{}", key)] = rate;
      report.figures[fmt::format("signals_cpu_ms{}", key)] = 1e3 * fast.cpu_s;
    }
    const auto run =
        run_chain(film, past, threads, Pace::kCamera, settings.quick || settings.smoke ? frames / 2 : frames);
    const auto& latency = run.report.latency;
    std::string floor;
    if (fps <= 30) floor = told(arithmetic_at_pace(film, latency.p50, settings.smoke ? 10 : frames / 3));
    report.lines.push_back(
        {fmt::format("{} at {:.0f} frames/s, p50 / p99 / max", name, fps), "", told(latency), floor, "", ""});
    report.lines.push_back({"  dropped, late searches, a row", "",
                            fmt::format("{} of {}, {}, {:.3f} ms", run.report.stages[1].dropped, run.report.frames_read,
                                        run.late, ms_of(run.row)),
                            "", "", ""});
    for (std::size_t s = 1; s < run.report.stages.size(); ++s) {
      const auto& stage = run.report.stages[s];
      report.lines.push_back(
          {fmt::format("  {}: busy, p99", stage.name), "",
           fmt::format("{}, {:.2f} ms", ms(to_seconds(stage.busy) / double(std::max<std::uint64_t>(1, stage.frames))),
                       ms_of(stage.latency.p99)),
           "", "", ""});
    }
    report.figures[fmt::format("signals_p50_ms_at_{:.0f}{}", fps, key)] = ms_of(latency.p50);
    report.figures[fmt::format("signals_p99_ms_at_{:.0f}{}", fps, key)] = ms_of(latency.p99);
  }
}

// Each stage and its peers in turns, every frame of a loop of the film once.
class Stages {
 public:
  Stages(Film& film, const std::vector<pipeline::ObservationPtr>& seen, const Settings& settings, Report& report)
      : film_(film),
        seen_(seen),
        settings_(settings),
        report_(report),
        read_(limits_of(similarity::choose_and_count().name).read) {}

  void measure();

 private:
  using Work = std::function<void(const pipeline::Observation&)>;

  // One line for every peer, beside the same `ours`; one without a peer where there is none.
  // @param bytes  that must be read or written at least once; 0: no limit is known.
  void compare(const std::string& what, const std::string& key, const std::vector<std::pair<std::string, Work>>& peers,
               const Work& ours, std::size_t bytes);
  void compare_faces();

  Film& film_;
  const std::vector<pipeline::ObservationPtr>& seen_;
  const Settings& settings_;
  Report& report_;
  std::uint64_t (*read_)(const std::uint8_t*, std::size_t);
};

void Stages::compare(const std::string& what, const std::string& key,
                     const std::vector<std::pair<std::string, Work>>& peers, const Work& ours, std::size_t bytes) {
  const int turns = settings_.smoke ? 3 : std::min<int>(int(seen_.size()), settings_.quick ? 100 : 300);
  std::vector<std::function<void()>> work;
  std::vector<std::size_t> next(peers.size() + 1, 0);
  for (std::size_t k = 0; k <= peers.size(); ++k) {
    const auto& piece = k < peers.size() ? peers[k].second : ours;
    work.emplace_back([this, &piece, &at = next[k]] { piece(*seen_[at++ % seen_.size()]); });
  }
  bytes = bytes / 1024 * 1024;
  const cv::Mat stream(1, static_cast<int>(bytes + 64), CV_8UC1, cv::Scalar(1));
  if (bytes > 0) work.emplace_back([&] { sink = sink + read_(cv::alignPtr(stream.data, 64), bytes); });
  const auto medians = interleaved_medians(turns, work);
  const double own = medians[peers.size()];
  if (peers.empty()) report_.lines.push_back({what, "", ms(own), "", "", ""});
  for (std::size_t k = 0; k < peers.size(); ++k) {
    const bool first = k == 0 && bytes > 0;
    const auto ratio = medians[k] / own;
    report_.lines.push_back({fmt::format("{}; peer: {}", what, peers[k].first), ms(medians[k]), ms(own),
                             first ? ms(medians.back()) : "", fmt::format("{:.1f} x", ratio),
                             first ? fmt::format("{:.0f} %", 100 * medians.back() / own) : ""});
  }
  report_.figures["signals_" + key + "_ms"] = 1e3 * own;
  if (!peers.empty()) report_.figures["signals_" + key + "_vs_opencv"] = medians[0] / own;
}

// A search is not made at every frame and not by the thread that asks: the mean of all threads counts.
void Stages::compare_faces() {
  const auto frames = settings_.smoke ? std::size_t{5} : seen_.size();
  const double share = vision::FaceSearchOptions{}.least_share;
  const double most = vision::FaceSearchOptions{}.most_share;
  constexpr double kWindow = 1.135;  // A frontal window in face widths.
  PeerFaces peer(cvRound(kWindow * share * kPicture.height), cvRound(kWindow * most * kPicture.height));
  const auto peer_frames = std::min<std::size_t>(frames, settings_.quick ? 30 : 100);
  double begin = process_seconds();
  for (std::size_t i = 0; i < peer_frames; ++i) sink = sink + peer(seen_[i]->picture).size();
  const double of_peer = (process_seconds() - begin) / double(peer_frames);
  const auto stage = face_stage(true, nullptr);
  begin = process_seconds();
  for (std::size_t i = 0; i < frames; ++i) {
    pipeline::Observation o;
    o.frame = seen_[i]->frame;
    o.time = seen_[i]->time;
    o.picture = seen_[i]->picture;
    o.mask = seen_[i]->mask;
    stage->process(o);
  }
  const double own = (process_seconds() - begin) / double(frames);
  report_.lines.push_back({"face; peer: detectMultiScale on the whole of every frame", ms(of_peer), ms(own), "",
                           fmt::format("{:.1f} x", of_peer / own), ""});
  report_.lines.push_back({fmt::format("  a search ({} in {} frames)", stage->asked(), frames), "",
                           ms(own * double(frames) / double(std::max<std::uint64_t>(1, stage->asked()))), "", "", ""});
  report_.figures["signals_face_vs_opencv"] = of_peer / own;
}

void Stages::measure() {
  const tbb::global_control one_core(tbb::global_control::max_allowed_parallelism, 1);
  cv::setNumThreads(1);
  const std::size_t pixels = std::size_t(kPicture.area());
  const auto states = states_of(seen_);
  const pipeline::Observation* with_face = nullptr;
  for (const auto& o : seen_) {
    if (o->face && o->particles) with_face = o.get();
  }
  if (with_face == nullptr) throw failure("the signaller's face was never seen: there is nothing to measure");

  auto masker = masker_for(film_, kPicture);
  const PeerMask mask(film_.room(), 4 * kFilmNoise);
  compare(
      "mask", "mask",
      {{"difference, threshold, closing, components", [&](const auto& o) { sink = sink + mask(o.picture).total(); }}},
      [&](const auto& o) { sink = sink + std::uint64_t(masker.process(o.picture, to_seconds(o.time)).area); },
      7 * pixels);

  compare_faces();

  vision::ToneLearner learner({});
  vision::ToneSet tones;
  for (const auto& o : seen_) {
    if (o->face && learner.add(o->picture, *o->face, to_seconds(o->time), o->mask.mask)) {
      tones = {};
      if (learner.clothes()) tones.put(*learner.clothes());
      tones.put(*learner.skin());
    }
  }
  vision::ToneMapper mapper(tones);
  const auto skin = tones.find("skin");
  const PeerBackProjection back_projection(with_face->picture, *with_face->face);
  const PeerGaussian gaussian(with_face->picture, *with_face->face);
  std::vector<cv::Mat> posteriors;
  for (const auto& o : seen_) posteriors.push_back(mapper.posterior(o->picture, o->mask.mask, skin));
  compare(
      "tones", "tones",
      {{"HSV, calcBackProject", [&](const auto& o) { sink = sink + back_projection(o.picture, o.mask.mask).total(); }},
       {"a Gaussian at every pixel, exp",
        [&](const auto& o) { sink = sink + gaussian(o.picture, o.mask.mask).total(); }}},
      [&](const auto& o) { sink = sink + mapper.posterior(o.picture, o.mask.mask, skin).total(); }, 5 * pixels);
  compare(
      "tables of tones, twice a second", "tables", {}, [&](const auto&) { mapper.rebuild(tones); }, 0);

  vision::ArmFinder finder;
  const auto posterior_of = [&](const auto& o) -> const cv::Mat& {
    return posteriors[std::size_t(o.index - seen_.front()->index)];
  };
  compare(
      "arms and state", "arms",
      {{"components, moments",
        [&](const auto& o) {
          const auto face = o.face ? *o.face : *with_face->face;
          sink = sink + std::uint64_t(peer_arms(posterior_of(o), o.mask.mask, face)[0].m00);
        }}},
      [&](const auto& o) {
        const auto arms = finder.find(posterior_of(o), o.mask.mask, o.face, to_seconds(o.time));
        sink = sink + (body::particle_state_of(arms, o.face) ? 1U : 0U);
      },
      2 * pixels);

  std::vector<body::ParticleState> templates;
  for (const auto& sign : body::semaphore_signs()) {
    for (auto variant : recognition::template_variants()) {
      for (const bool swapped : {false, true}) {
        variant.swapped = swapped;
        templates.push_back(recognition::template_state(sign, variant));
      }
    }
  }
  // As many as the reader has, which leaves some out and adds others.
  PeerRow signs(templates, recognition::SemaphoreTemplates().size());
  recognition::SemaphoreReader reader;
  double now = 0;
  const auto state_of = [&](const auto& o) { return o.particles ? o.particles : with_face->particles; };
  compare(
      "letter", "letter",
      {{fmt::format("gemm with {} templates", recognition::SemaphoreTemplates().size()),
        [&](const auto& o) {
          double best = 0;
          cv::minMaxLoc(signs(*state_of(o)).col(0), nullptr, &best);
          sink = sink + (best > 0.9 ? 1U : 0U);
        }}},
      [&](const auto& o) { sink = sink + (reader.add(now += 1.0 / 30, state_of(o)).held ? 1U : 0U); }, 0);

  PeerRow rows(states, kHistoryFrames);
  similarity::ParticleHistory history(kHistoryFrames);
  for (std::size_t i = 0; i < kHistoryFrames; ++i) history.remember(&states[i % states.size()]);
  std::vector<float> z(kHistoryFrames);
  std::vector<float> zstar(kHistoryFrames);
  compare(
      "row of Z and Z*", "row",
      {{"gemm with 18,000 states", [&](const auto& o) { sink = sink + rows(*state_of(o)).total(); }}},
      [&](const auto& o) {
        const auto state = state_of(o);
        history.append(&*state, z, zstar);
      },
      kHistoryFrames * 64);
}

}  // namespace

void signals(const Settings& settings, Report& report) {
  report.notes.push_back(fmt::format(
      "a signaller filmed beforehand, {} x {}, cluttered wall, noise {}; masks, faces, skin learned from the face and "
      "adapting, particles, letters, and Z and Z* against 10 min of states ({} rows, full)",
      kPicture.width, kPicture.height, kFilmNoise, kHistoryFrames));
  report.notes.emplace_back(
      "frames/s: as fast as they go, every search waited for; latency: of a camera, the newest frame wins; late "
      "searches are void; its limit is a run of arithmetic alone that takes as long as our median");
  report.notes.emplace_back(
      "stages: medians, one core, in turns; a limit is reading as many bytes as must be read or written once");
  std::vector<body::ParticleState> past;
  {
    auto film = signaller(30, settings);
    const auto seen = seen_by(film);
    past = states_of(seen);
    report.notes.push_back(fmt::format("two arms and a face in {} of {} frames", past.size(), seen.size()));
    Stages(film, seen, settings, report).measure();
    whole(film, past, settings, report);
  }
  auto film = signaller(120, settings);
  whole(film, past, settings, report);
  cv::setNumThreads(-1);
}

}  // namespace choreo::bench

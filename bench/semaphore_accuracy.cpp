// SPDX-License-Identifier: Apache-2.0
// How many letters and words of synthetic signallers are read, from pictures to words, and how many that are none.
#include <algorithm>
#include <array>
#include <atomic>
#include <exception>
#include <map>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/core.hpp>

#include "devices/synthetic/performer.hpp"
#include "devices/synthetic/semaphore_script.hpp"
#include "pipeline/face_models.hpp"
#include "pipeline/person_models.hpp"
#include "pipeline/stages/face_stage.hpp"
#include "pipeline/stages/particle_stage.hpp"
#include "pipeline/stages/person_stage.hpp"
#include "pipeline/stages/semaphore_stage.hpp"
#include "pipeline/stages/silhouette_stages.hpp"
#include "report.hpp"

namespace choreo::bench {
namespace {

namespace synthetic = devices::synthetic;

constexpr double kSignallerFps = 10;
constexpr double kSignallerNoise = 3;
constexpr double kRate = 12;                // letters a minute
constexpr std::uint64_t kSeed = 50000;      // Tests and tuning used smaller ones.
constexpr std::string_view kLeadIn = "  ";  // At 12 letters a minute five seconds of REST, in which skin is learned.
constexpr std::array<const char*, 5> kSkins = {"very-light", "light", "medium", "brown", "dark"};
constexpr std::array<const char*, 3> kBuilds = {"slender", "medium", "stout"};
constexpr std::array<double, 3> kDistances = {1.0, 1.35, 1.7};

struct Clip {
  std::string script;
  synthetic::PerformerSettings settings;
  std::string expected;  // text
};

struct Result {
  std::vector<recognition::HeldSign> signs;
  std::string text;
  double first_s = 0;  // when the script begins
};

cv::Mat empty_room(const synthetic::Performer& performer) {
  cv::Mat sum = cv::Mat::zeros(performer.settings().size, CV_32FC3);
  for (int i = 0; i < performer.first_frame(); ++i) {
    cv::Mat picture;
    performer.perform(i).bgr.convertTo(picture, CV_32FC3);
    sum += picture;
  }
  cv::Mat room;
  sum.convertTo(room, CV_8UC3, 1.0 / performer.first_frame());
  return room;
}

constexpr std::array kReaders = {pipeline::ReadsSigns::kOfLooks, pipeline::ReadsSigns::kOfParticles};

// By tone, or with the person network where it is: ten looks a second, as live, each made twice.
Result read_clip(const Clip& clip, pipeline::ReadsSigns reads) {
  const synthetic::Performer performer(clip.script, clip.settings);
  pipeline::PictureStage picture(clip.settings.size);
  pipeline::MaskStage mask(vision::BodyMasker(empty_room(performer), kSignallerNoise, {}));
  pipeline::FaceStage face(pipeline::load_face_detector({}), {});
  pipeline::ParticleStage arms({});
  pipeline::SemaphoreStage semaphore({}, {}, reads);
  std::vector<pipeline::Stage*> stages = {&picture, &mask, &face, &arms, &semaphore};
  std::optional<pipeline::PersonStage> person;
  if (reads == pipeline::ReadsSigns::kOfLooks) {
    pipeline::PersonStageOptions looks;
    looks.delay_s = 0;
    looks.others = false;
    looks.arms_per_s = looks.looks_per_s;
    stages = {&picture, &person.emplace(pipeline::load_person_search({}), looks), &semaphore};
  }
  Result result;
  result.first_s = performer.first_frame() / kSignallerFps;
  for (int i = 0; i < performer.frame_count(); ++i) {
    auto film = performer.perform(i);
    auto frame = std::make_shared<devices::Frame>();
    frame->sequence = std::uint64_t(i);
    frame->device_time = film.time;
    frame->bgr = std::move(film.bgr);
    pipeline::Observation o;
    o.index = std::uint64_t(i);
    o.time = film.time;
    o.frame = std::move(frame);
    for (auto* stage : stages) stage->process(o);
  }
  semaphore.finish();
  result.signs = semaphore.signs();
  result.text = semaphore.text();
  return result;
}

// Two at a time; the results do not depend on it.
std::vector<Result> read_all(const std::vector<Clip>& clips, pipeline::ReadsSigns reads) {
  std::vector<Result> results(clips.size());
  std::vector<std::exception_ptr> problems(clips.size());
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < clips.size(); i = next++) {
      try {
        results[i] = read_clip(clips[i], reads);
      } catch (...) {
        problems[i] = std::current_exception();
      }
    }
  };
  {
    std::jthread other(work);
    work();
  }
  for (const auto& problem : problems) {
    if (problem) std::rethrow_exception(problem);
  }
  return results;
}

synthetic::PerformerSettings settings_of(std::size_t i) {
  synthetic::PerformerSettings s;
  s.fps = kSignallerFps;
  s.seed = kSeed + i;
  s.noise = kSignallerNoise;
  s.drift = i % 2 == 0 ? 8 : -8;
  s.empty = 1.5;
  s.room = "cluttered";
  s.sleeves = i % 3 == 2 ? "none" : "half";
  s.skin = kSkins[i % kSkins.size()];
  s.build = kBuilds[(i / kSkins.size()) % kBuilds.size()];
  s.distance = kDistances[(i % kSkins.size() + i / kSkins.size()) % kDistances.size()];
  s.letters_per_minute = kRate;
  return s;
}

// Half of the alphabet as three words, then a number whose last digit is cancelled; the next clip has the other half.
Clip signaller(std::size_t i) {
  std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ";
  std::mt19937_64 chance(kSeed + i / 2);
  for (std::size_t k = letters.size() - 1; k > 0; --k) std::swap(letters[k], letters[chance() % (k + 1)]);
  letters = letters.substr(i % 2 == 0 ? 0 : 13, 13);
  const char digit = char('0' + i % 10);
  const auto words = letters.substr(0, 5) + " " + letters.substr(5, 4) + " " + letters.substr(9) + " " + digit;
  Clip clip{"semaphore", settings_of(i), words};
  clip.settings.text = std::string(kLeadIn) + words + char('0' + (i + 3) % 10) + "!";
  return clip;
}

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words(1);
  for (const char c : text) {
    if (c == ' ') {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  return words;
}

// Words that are read in their order: the longest common subsequence.
int common(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  std::vector<std::vector<int>> most(a.size() + 1, std::vector<int>(b.size() + 1, 0));
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < b.size(); ++k) {
      most[i + 1][k + 1] = a[i] == b[k] ? most[i][k] + 1 : std::max(most[i][k + 1], most[i + 1][k]);
    }
  }
  return most[a.size()][b.size()];
}

struct Share {
  int right = 0, all = 0;
  [[nodiscard]] std::string text() const {
    return fmt::format("{:.2f} % ({} of {})", all > 0 ? 100.0 * right / all : 0.0, right, all);
  }
};

struct Tally {
  Share letters, words;
  int extra = 0;  // read where none was held
  std::map<std::string, Share> by;
  std::map<std::string, std::map<std::string, int>> table;  // held, read

  void add(const Clip& clip, const Result& result) {
    std::vector<bool> used(result.signs.size(), false);
    const auto& s = clip.settings;
    auto held = synthetic::spelled(s.text, s.letters_per_minute);
    const double slot = 60 / s.letters_per_minute;
    held.insert(held.begin(), {body::semaphore("REST").value(), 0.5 * slot, held.front().from - 0.2 * slot});
    for (const auto& h : held) {
      std::string read = "none";
      double most = 0.2;  // seconds that both must have in common
      for (std::size_t k = 0; k < result.signs.size(); ++k) {
        const auto& r = result.signs[k];
        const double both = std::min(r.to, result.first_s + h.to) - std::max(r.from, result.first_s + h.from);
        if (both < most) continue;
        most = both;
        read = r.sign;
      }
      for (std::size_t k = 0; k < result.signs.size(); ++k) {
        const auto& r = result.signs[k];
        if (r.sign == read && r.from < result.first_s + h.to && r.to > result.first_s + h.from) used[k] = true;
      }
      const std::string name(h.sign.name);
      ++table[name][read];
      if (name == "REST") continue;
      const bool right = read == name;
      for (auto* share : {&letters, &by[fmt::format("skin {}", s.skin)], &by[fmt::format("build {}", s.build)],
                          &by[fmt::format("distance {}", s.distance)], &by[fmt::format("sleeves {}", s.sleeves)]}) {
        ++share->all;
        share->right += right ? 1 : 0;
      }
    }
    for (std::size_t k = 0; k < used.size(); ++k) extra += !used[k] && result.signs[k].sign != "REST" ? 1 : 0;
    const auto expected = words_of(clip.expected);
    words.all += int(expected.size());
    words.right += common(expected, words_of(result.text));
  }
};

// Ten minutes in all: as much idle movement as dancing.
std::vector<Clip> others(const Settings& settings) {
  constexpr std::array<const char*, 5> kDances = {"jumping-jacks", "walking", "side-kicks", "symmetric-cycle",
                                                  "anti-palindrome"};
  std::vector<Clip> clips;
  for (std::size_t i = 0; i < 2 * kDances.size(); ++i) {
    Clip clip{i % 2 == 0 ? "idle" : kDances[i / 2], settings_of(100 + i), {}};
    clip.settings.duration = settings.smoke ? 1 : settings.quick ? 12 : 60;
    clips.push_back(clip);
  }
  if (settings.smoke) clips.resize(1);
  return clips;
}

// All clips by one reader: the text spelled by the first `spelling`, and false letters of the rest.
void measure(pipeline::ReadsSigns reads, const std::vector<Clip>& clips, std::size_t spelling, Report& report) {
  const bool looks = reads == pipeline::ReadsSigns::kOfLooks;
  const std::string by = looks ? "by looks" : "by tone";
  const auto results = read_all(clips, reads);
  Tally tally;
  int false_letters = 0;
  double minutes = 0;
  for (std::size_t i = 0; i < clips.size(); ++i) {
    const auto& s = clips[i].settings;
    if (i < spelling) {
      tally.add(clips[i], results[i]);
      if (results[i].text != clips[i].expected) {
        report.notes.push_back(fmt::format("{}: {}, {}, distance {}, sleeves {}: \"{}\" read as \"{}\"", by, s.skin,
                                           s.build, s.distance, s.sleeves, clips[i].expected, results[i].text));
      }
      continue;
    }
    minutes += s.duration.value_or(0) / 60;
    for (const auto& sign : results[i].signs) {
      if (sign.sign == "REST") continue;
      ++false_letters;
      report.notes.push_back(fmt::format("{}: {} ({}, {}): {} from {:.1f} to {:.1f} s", by, clips[i].script, s.skin,
                                         s.build, sign.sign, sign.from, sign.to));
    }
  }
  for (const auto& [held, row] : tally.table) {
    std::vector<std::string> cells;
    for (const auto& [read, count] : row) cells.push_back(fmt::format("{} {}", read, count));
    report.notes.push_back(fmt::format("{}: {} held, read: {}", by, held, fmt::join(cells, ", ")));
  }
  const auto line = [&](const std::string& what, const char* peer, const std::string& ours, const char* aim) {
    report.lines.push_back({by + ", " + what, peer, ours, aim, "", ""});
  };
  line("signs right", "90.76 %", tally.letters.text(), "99 %");
  line("words right", "88 %", tally.words.text(), "97 %");
  line("signs read where none was held", "", std::to_string(tally.extra), "");
  line(fmt::format("false signs in {:.1f} min of idling and dancing", minutes), "", std::to_string(false_letters), "");
  for (const auto& [what, share] : tally.by) line(what, "", share.text(), "");
  const std::string key = looks ? "semaphore_looks_" : "semaphore_";
  report.figures[key + "signs"] = double(tally.letters.right) / std::max(1, tally.letters.all);
  report.figures[key + "words"] = double(tally.words.right) / std::max(1, tally.words.all);
  report.figures[key + "extra"] = tally.extra;
  report.figures[key + "false"] = false_letters;
}

}  // namespace

void semaphore(const Settings& settings, Report& report) {
  cv::setNumThreads(1);
  std::vector<Clip> clips;
  const std::size_t signallers = settings.smoke ? 1 : settings.quick ? 5 : 30;
  for (std::size_t i = 0; i < signallers; ++i) clips.push_back(signaller(i));
  if (settings.smoke) {
    clips[0].settings.text = std::string(kLeadIn) + "A";
    clips[0].expected = "A";
  }
  const auto dances = others(settings);
  const std::size_t spelling = clips.size();
  clips.insert(clips.end(), dances.begin(), dances.end());
  report.notes.push_back(fmt::format(
      "{} signallers, 640 x 480 at {} frames/s, {} letters a minute, cluttered wall, noise {}, light drifting "
      "by 8 levels a minute; by looks of the person network, and by tone, skin learned from the face",
      spelling, kSignallerFps, kRate, kSignallerNoise));
  for (const auto reads : kReaders) {
    if (reads == pipeline::ReadsSigns::kOfLooks && !pipeline::missing_person_models({}).empty()) {
      report.notes.push_back("by looks: " + pipeline::missing_person_models({}) + " is not here");
      continue;
    }
    measure(reads, clips, spelling, report);
  }
  cv::setNumThreads(-1);
}

}  // namespace choreo::bench

// SPDX-License-Identifier: Apache-2.0
// How often answers are right of which so much confidence is told: of single pictures with a sign and without, of both
// drawn performers, and of video; and what is taken for what.
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/core.hpp>

#include "body/semaphore_signs.hpp"
#include "confidence_plot.hpp"
#include "devices/image_folder/image_folder.hpp"
#include "devices/registry.hpp"
#include "devices/synthetic/performer.hpp"
#include "devices/synthetic/semaphore_script.hpp"
#include "devices/video_file/video_file.hpp"
#include "pipeline/person_models.hpp"
#include "pipeline/picture_reading.hpp"
#include "pipeline/stages/person_stage.hpp"
#include "pipeline/stages/semaphore_stage.hpp"
#include "pipeline/stages/silhouette_stages.hpp"
#include "report.hpp"
#include "support/flat_performer.hpp"
#include "support/shared_data.hpp"

namespace choreo::bench {
namespace {

const cv::Size kSize(640, 480);
constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ";

class Judged {
 public:
  explicit Judged(std::string name) { answers_.name = std::move(name); }

  /// @param truth, read  empty: no sign.
  void add(const std::string& truth, const std::string& read, double confidence) {
    if (confidence > 0) answers_.answers.push_back({confidence, truth == read});
    if (confidence <= 0 && read.empty()) ++open_;
    ++table_[truth.empty() ? "none" : truth][read.empty() ? "none" : read];
  }

  void report(Report& report) const {
    const auto& all = answers_.answers;
    for (const auto& [from, to] : confidence_bins()) {
      const auto within = [from = from, to = to](const auto& a) { return a.confidence > from && a.confidence <= to; };
      const auto count = std::ranges::count_if(all, within);
      if (count == 0) continue;
      const auto right = std::ranges::count_if(all, [&](const auto& a) { return within(a) && a.right; });
      double told = 0;
      for (const auto& a : all) told += within(a) ? a.confidence : 0;
      report.lines.push_back({fmt::format("{}, told {:.2f} to {:.2f}", answers_.name, from, to), "",
                              fmt::format("{:.3f} ({} of {})", double(right) / double(count), right, count),
                              fmt::format("{:.3f}", told / double(count)), "", ""});
    }
    if (open_ > 0) report.notes.push_back(fmt::format("{}: of {} nothing is told", answers_.name, open_));
    // The confusion table's rows, those in one that show nothing but themselves.
    std::vector<std::string> clear;
    for (const auto& [truth, row] : table_) {
      std::vector<std::string> cells;
      for (const auto& [read, count] : row) cells.push_back(fmt::format("{} {}", read, count));
      if (row.size() == 1 && row.contains(truth)) {
        clear.push_back(cells[0]);
      } else {
        report.notes.push_back(fmt::format("{}: {} is read as {}", answers_.name, truth, fmt::join(cells, ", ")));
      }
    }
    if (!clear.empty()) {
      report.notes.push_back(fmt::format("{}: always as themselves {}", answers_.name, fmt::join(clear, ", ")));
    }
  }
  [[nodiscard]] const NamedAnswers& answers() const { return answers_; }

 private:
  NamedAnswers answers_;
  int open_ = 0;
  std::map<std::string, std::map<std::string, int>> table_;
};

class Reader {
 public:
  Reader() : people_(pipeline::load_person_search({})) {}

  void read(const cv::Mat& picture, const std::string& truth, Judged& judged) {
    const auto reading = pipeline::read_by_network(pipeline::reduced_picture(picture), people_, false);
    judged.add(truth, reading.sign ? std::string(*reading.sign) : std::string(), reading.confidence);
  }

 private:
  vision::PersonSearch people_;
};

using EachPicture = std::function<bool(const cv::Mat&, std::size_t)>;  // Until it returns false.

void for_each_picture(const std::string& path, const EachPicture& each) {
  devices::Registry registry;
  registry.add(devices::video_file_driver());
  registry.add(devices::image_folder_driver());
  const auto source = registry.open(path, {.sets = true});
  for (std::size_t k = 0; auto frame = source->read({}); ++k) {
    if (!each(frame->bgr, k)) return;
  }
}

void office(Reader& reader, const Settings& settings, Judged& with, Judged& without, Report& report) {
  const auto labels = test::shared_data("gestures/labels.csv");
  if (labels.empty()) {
    report.notes.emplace_back("the photographs of ../shared/data/gestures are not here");
    return;
  }
  std::map<std::string, std::string> truth;
  std::ifstream file(labels);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) truth[line.substr(0, line.find(','))] = line.substr(line.find(',') + 1);
  const auto folder = std::filesystem::path(labels).parent_path();
  for (const auto& [name, letter] : truth) {
    if (letter == "?") continue;  // One may argue.
    for_each_picture((folder / name).string(), [&](const cv::Mat& picture, std::size_t) {
      reader.read(picture, letter, letter.empty() ? without : with);
      return false;
    });
    if (settings.smoke) return;
  }
}

// People who walk, talk and look about. (Not those of pose2sim: who balances holds out the arms, as in signs.)
void films(Reader& reader, const Settings& settings, Judged& judged, Report& report) {
  for (const auto* name :
       {"intel_one-by-one-person-detection.mp4", "intel_people-detection.gif", "intel_face-demographics-walking.gif",
        "intel_head-pose-face-detection-female-and-male.gif"}) {
    const auto path = test::shared_data(std::string("video/clear/") + name);
    if (path.empty()) {
      report.notes.push_back(fmt::format("{} of ../shared/data is not here", name));
      continue;
    }
    const std::size_t every = settings.quick ? 40 : 10;
    for_each_picture(path, [&](const cv::Mat& picture, std::size_t k) {
      if (k % every == 0) reader.read(picture, {}, judged);
      return !settings.smoke;
    });
  }
}

devices::synthetic::PerformerSettings drawn(std::size_t i) {
  constexpr std::array kSkins = {"very-light", "light", "medium", "brown", "dark"};
  constexpr std::array kBuilds = {"slender", "medium", "stout"};
  devices::synthetic::PerformerSettings s;
  s.size = kSize;
  s.fps = 10;
  s.seed = 70000 + i;
  s.noise = 3;
  s.empty = 0;
  s.room = "cluttered";
  s.sleeves = i % 3 == 2 ? "none" : "half";
  s.skin = kSkins[i % kSkins.size()];
  s.build = kBuilds[i % kBuilds.size()];
  s.letters_per_minute = 12;
  return s;
}

void first_performer(Reader& reader, const Settings& settings, Judged& judged) {
  const std::size_t performers = settings.smoke ? 1 : settings.quick ? 2 : 5;
  for (std::size_t i = 0; i < performers; ++i) {
    auto s = drawn(i);
    s.text = "ABCDEF GHIJKL MNOPQR STUVWX YZ";
    const devices::synthetic::Performer performer("semaphore", s);
    for (const auto& sign : devices::synthetic::spelled(s.text, s.letters_per_minute)) {
      const int frame = performer.first_frame() + int((sign.from + sign.to) / 2 * s.fps);
      const std::string truth(sign.sign.name == "REST" ? std::string_view() : sign.sign.name);
      reader.read(performer.perform(frame).bgr, truth, judged);
      if (settings.smoke) return;
    }
  }
}

test::FlatScene flat(int look, double bend) {
  test::FlatScene scene;
  scene.look = look;
  scene.script = "signal";
  scene.text = kLetters;
  scene.bend = bend;
  scene.empty_s = 0;
  scene.seed = 40 + unsigned(look);
  return scene;
}

void second_performer(Reader& reader, const Settings& settings, Judged& judged) {
  for (const int look : {0, 1, 2}) {
    for (const double bend : {0.0, 24.0}) {
      const test::FlatPerformer performer(flat(look, bend));
      for (std::size_t k = 0; k < kLetters.size(); ++k) {
        reader.read(performer.frame(1 + 2.5 * double(k) + 1.8).picture, std::string(kLetters.substr(k, 1)), judged);
        if (settings.smoke) return;
      }
      if (settings.quick) break;
    }
  }
}

// As recordings are read.
void video(const Settings& settings, Judged& judged) {
  constexpr double kFps = 10;
  for (const int look : {0, 1, 2}) {
    for (const double bend : {0.0, 16.0}) {
      auto scene = flat(look, bend);
      if (settings.quick) scene.text = "QVDJXK";
      const test::FlatPerformer performer(scene);
      pipeline::PersonStageOptions looks;
      looks.delay_s = 0;
      looks.others = false;
      looks.arms_per_s = looks.looks_per_s;
      looks.arm_looks = 4;
      pipeline::PictureStage picture(kSize);
      pipeline::PersonStage person(pipeline::load_person_search({}), looks);
      pipeline::SemaphoreStage semaphore({}, {}, pipeline::ReadsSigns::kOfLooks);
      const int frames = settings.smoke ? 5 : int(test::seconds_of_text(scene.text) * kFps);
      for (int k = 0; k < frames; ++k) {
        pipeline::Observation o;
        auto frame = std::make_shared<devices::Frame>();
        frame->sequence = o.index = std::uint64_t(k);
        frame->device_time = o.time = from_seconds(k / kFps);
        frame->bgr = performer.frame(k / kFps).picture;
        o.frame = std::move(frame);
        for (pipeline::Stage* stage : {static_cast<pipeline::Stage*>(&picture), static_cast<pipeline::Stage*>(&person),
                                       static_cast<pipeline::Stage*>(&semaphore)}) {
          stage->process(o);
        }
      }
      semaphore.finish();
      std::vector<bool> read(scene.text.size(), false);
      for (const auto& sign : semaphore.signs()) {
        if (sign.sign == "REST") continue;
        const auto k = std::size_t(std::clamp(((sign.from + sign.to) / 2 - 1) / 2.5, 0.0, double(read.size()) - 1));
        read[k] = true;
        judged.add(scene.text.substr(k, 1), std::string(sign.sign), sign.confidence);
      }
      for (std::size_t k = 0; k < read.size(); ++k) {
        if (!read[k]) judged.add(scene.text.substr(k, 1), {}, 0);
      }
      if (settings.smoke) return;
    }
  }
}

}  // namespace

void confidence(const Settings& settings, Report& report) {
  if (const auto missing = pipeline::missing_person_models({}); !missing.empty()) {
    report.notes.push_back(missing + " is not here");
    return;
  }
  Reader reader;
  Judged letters("office, a letter"), none("office, none"), people("films, no letter"), first("first performer"),
      second("second performer"), held("second, video");
  office(reader, settings, letters, none, report);
  films(reader, settings, people, report);
  first_performer(reader, settings, first);
  second_performer(reader, settings, second);
  video(settings, held);
  report.notes.insert(report.notes.begin(), "ours: the share that is right; limit: the mean of what is told");
  std::vector<NamedAnswers> all;
  int sure = 0, right = 0;
  for (const auto* judged : {&letters, &none, &people, &first, &second, &held}) {
    judged->report(report);
    all.push_back(judged->answers());
    for (const auto& answer : judged->answers().answers) {
      sure += answer.confidence > 0.9 ? 1 : 0;
      right += answer.confidence > 0.9 && answer.right ? 1 : 0;
    }
  }
  report.figures["confidence_right_of_those_above_90_percent"] = double(right) / std::max(1, sure);
  if (!settings.plot.empty()) plot_confidence(all, settings.plot);
}

}  // namespace choreo::bench

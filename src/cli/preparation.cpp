// SPDX-License-Identifier: Apache-2.0
#include "cli/preparation.hpp"

#include <chrono>
#include <cstdlib>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "cli/drivers.hpp"
#include "cli/memory.hpp"
#include "cli/people.hpp"
#include "cli/plate.hpp"
#include "pipeline/working_size.hpp"
#include "vision/colourless.hpp"

namespace choreo::cli {
namespace {

std::string environment(const char* name) {
  const auto* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// A source some of whose frames were looked at and are still to come.
class PeekedSource final : public devices::Source {
 public:
  explicit PeekedSource(std::unique_ptr<devices::Source> source) : source_(std::move(source)) {}

  /// The next frame, which `read` will give, too; null at the end.
  [[nodiscard]] devices::FramePtr peek(std::stop_token stop) {
    auto frame = source_->read(std::move(stop));
    if (frame) seen_.push_back(frame);
    return frame;
  }
  [[nodiscard]] const devices::SourceInfo& info() const override { return source_->info(); }
  [[nodiscard]] devices::FramePtr read(std::stop_token stop) override {
    return seen_.empty() ? source_->read(std::move(stop)) : again();
  }
  [[nodiscard]] devices::FramePtr skim(std::stop_token stop) override {
    return seen_.empty() ? source_->skim(std::move(stop)) : again();
  }
  [[nodiscard]] std::vector<std::string> warnings() const override { return source_->warnings(); }

 private:
  devices::FramePtr again() {
    auto frame = std::move(seen_.front());
    seen_.pop_front();
    return frame;
  }

  std::unique_ptr<devices::Source> source_;
  std::deque<devices::FramePtr> seen_;
};

// Whether there are colours, from one frame after the other. The wall may be grey, and a dark stage tells nothing.
class ColourWitness {
 public:
  void see(const cv::Mat& bgr) {
    if (bgr.empty()) return;
    pictures_ = true;
    colour_ = colour_ || !vision::colourless(bgr);
    lit_ = lit_ || cv::mean(bgr)[1] > kDark;
  }
  [[nodiscard]] bool certain() const { return colour_; }
  [[nodiscard]] bool colour() const { return pictures_ && (colour_ || !lit_); }

 private:
  static constexpr double kDark = 20;  // Grey levels.
  bool pictures_ = false, colour_ = false, lit_ = false;
};

int threads_of(const SourceOptions& options) { return options.threads > 0 ? options.threads : cv::getNumberOfCPUs(); }

}  // namespace

Preparation::Preparation(const SourceOptions& options, const config::Options& settings, Session& session,
                         const Clock& clock, bool keep_raw, bool sets)
    : news(session.console),
      selection(options.selection()),
      kernel(similarity::choose_and_count(environment("CHOREO_FORCE_ISA"))),
      stop(session.interrupt.orderly()),
      options_(options),
      settings_(settings),
      session_(session),
      clock_(clock),
      keep_raw_(keep_raw),
      sets_(sets),
      registry_(all_drivers(clock)),
      cores_(threads_of(options)),
      spec_(pipeline::parse_background(settings.background)),
      segmentation_(vision::segmentation_named(settings.segmentation)) {
  settings.depth.validate();
  const auto missing = lacks_people(settings);
  if (segmentation_ == vision::Segmentation::kAuto && !missing.empty()) {
    segmentation_ = vision::Segmentation::kColour;
    summary.body = fmt::format(
        "whatever differs from the background, and who never leaves needs a plate; there is no {}, with which it would "
        "be a person (script/run brings it)",
        missing);
  }
  summary.threads = threads_of(options);
  summary.instruction_set = kernel.name;
  source = open();
  summary.source = source->info();
  summary.span = options.span.value_or("");
  summary.every = selection.every;
  settings_changed();
  if (spec_.kind == pipeline::BackgroundSpec::Kind::kPlate) plate_ = read_plate(spec_.plate);
}

std::unique_ptr<devices::Source> Preparation::open() {
  devices::OpenOptions opening;
  opening.threads = options_.threads;
  opening.stop = stop;
  opening.keep_raw = keep_raw_;
  opening.sets = sets_;
  opening.every_frame = keep_raw_;  // What is recorded lacks nothing; the pipeline drops what it cannot keep up with.
  opening.on_event = [this](const devices::DeviceEvent& event) {
    news.hear(devices::without_password(options_.source), event);
  };
  try {
    return registry_.open(options_.source, opening);
  } catch (const Error&) {
    if (stop.stop_requested()) throw Interrupted{};
    throw;
  }
}

// Of what gives its frames once those of the learning time are kept, to be looked at afterwards.
void Preparation::require_memory() const {
  const auto& info = source->info();
  if (info.repeatable || spec_.kind != pipeline::BackgroundSpec::Kind::kFirst) return;
  const auto free = available_memory();
  constexpr double kUndeclaredFps = 30;
  const double fps = info.nominal_fps > 0 ? info.nominal_fps : kUndeclaredFps;
  const double bytes_per_pixel = 3 + (info.depth ? 2 : 0) + (keep_raw_ ? 3 : 0);
  const double bytes = to_seconds(spec_.first) * fps * info.size.area() * bytes_per_pixel;
  if (!free || bytes <= double(*free) / 2) return;
  throw usage_error(fmt::format("is {}, whose frames take {:.1f} GB of memory, and {:.1f} GB are free",
                                settings_.background, 1e-9 * bytes, 1e-9 * double(*free)),
                    "background.from", "a few seconds of the empty room will do: first:2s");
}

vision::Segmenter Preparation::learn() {
  auto segmenter = learn_still();
  segmenter.follow_camera(summary.background);
  return segmenter;
}

vision::Segmenter Preparation::learn_still() {
  require_memory();
  const auto start = clock_.now();
  std::optional<vision::PersonSearch> search;
  if (looks_for_people()) search.emplace(load_people(settings_));
  const auto people = [&](std::span<const cv::Mat> pictures) { return people_in(pictures, *search, settings_, stop); };
  auto learned = pipeline::learn_background(
      std::move(source), spec_, plate_, settings_.working_rows, [this] { return open(); },
      [&](double share) { session_.console.progress("learning the background", share); }, stop, segmentation_,
      settings_.depth.margin(), people);
  session_.console.finish_progress();
  if (!learned) throw Interrupted{};
  source = std::move(learned->source);
  summary.learn_wall = clock_.now() - start;
  summary.background = learned->estimate;
  summary.background_pictures = learned->pictures;
  if (segmentation_ == vision::Segmentation::kAuto) {
    summary.body = "whatever differs from the background; the network saw no person";  // Until it does.
    vision::Segmenter masker(learned->estimate, settings_.mask, learned->somebody);
    summary.threshold = masker.threshold();
    return masker;
  }
  if (segmentation_ == vision::Segmentation::kPerson) {
    vision::PersonMasker masker(learned->estimate, settings_.mask);
    summary.threshold = masker.threshold();
    return masker;
  }
  std::optional<vision::BodyMasker> colour;
  if (segmentation_ != vision::Segmentation::kDepth) {
    colour.emplace(learned->estimate, settings_.mask);
    summary.threshold = colour->threshold();
  }
  if (!learned->depth) return *std::move(colour);
  summary.depth = learned->depth;
  return {std::move(colour), vision::DepthMasker(*learned->depth, settings_.depth, settings_.mask), settings_.mask};
}

bool Preparation::looks_for_people() const {
  return segmentation_ == vision::Segmentation::kPerson || segmentation_ == vision::Segmentation::kAuto;
}

bool Preparation::can_look() const {
  return segmentation_ != vision::Segmentation::kColour && lacks_people(settings_).empty();
}

bool Preparation::has_colour() {
  constexpr auto kOfRecording = std::chrono::minutes(1);
  constexpr int kOfTheRest = 15;  // Frames; they wait meanwhile, where there is no colour.
  ColourWitness witness;
  const auto& info = source->info();
  if (info.repeatable && info.foreseeable) {
    const auto again = open();
    std::optional<Nanoseconds> first;
    while (!witness.certain()) {
      const auto frame = again->read(stop);
      if (!frame) break;
      if (!first) first = frame->device_time;
      if (frame->device_time - *first > kOfRecording) break;
      witness.see(frame->bgr);
    }
  } else {
    auto peeked = std::make_unique<PeekedSource>(std::move(source));
    for (int k = 0; k < kOfTheRest && !witness.certain(); ++k) {
      const auto frame = peeked->peek(stop);
      if (!frame) break;
      witness.see(frame->bgr);
    }
    source = std::move(peeked);
  }
  return witness.colour();
}

void Preparation::settings_changed() {
  summary.working_size = pipeline::working_size(summary.source.size, settings_.working_rows);
}

}  // namespace choreo::cli

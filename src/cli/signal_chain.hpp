// SPDX-License-Identifier: Apache-2.0
// What analyze and live share of the way from pictures to particles and letters.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cli/console.hpp"
#include "config/options.hpp"
#include "outputs/signal_overlay.hpp"
#include "pipeline/picture_reading.hpp"
#include "pipeline/stages/face_stage.hpp"
#include "pipeline/stages/particle_stage.hpp"
#include "pipeline/stages/semaphore_stage.hpp"

namespace CLI {
class App;
}

namespace choreo::cli {

/// Which state stands for the body, and what is read of it.
struct SignalOptions {
  std::string state;      ///< mask or particles; empty: by what is read.
  std::string recognise;  ///< semaphore; empty: nothing.

  void declare(CLI::App& command);

  [[nodiscard]] bool reads() const { return !recognise.empty(); }
  /// Whether states are particles.
  [[nodiscard]] bool particles() const { return state.empty() ? reads() : state == "particles"; }
};

/// The detector that the settings name. @throws Error (usage) for a file that cannot be used.
[[nodiscard]] std::unique_ptr<vision::FaceDetector> load_faces(const config::Options& settings);

/// What reading pictures by tone takes of the settings. @throws Error (usage) likewise.
[[nodiscard]] pipeline::ToneReaderOptions tone_reader_options(const config::Options& settings);

/// How often what was seen of faces and arms; over all frames of a run.
class SignalTally {
 public:
  /// @param looks  signs are read of the network's looks: what is amiss with tones does not bear on them.
  explicit SignalTally(bool looks) : looks_(looks) {}

  void add(const pipeline::Observation& observation);
  /// Says that nothing was looked at, since the pictures are grey.
  void no_colour() { colour_ = false; }
  /// After the run: how many searches for faces were asked for, and how many of them came too late to count.
  void searched(std::uint64_t asked, std::uint64_t late) {
    searches_ = asked;
    late_ = late;
  }

  [[nodiscard]] std::uint64_t two_arms() const { return cases_[std::size_t(vision::ArmCase::kTwoArms)]; }
  [[nodiscard]] std::uint64_t frames() const { return frames_; }
  /// Where somebody was there for a second and more before the arms were known: that no sign before was read.
  [[nodiscard]] std::optional<std::string> late_start() const;
  /// One line for each thing that is not as it should be.
  [[nodiscard]] std::vector<std::string> warnings(const config::Options& settings) const;

 private:
  [[nodiscard]] std::vector<std::string> of_tones(const config::Options& settings) const;

  bool colour_ = true;
  bool looks_;
  std::uint64_t frames_ = 0;
  std::uint64_t bodies_ = 0;
  std::uint64_t several_faces_ = 0;
  std::uint64_t searches_ = 0, late_ = 0;
  std::uint64_t all_tone_ = 0;   // Frames most of whose body has the arms' tone,
  std::uint64_t some_tone_ = 0;  // and with any of it at all.
  std::array<std::uint64_t, 5> cases_{};
  std::optional<double> body_s_, arms_s_;  // When there first was a body, an arm.
};

/// The stages behind the mask: face, arms and, where signs are read, letters.
class SignalChain {
 public:
  /// @param on_late  told the number of a frame at which a search for faces was not ready; empty: every search is
  ///   waited for.
  /// @param looks  whether there is a PersonStage before, of whose looks signs are read.
  /// @param history  how long signs are kept; nothing: to the end.
  /// @throws Error (usage) for a file that cannot be used or settings that do not fit together.
  SignalChain(const config::Options& settings, bool reads, bool looks, std::function<void(std::uint64_t)> on_late,
              std::optional<Nanoseconds> history = std::nullopt);

  /// Hands the stages over; once.
  /// @param colour  whether pictures have any: tones need it, looks do not.
  void add_to(std::vector<std::unique_ptr<pipeline::Stage>>& stages, bool colour);

  /// After the run: what was held ends. While the stages live.
  void finish();
  /// Null where nothing is read.
  [[nodiscard]] const pipeline::SemaphoreStage* semaphore() const { return semaphore_; }
  /// Whether any letter or other sign but REST was read so far.
  [[nodiscard]] bool read_a_letter() const;
  [[nodiscard]] const pipeline::FaceStage& face() const { return *face_; }

 private:
  std::vector<std::unique_ptr<pipeline::Stage>> by_tone_;
  std::unique_ptr<pipeline::Stage> reader_;
  bool looks_;
  pipeline::FaceStage* face_ = nullptr;
  pipeline::SemaphoreStage* semaphore_ = nullptr;
};

/// Face, arms, letter and text over a picture of that size.
[[nodiscard]] outputs::SignalOverlay overlay_of(const pipeline::Observation& observation, cv::Size picture);

/// Prints signs that are over on standard output at once, a line each; REST is none to be told.
void tell_signs(std::span<const recognition::HeldSign> signs);

/// After the run: prints the text on standard output, after "..." where it was longer than what is kept, and says where
/// reading began late or no letter was read.
void tell_reading(const SignalChain& chain, const SignalTally& tally, Console& console);

/// What was read, as letters.json; nothing but an empty text where nothing could be looked at.
[[nodiscard]] std::string letters_json(const SignalChain& chain);

}  // namespace choreo::cli

// SPDX-License-Identifier: Apache-2.0
// Particle states of the Vitruvian figure showing the signs of semaphore, and how near a state comes to each of them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "body/particle_state.hpp"
#include "body/semaphore_signs.hpp"
#include "recognition/semaphore_options.hpp"

namespace choreo::recognition {

inline constexpr std::size_t kSemaphoreSigns = 29;  ///< body::semaphore_signs(), in their order.

/// What of an arm has the tone that is looked for.
enum class ArmPart {
  kHand,      ///< From the wrist: long sleeves.
  kForearm,   ///< From the elbow.
  kHalfArm,   ///< From the middle of the upper arm: half sleeves.
  kWholeArm,  ///< From the shoulder.
  kFlag,      ///< A flag at the end of a stick, beyond the hand.
};

/// How a figure shows a sign.
struct TemplateVariant {
  ArmPart part = ArmPart::kForearm;
  bool swapped = false;  ///< Each arm points where the table has the other.
  double bend = 0;       ///< Degrees by which the elbows bend in the picture's plane, upwards positive.
  double spread = 0;     ///< Degrees by which both arms are raised further.
  double size = 1;       ///< Of the body against its face.
};

/// The state of the figure seen from the front, its face as MATH has it; where the arms overlap in the picture, they
/// are joined. Each arm is a band of its width from the variant's part to the fingertips.
/// @param sign      arm positions; any pair, with or without a letter.
[[nodiscard]] body::ParticleState template_state(const body::SemaphoreSign& sign, const TemplateVariant& variant,
                                                 const body::ParticleBounds& bounds = {});

/// Z to the nearest template of every sign, by the sign's place in body::semaphore_signs().
using SignSimilarities = std::array<double, kSemaphoreSigns>;

/// What one state shows.
struct SignReading {
  std::optional<std::string_view> sign;  ///< Nothing where no sign is near enough, or two are alike.
  double confidence = 0;                 ///< That the answer is right, be it a sign or none, 0 to 1.
  std::string_view runner_up;            ///< The next sign; where there is none, the nearest. Empty without a state.
  double similarity = 0;                 ///< Z to the nearest sign.
  double lead = 0;                       ///< By how much that exceeds the next one's.
};

/// A direction in the space of Psi.
using UnitPsi = std::array<double, body::kParticleValues>;
[[nodiscard]] UnitPsi unit_psi(const body::ParticleState& state);

/// Templates of all signs: hands, forearms, half and whole arms and flags, straight and slightly bent, three sizes of
/// the body, and with either arm reaching across.
/// @thread reentrant
class SemaphoreTemplates {
 public:
  /// @param bounds  those of the states that will be compared. @throws Error (usage) by options.validate().
  explicit SemaphoreTemplates(const SemaphoreOptions& options = {}, const body::ParticleBounds& bounds = {});

  /// @param joined  only templates whose arms are joined are compared, else only those whose arms are not.
  /// @cost  15 products a template, about 1500 templates.
  [[nodiscard]] SignSimilarities similarities(const UnitPsi& psi, bool joined) const;

  /// The sign of a state: the nearest, where its Z reaches `least_similarity` and leads by `margin`.
  ///
  /// The confidence weighs every sign by exp(-(angle / 0.2)^2 / 2), and "no sign" as a sign at `least_similarity`.
  [[nodiscard]] SignReading read(const body::ParticleState& state) const;
  [[nodiscard]] SignReading read(const SignSimilarities& similarities) const;

  [[nodiscard]] const SemaphoreOptions& options() const { return options_; }
  [[nodiscard]] std::size_t size() const { return templates_.size(); }

 private:
  struct Template {
    UnitPsi psi;
    std::size_t sign;
    bool joined;
  };
  SemaphoreOptions options_;
  std::vector<Template> templates_;
};

/// The variants that the templates are made of, with `swapped` false.
[[nodiscard]] std::vector<TemplateVariant> template_variants();

}  // namespace choreo::recognition

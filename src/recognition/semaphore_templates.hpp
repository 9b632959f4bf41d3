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
#include "recognition/held_sign.hpp"
#include "recognition/semaphore_options.hpp"

namespace choreo::recognition {

inline constexpr std::size_t kSemaphoreSigns = 29;  ///< body::semaphore_signs(), in their order.

/// How a figure shows a sign.
struct TemplateVariant {
  double sleeve =
      1.0 / 3;  ///< Share of the arm that is covered, from the shoulder: a third to the elbow, 0.73 to the wrist.
  std::optional<double> flag;  ///< A square flag is seen, its middle so far beyond the fingertips in units of the
                               ///< body's height, and of the arm nothing.
  bool swapped = false;        ///< Each arm points where the table has the other.
  double bend = 0;             ///< Degrees by which the elbows bend in the picture's plane, upwards positive.
  double spread = 0;           ///< Degrees by which both arms are raised further.
  double size = 1;             ///< Of the body against its face.
  bool face_hides = false;     ///< What lies before head or neck is not seen (vision::in_face_region).
};

/// The state of the figure seen from the front, its face as MATH has it; where the arms overlap in the picture, they
/// are joined. Each arm is a band of its width from the sleeve to the fingertips.
/// @param sign      arm positions; any pair, with or without a letter.
[[nodiscard]] body::ParticleState template_state(const body::SemaphoreSign& sign, const TemplateVariant& variant,
                                                 const body::ParticleBounds& bounds = {});

/// Z to the nearest template of every sign, by the sign's place in body::semaphore_signs().
using SignSimilarities = std::array<double, kSemaphoreSigns>;

/// How a state compares with the templates.
struct SignMatch {
  SignSimilarities similarity{};
  bool fits = false;  ///< The nearest template's arms lie where the state's do; see SemaphoreTemplates.
};

/// A direction in the space of Psi.
using UnitPsi = std::array<double, body::kParticleValues>;
[[nodiscard]] UnitPsi unit_psi(const body::ParticleState& state);

/// Whether arms lie where other arms do: after the scaling from 0.8 to 1.4 that fits best both centroids within 0.9 of
/// `sought`'s face widths, and the axes of arms that are longer than broad within 20 degrees.
[[nodiscard]] bool arms_fit(const body::ParticleParts& seen, const body::ParticleParts& sought);

/// Templates of all signs: sleeves from shoulder to wrist, flags, arms straight and slightly bent, three sizes of the
/// body, and with either arm reaching across.
///
/// So many templates leave few postures that are far from all of them, and Z forgives one bent arm. So the lengths in
/// face widths must agree with the nearest template's, too (`arms_fit`): of postures with elbows bent by a right angle
/// that takes the share that is read from 28 to 0.5 %.
/// @thread reentrant
class SemaphoreTemplates {
 public:
  /// @param bounds  those of the states that will be compared; where they are not the Vitruvian figure's, the figure
  ///   grows with `alpha_max`. @throws Error (usage) by options.validate() and bounds.validate().
  explicit SemaphoreTemplates(const SemaphoreOptions& options = {}, const body::ParticleBounds& bounds = {});

  /// @param psi    of `state`, or the mean of states around it. Templates whose arms are joined are compared with
  ///   states whose arms are, and only with those.
  /// @cost  15 products a template.
  [[nodiscard]] SignMatch match(const UnitPsi& psi, const body::ParticleState& state) const;

  /// The sign of a state: the nearest, where its Z reaches `least_similarity` and leads by `margin`, and it fits.
  ///
  /// The confidence weighs every sign by exp(-(angle / 0.1)^2 / 2), and "no sign" as a sign at `least_similarity`.
  /// Without a state there is no sign, surely.
  [[nodiscard]] SignReading read(const std::optional<body::ParticleState>& state) const;
  [[nodiscard]] SignReading read(const SignMatch& match) const;

  [[nodiscard]] const SemaphoreOptions& options() const { return options_; }
  [[nodiscard]] std::size_t size() const { return templates_.size(); }

 private:
  struct Template {
    UnitPsi psi;
    body::ParticleState state;
    std::size_t sign;
  };
  SemaphoreOptions options_;
  std::vector<Template> templates_;
};

/// The variants that the templates are made of, with `swapped` false.
[[nodiscard]] std::vector<TemplateVariant> template_variants();

}  // namespace choreo::recognition

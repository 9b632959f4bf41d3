// SPDX-License-Identifier: Apache-2.0
// What a look at a person says of a frame some time later.
#pragma once

#include <cstdint>

#include "core/time.hpp"
#include "pipeline/observation.hpp"
#include "vision/person_masker.hpp"

namespace choreo::pipeline {

/// @param size  of the pictures in whose pixels the sighting is.
/// @param now  of the frame: what moves as the fastest joint did has gone so far meanwhile.
[[nodiscard]] vision::PersonEvidence evidence_of(const PersonSighting& sighting, cv::Size size, Nanoseconds now);

enum class OtherPeople : std::uint8_t { kLeftOut, kBodies };

/// Of the performer and of others, who are bodies as well, or are not to be taken for the performer's.
[[nodiscard]] vision::PersonEvidence evidence_of(const Observation& observation, cv::Size size, OtherPeople others);

/// Of the frame itself.
[[nodiscard]] vision::PersonEvidence evidence_of(const vision::PersonLook& look, cv::Size size);

}  // namespace choreo::pipeline

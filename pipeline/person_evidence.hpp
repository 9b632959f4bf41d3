// SPDX-License-Identifier: Apache-2.0
// What a look at a person says of a frame some time later.
#pragma once

#include "core/time.hpp"
#include "pipeline/observation.hpp"
#include "vision/person_masker.hpp"

namespace choreo::pipeline {

/// @param size  of the pictures in whose pixels the sighting is.
/// @param now  of the frame: what moves as the fastest joint did has gone so far meanwhile.
[[nodiscard]] vision::PersonEvidence evidence_of(const PersonSighting& sighting, cv::Size size, Nanoseconds now);

/// Of the frame itself.
[[nodiscard]] vision::PersonEvidence evidence_of(const vision::PersonLook& look, cv::Size size);

}  // namespace choreo::pipeline

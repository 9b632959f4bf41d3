// SPDX-License-Identifier: Apache-2.0
// What is known of one frame; travels the whole way and gains fields.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "body/mask_state.hpp"
#include "body/particle_state.hpp"
#include "core/time.hpp"
#include "devices/frame.hpp"
#include "recognition/held_sign.hpp"
#include "vision/arms.hpp"
#include "vision/body_masker.hpp"
#include "vision/face.hpp"
#include "vision/person/person.hpp"

namespace choreo::pipeline {

/// What a signaller shows.
struct Signal {
  recognition::SignReading now;               ///< Of the last moment's states, held or not.
  std::optional<recognition::HeldSign> held;  ///< The sign that is being held, up to now.
  std::vector<recognition::HeldSign> ended;   ///< Those that ended at this frame, in the order of their ends.
  std::string text;                           ///< The latest part of it, with what is held.
  bool of_looks = false;                      ///< Read where the person network saw the arms; else of `particles`.
};

/// A person as a look at a frame showed them.
struct PersonSighting {
  vision::PersonLook look;      ///< In pixels of `Observation::picture`.
  Nanoseconds time{0};          ///< Of the frame that was looked at.
  devices::FramePtr frame;      ///< That one; null of others.
  std::optional<double> speed;  ///< Of the fastest joint since the look before, px/s; nothing at the first look.
  std::optional<vision::PersonLook> arms = {};    ///< The look with its arms fitted, where it was made for arms.
  std::optional<vision::PersonLook> smooth = {};  ///< The look with its joints filtered, where that is asked for.
};

/// One frame and everything said of it so far. A stage fills its fields and never touches another's.
struct Observation {
  // From the reader.
  std::uint64_t index = 0;  ///< Counts the frames taken, from 0.
  Nanoseconds time{0};      ///< Since the source's first frame.
  devices::FramePtr frame;
  Nanoseconds arrived{0};  ///< On the host's clock: when the source gave the frame.
  Nanoseconds passed{0};   ///< Likewise: when the last stage so far was done.

  // From PictureStage.
  cv::Mat picture;   ///< CV_8UC3 at the working resolution.
  cv::Mat depth_mm;  ///< CV_16UC1, likewise; empty where the frame has none or nobody looks at it.

  // From MaskStage.
  vision::MaskResult mask;  ///< At the working resolution.

  // From FaceStage, where it is by now.
  std::optional<vision::TrackedFace> face;  ///< The performer's, in pixels of `picture`.
  int faces = 0;  ///< In sight, the performer's among them; not those that are known to hang on the wall.

  // From PersonStage.
  std::vector<std::shared_ptr<const PersonSighting>>
      others;                                    ///< Who else was there, likewise, each at their last look.
  std::shared_ptr<const PersonSighting> person;  ///< The last one so far; null where the last look saw nobody.
  std::optional<Nanoseconds> looked;             ///< The time of the frame whose look took effect at this one.

  // From StateStage; absent without a body.
  std::unique_ptr<const body::MaskState> state;
  double quantity_of_motion = 0;  ///< See body::MotionMeter; 0 without a body.
  double contraction = 0;         ///< See body::contraction; 0 without a body.

  // From ParticleStage; the state is absent where two arms and a face were not seen.
  double skin_learned = 1;  ///< Of the time that it takes to learn it from the face, 0 to 1; 1 where it is given.
  double tone_share = 0;    ///< Of the body, what has the arms' tone, 0 to 1.
  vision::Arms arms;
  std::optional<body::ParticleState> particles;

  // From SemaphoreStage.
  std::optional<Signal> signal;

  // From HistoryStage: against every frame of the history, oldest first, this one last; NaN where either has no body.
  std::vector<float> z_row;
  std::vector<float> zstar_row;
};

using ObservationPtr = std::unique_ptr<Observation>;

}  // namespace choreo::pipeline

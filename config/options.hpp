// SPDX-License-Identifier: Apache-2.0
// Everything that can be set, as the typed options of the modules it belongs to.
#pragma once

#include <string>
#include <vector>

#include "body/particle_state.hpp"
#include "pipeline/stages/face_stage.hpp"
#include "recognition/semaphore_options.hpp"
#include "vision/arm_finder.hpp"
#include "vision/body_masker.hpp"
#include "vision/depth_masker.hpp"
#include "vision/haar_faces.hpp"
#include "vision/tone_options.hpp"

namespace choreo::config {

/// What the plots look like; the drawing's own options are made of it.
struct PlotSettings {
  std::string channels = "both";  ///< both, z, zstar.
  std::string page = "light";     ///< light, dark.
  bool svg = false;               ///< Beside each PNG also an SVG.
  int width_px = 1600;
  std::string contrast = "full";        ///< full: 0 to 1; auto: stretched to what is there.
  int thumbnails = 8;                   ///< How many pictures of the body stand along the axis, evenly.
  std::vector<double> thumbnails_at_s;  ///< At these times instead, s.
};

/// How people are looked for.
struct PersonSettings {
  std::string models;               ///< Folder of the network's files; empty: the usual one.
  std::string network = "full";     ///< full, lite.
  std::string choose = "largest";   ///< largest, left, middle, right.
  std::string others = "left-out";  ///< left-out, bodies.
  double smooth_hz = 0;             ///< 0: joints are not filtered.
  double smooth_hz_per_mps = 5;
  double looks_per_s = 10;
  double delay_s = 0.06;  ///< Of live runs.
};

/// The whole configuration.
struct Options {
  std::string segmentation = "auto";  ///< auto, colour, depth, both, person.
  std::string background = "auto";    ///< auto, first:T or a path.
  int working_rows = 480;             ///< Masks and states are made of pictures with at most so many rows; 0: no limit.
  vision::MaskOptions mask;
  vision::DepthOptions depth;
  pipeline::FaceStageOptions face;
  vision::HaarOptions haar;
  std::string cascades;    ///< Folder of OpenCV's; empty: the system's.
  std::string face_model;  ///< Path of a YuNet model; empty: the cascades.
  PersonSettings person;
  vision::ToneOptions tones;
  vision::ArmOptions arms;  ///< Their least probability is `tones.threshold`.
  body::ParticleBounds bounds;
  recognition::SemaphoreOptions semaphore;
  double motion_window_s = 0.15;
  int matrix_rows = 20'000;  ///< At most; of a longer recording every 2nd, 4th, ... frame is a row.
  PlotSettings plot;
};

}  // namespace choreo::config

// SPDX-License-Identifier: Apache-2.0
// choreoscope analyze of a set of pictures: what sign each of them shows.
#pragma once

#include <filesystem>

#include "cli/commands.hpp"
#include "devices/source.hpp"
#include "pipeline/picture_set.hpp"
#include "vision/face_detector.hpp"

namespace choreo::cli {

/// Reads all pictures of a set and writes DIR/letters.json ({"pictures": [{"file", "letter", "confidence",
/// "runner_up"}]}, letter null where none is shown, as where both arms hang) and DIR/pictures.png, on which every
/// picture stands with its arms outlined and its letter, and removes what else an earlier run left in DIR. Says the
/// letters on standard output and what is to be known on standard error.
/// @param source  whose info().stills is set.
/// @param people  reads each picture by itself; null: the pictures are read together, by tones and faces.
/// @return exit status. @throws Error, also where the set needs more than four fifths of the memory that is free, by
///   the number of its files and the size of the first; Interrupted, nothing being written then.
int analyze_pictures(devices::Source& source, vision::FaceDetector& faces, vision::PersonSearch* people,
                     const pipeline::PictureSetOptions& options, const std::filesystem::path& out, Session& session);

}  // namespace choreo::cli

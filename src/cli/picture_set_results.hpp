// SPDX-License-Identifier: Apache-2.0
// choreoscope analyze of a set of pictures: what sign each of them shows.
#pragma once

#include <filesystem>
#include <functional>

#include <opencv2/core/mat.hpp>

#include "cli/commands.hpp"
#include "devices/source.hpp"
#include "pipeline/picture_reading.hpp"

namespace choreo::cli {

/// Reads a picture.
using ReadPicture = std::function<pipeline::PictureReading(const cv::Mat&)>;

/// Reads all pictures of a set, each by itself, and writes DIR/letters.json ({"pictures": [{"file", "letter",
/// "confidence", "runner_up"}]}, letter null where none is shown, as where both arms hang) and DIR/pictures.png, on
/// which every picture stands with its arms and its letter, and removes what else an earlier run left in DIR. Says the
/// letters on standard output and what is to be known on standard error.
/// @param source  whose info().stills is set.
/// @return exit status. @throws Error, also where the sheet needs more than four fifths of the memory that is free, by
///   the number of files; Interrupted, nothing being written then.
int analyze_pictures(devices::Source& source, const ReadPicture& read, const std::filesystem::path& out,
                     Session& session);

}  // namespace choreo::cli

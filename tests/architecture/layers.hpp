// SPDX-License-Identifier: Apache-2.0
// Checks a source tree against the layers of the design and the rules for every file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace choreo::architecture {

struct Violation {
  std::string file;  ///< Relative to the root.
  int line = 0;      ///< From 1.
  std::string rule;  ///< What is broken, in words.
};

struct Survey {
  int files = 0;
  int includes = 0;  ///< Of files of the tree, by files that stand in a layer.
  std::vector<Violation> violations;
};

/// Reads every .cpp and .hpp below src, devices, pipeline, config, tests and bench of `root`.
///
/// Layers, top to bottom; a file includes its own folder and what lies below:
///     src/cli, config, src/outputs, pipeline, devices/<driver>, devices, src/recognition and src/motion,
///     src/similarity, src/body, src/vision, src/core
/// Drivers never include each other, nor recognition and motion. Of src, devices use core and the Vitruvian figure of
/// body alone. From src/core to src/recognition there is no thread, lock, file, clock, socket, log or console. Tests
/// and benchmarks may include anything; nothing includes them.
/// Every file is ASCII, begins with the SPDX line and has at most 500 lines.
[[nodiscard]] Survey survey(const std::filesystem::path& root);

}  // namespace choreo::architecture

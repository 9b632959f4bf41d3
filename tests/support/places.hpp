// SPDX-License-Identifier: Apache-2.0
// Where the built programs and the project's own files lie.
//
// Found from where the running test lies, and not compiled in: an object file is the same in every checkout, and the
// compiler cache finds it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace choreo::test {

/// A program or module of this build, by its path below the build's bin folder.
inline std::string built(std::string_view name) {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / name).string();
}

/// A file of the checkout, by its path below the project's root, to which the build folder has a link.
inline std::string project_file(std::string_view path) {
  return (std::filesystem::canonical(built("../project")) / path).string();
}

/// The program under test.
inline std::string program() { return built("choreoscope"); }

}  // namespace choreo::test

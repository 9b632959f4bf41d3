// SPDX-License-Identifier: Apache-2.0
#include "outputs/output_set.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::outputs {
namespace fs = std::filesystem;
namespace {

std::string temporary_ending() { return fmt::format(".{}.tmp", ::getpid()); }

}  // namespace

OutputSet::OutputSet(fs::path folder) : folder_(std::move(folder)) {
  if (folder_.empty() || folder_.native().find('\0') != std::string::npos) {
    throw usage_error(fmt::format("output \"{}\" is not a folder", folder_.string()), {}, "name a folder with --out");
  }
  std::error_code problem;
  fs::path missing = fs::absolute(folder_);
  if (!missing.has_filename()) missing = missing.parent_path();
  std::vector<fs::path> to_make;
  while (!fs::exists(missing, problem) && missing.has_relative_path()) {
    to_make.push_back(missing);
    missing = missing.parent_path();
  }
  if (!fs::is_directory(missing, problem)) {
    throw usage_error(fmt::format("output \"{}\" is not a folder", missing.string()), {}, "name a folder with --out");
  }
  const auto undo = [this] {
    for (auto it = made_folders_.rbegin(); it != made_folders_.rend(); ++it) {
      std::error_code ignored;
      fs::remove(*it, ignored);
    }
  };
  for (auto it = to_make.rbegin(); it != to_make.rend(); ++it) {
    const bool made = fs::create_directory(*it, problem);
    if (problem) {
      undo();
      throw usage_error(fmt::format("output folder \"{}\" cannot be made: {}", it->string(), problem.message()));
    }
    // "new/.." is there once "new" is, and nobody's to remove.
    if (made) made_folders_.push_back(*it);
  }
  // Found out by writing: permission bits do not tell of read-only file systems. A killed run may have left the file.
  const auto probe = folder_ / (".choreoscope" + temporary_ending());
  const int file = ::open(probe.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0) {
    const auto cause = std::generic_category().message(errno);
    undo();
    throw usage_error(fmt::format("output folder \"{}\" cannot be written to: {}", folder_.string(), cause), {},
                      "choose another with --out");
  }
  ::close(file);
  ::unlink(probe.c_str());
}

OutputSet::~OutputSet() {
  std::error_code ignored;
  for (const auto& file : files_) fs::remove(file.temporary, ignored);
  // A folder that is not empty stays.
  for (auto it = made_folders_.rbegin(); it != made_folders_.rend(); ++it) fs::remove(*it, ignored);
}

void OutputSet::check(const std::string& name) const {
  std::error_code problem;
  const auto final = folder_ / name;
  if (fs::is_directory(final, problem)) {
    throw usage_error(fmt::format("output \"{}\" is a folder", final.string()), {}, "choose another with --out");
  }
}

void OutputSet::require_space(std::uintmax_t bytes, std::string_view what) const {
  std::error_code problem;
  const auto space = fs::space(folder_, problem);
  if (problem || space.available >= bytes) return;
  throw usage_error(fmt::format("{} need {:.1f} GB, and \"{}\" has {:.1f} GB left", what, 1e-9 * double(bytes),
                                folder_.string(), 1e-9 * double(space.available)),
                    {}, "choose another disk with --out, or take fewer frames with --every or --span");
}

fs::path OutputSet::add(const std::string& name) {
  check(name);
  File file{folder_ / ("." + name + temporary_ending()), folder_ / name};
  files_.push_back(file);
  return file.temporary;
}

void OutputSet::supersede(const std::string& name) { superseded_.push_back(folder_ / name); }

void OutputSet::commit() {
  // All or nothing, as far as can be foreseen.
  for (const auto& file : files_) {
    if (::access(file.temporary.c_str(), F_OK) == 0) continue;
    const auto cause = std::generic_category().message(errno);
    throw failure(fmt::format("\"{}\" cannot be written: {}", file.final.string(), cause));
  }
  for (const auto& file : files_) {
    std::error_code problem;
    fs::rename(file.temporary, file.final, problem);
    if (problem) throw failure(fmt::format("\"{}\" cannot be written: {}", file.final.string(), problem.message()));
  }
  files_.clear();
  for (const auto& path : superseded_) {
    std::error_code ignored;  // Not there, or a folder of the user's.
    if (fs::is_regular_file(path, ignored)) fs::remove(path, ignored);
  }
}

std::string final_name(const fs::path& path) {
  const auto name = path.filename().string();
  const auto ending = temporary_ending();
  if (!name.starts_with('.') || !name.ends_with(ending) || name.size() <= 1 + ending.size()) return path.string();
  return (path.parent_path() / name.substr(1, name.size() - 1 - ending.size())).string();
}

void write_file(const fs::path& path, std::string_view bytes) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  const auto refuse = [&](int code) {
    throw failure(fmt::format("\"{}\" cannot be written: {}", final_name(path), std::generic_category().message(code)));
  };
  if (file < 0) refuse(errno);
  while (!bytes.empty()) {
    const auto written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int code = errno;
      ::close(file);
      refuse(code);
    }
    bytes.remove_prefix(std::size_t(written));
  }
  if (::close(file) != 0) refuse(errno);
}

}  // namespace choreo::outputs

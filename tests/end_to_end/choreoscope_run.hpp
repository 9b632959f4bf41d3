// SPDX-License-Identifier: Apache-2.0
// The built program, its results, and how it must refuse.
#pragma once

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/npy_file.hpp"
#include "support/places.hpp"
#include "support/program.hpp"
#include "support/temp_folder.hpp"

namespace choreo::test {

/// Without the person network, as on a machine without npm: what is asked here does not depend on whether it came.
inline Outcome choreoscope(const std::vector<std::string>& arguments, RunOptions options = {}) {
  options.environment.emplace_back("XDG_CACHE_HOME", "/nonexistent");
  return run_program(program(), arguments, options);
}

/// As a user runs it who has the network, or has it not.
inline Outcome choreoscope_with_network(const std::vector<std::string>& arguments, const RunOptions& options = {}) {
  return run_program(program(), arguments, options);
}

/// Everything below a folder, hidden files too, as paths relative to it.
inline std::set<std::string> files_in(const std::string& folder) {
  std::set<std::string> names;
  if (!std::filesystem::exists(folder)) return names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    names.insert(std::filesystem::relative(entry.path(), folder).string());
  }
  return names;
}

/// What `analyze` writes, read back.
struct Results {
  nlohmann::json summary;
  NpyFile z, zstar, times;
  std::size_t n = 0;
  std::vector<float> z_values, zstar_values;
  std::vector<double> time_s;

  explicit Results(const std::string& folder)
      : z(read_npy(folder + "/z.npy")), zstar(read_npy(folder + "/zstar.npy")), times(read_npy(folder + "/times.npy")) {
    const auto text = read_bytes(folder + "/summary.json");
    summary = nlohmann::json::parse(text.begin(), text.end());
    z_values = z.values<float>();
    zstar_values = zstar.values<float>();
    time_s = times.values<double>();
    n = time_s.size();
  }
  [[nodiscard]] double Z(std::size_t a, std::size_t b) const { return z_values.at(a * n + b); }
  [[nodiscard]] double Zstar(std::size_t a, std::size_t b) const { return zstar_values.at(a * n + b); }
};

/// A file of the person network that is missing; empty: none is. Tests that need it skip with its name.
inline std::string missing_person_network() {
  const auto listed = nlohmann::json::parse(choreoscope_with_network({"devices", "--json"}).out);
  for (const auto& model : listed.at("models")) {
    if (!model.at("is_there").get<bool>()) return model.at("file").get<std::string>();
  }
  return {};
}

/// Runs `analyze`, which must end with 0.
inline Outcome analyze(const std::string& source, const std::string& out, const std::vector<std::string>& more = {},
                       const RunOptions& options = {}, decltype(choreoscope)* program = choreoscope) {
  std::vector<std::string> arguments{"analyze", source, "--out", out};
  arguments.insert(arguments.end(), more.begin(), more.end());
  auto run = program(arguments, options);
  EXPECT_EQ(run.status, 0) << run.told();
  return run;
}

/// Likewise as a user runs it.
inline Outcome analyze_with_network(const std::string& source, const std::string& out,
                                    const std::vector<std::string>& more = {}, const RunOptions& options = {}) {
  return analyze(source, out, more, options, [](const std::vector<std::string>& arguments, RunOptions given) {
    return choreoscope_with_network(arguments, given);
  });
}

/// Checks that `run` ended with `status` and one line that says why, and returns that line without its beginning.
///
/// Beside it there may be lines of progress, and one hint behind it; nothing else, of no library either.
inline std::string complaint_of(const Outcome& run, int status) {
  const auto errors = run.err_lines("choreoscope: error: ");
  const auto hints = run.err_lines("hint: ");
  const auto lines = run.err_lines();
  const auto strays = std::count_if(lines.begin(), lines.end(), [](const std::string& line) {
    return !line.starts_with("choreoscope: ") && !line.starts_with("hint: ");
  });
  const bool at_the_end = !lines.empty() && lines.back().starts_with(hints.empty() ? "choreoscope: error: " : "hint: ");
  const bool fits = run.status == status && run.out.empty() && errors.size() == 1 && !errors[0].empty() &&
                    hints.size() <= 1 && strays == 0 && at_the_end;
  EXPECT_TRUE(fits) << "not one line that says what is wrong and status " << status << ": " << run.told();
  return errors.empty() ? std::string() : errors[0];
}

inline std::string hint_of(const Outcome& run) {
  const auto hints = run.err_lines("hint: ");
  return hints.empty() ? std::string() : hints.back();
}

}  // namespace choreo::test

// SPDX-License-Identifier: Apache-2.0
// choreoscope_bench: how fast choreoscope is, beside its peers and the machine's limits. Users call script/bench.
#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "core/error.hpp"
#include "core/text.hpp"
#include "report.hpp"

namespace {

using namespace choreo::bench;

struct Entry {
  const char* name;
  const char* about;
  Benchmark run;
};

constexpr std::array kBenchmarks = {
    Entry{"kernels", "Z and Z* of masks: all pairs, and one live row against the history", &kernels},
    Entry{"chain", "the whole way of a live frame, on one thread and on two", &chain},
    Entry{"confidence", "how often a sign is right of which so much confidence is told", &confidence},
    Entry{"looks", "the whole way of a signaller's frame to its letter with the person network", &looks},
    Entry{"signals", "the whole way of a signaller's frame to its letter, and each stage beside plain OpenCV",
          &signals},
    Entry{"semaphore", "letters and words of synthetic signallers, from pictures to text: how many are right",
          &semaphore},
    Entry{"background", "masks of what differs from the background: how good they are where leaves move", &background},
    Entry{"people", "a look of the person network, on one thread and on two", &people},
};

void print(const Report& report) {
  std::vector<std::array<std::string, 6>> rows{{"", "peer", "ours", "limit", "ours/peer", "ours/limit"}};
  for (const auto& l : report.lines) rows.push_back({l.what, l.peer, l.ours, l.limit, l.to_peer, l.to_limit});
  std::array<std::size_t, 6> widths{};
  for (const auto& row : rows) {
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], row[k].size());
  }
  for (const auto& note : report.notes) fmt::print("  {}\n", note);
  for (const auto& row : rows) {
    fmt::print("  {:<{}}", row[0], widths[0]);
    for (std::size_t k = 1; k < row.size(); ++k) fmt::print("  {:>{}}", row[k], widths[k]);
    fmt::print("\n");
  }
  std::fflush(stdout);
}

int run(const std::vector<std::string>& only, const Settings& settings, const std::string& json_path) {
  std::vector<std::string> names;
  for (const auto& entry : kBenchmarks) names.emplace_back(entry.name);
  for (const auto& name : only) {
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      throw choreo::usage_error(fmt::format("there is no benchmark \"{}\"", name), "--only",
                                "known: " + choreo::join(names));
    }
  }
  nlohmann::ordered_json figures = nlohmann::ordered_json::object();
  for (const auto& entry : kBenchmarks) {
    if (!only.empty() && std::find(only.begin(), only.end(), entry.name) == only.end()) continue;
    fmt::print("{}: {}\n", entry.name, entry.about);
    Report report;
    entry.run(settings, report);
    print(report);
    figures.update(report.figures);
  }
  if (!json_path.empty()) {
    std::ofstream file(json_path);
    file << figures.dump(2) << '\n';
    file.close();
    if (!file) throw choreo::failure(fmt::format("\"{}\" cannot be written", json_path), "--json");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("How fast choreoscope is, beside its peers and the machine's limits", "script/bench");
  Settings settings;
  std::vector<std::string> only;
  std::string json_path;
  app.add_flag("--quick", settings.quick, "fewer repetitions: seconds instead of minutes");
  app.add_flag("--smoke", settings.smoke, "everything once, on very little: whether it runs, not how fast");
  app.add_option("--only", only, "benchmarks to run (default: all)")->type_name("NAME ...");
  app.add_option("--plot", settings.plot, "draw the confidence's plot to this file, a PNG")->type_name("FILE");
  app.add_option("--json", json_path, "write the ratios to this file")->type_name("FILE");
  try {
    app.parse(argc, argv);
    return run(only, settings, json_path);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const choreo::Error& error) {
    fmt::print(stderr, "script/bench: error: {}\n", error.what());
    if (!error.hint().empty()) fmt::print(stderr, "hint: {}\n", error.hint());
    return static_cast<int>(error.fault());
  } catch (const std::exception& error) {
    fmt::print(stderr, "script/bench: error: {}\n", error.what());
    return 1;
  }
}

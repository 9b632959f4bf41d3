// SPDX-License-Identifier: Apache-2.0
// What every benchmark gets and gives.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace choreo::bench {

struct Settings {
  bool quick = false;  ///< Fewer repetitions and pairs; the same figures, less steady.
  bool smoke = false;  ///< Everything once, on very little: figures that mean nothing, for a test.
  std::string plot;    ///< A PNG file for what is better drawn than told; empty: none.
};

/// One line of a table: what was measured and what it is compared with. Empty cells are not known.
struct Line {
  std::string what;
  std::string peer;
  std::string ours;
  std::string limit;
  std::string to_peer;
  std::string to_limit;
};

/// What a benchmark found: tables for people, numbers by key for programs.
struct Report {
  std::vector<std::string> notes;  ///< What was compared with what, under which conditions.
  std::vector<Line> lines;
  nlohmann::ordered_json figures;
};

/// One file in bench/ defines one of these; bench/main.cpp lists them.
using Benchmark = void (*)(const Settings& settings, Report& report);

void kernels(const Settings& settings, Report& report);
void chain(const Settings& settings, Report& report);
void confidence(const Settings& settings, Report& report);
void looks(const Settings& settings, Report& report);
void signals(const Settings& settings, Report& report);
void semaphore(const Settings& settings, Report& report);
void background(const Settings& settings, Report& report);
void people(const Settings& settings, Report& report);

}  // namespace choreo::bench

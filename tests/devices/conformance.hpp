// SPDX-License-Identifier: Apache-2.0
// What every driver promises, whatever it reads: written once (conformance.cpp), asked of each.
//
// A test program that has conformance.cpp among its sources says in `conformance_subjects` what there is to ask.
#pragma once

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "devices/registry.hpp"

namespace choreo::devices {

struct ConformanceSubject {
  std::string name;                     ///< A word, for the test's name.
  Driver driver;                        ///< Freshly made.
  std::string source;                   ///< A SOURCE of at least 20 frames.
  std::string wrong_mode;               ///< A SOURCE that the driver must refuse for its settings.
  std::function<void()> lose = {};      ///< Takes the device away; empty for what cannot go away.
  std::function<void()> find = {};      ///< Brings it back.
  std::shared_ptr<void> keeps_up = {};  ///< What the source needs to be there.

  friend void PrintTo(const ConformanceSubject& subject, std::ostream* out) { *out << subject.name; }
};

enum class ConformanceKind {
  kRecording,  ///< Repeatable, and always there.
  kCamera,     ///< Has `lose` and `find`.
  kPlayer,     ///< Neither: what stands for a camera and cannot go away.
};

struct ConformanceCase {
  std::string name;
  ConformanceKind kind;
  std::function<ConformanceSubject()> make;  ///< Anew for each test.

  friend void PrintTo(const ConformanceCase& one, std::ostream* out) { *out << one.name; }
};

[[nodiscard]] std::vector<ConformanceCase> conformance_subjects();

}  // namespace choreo::devices

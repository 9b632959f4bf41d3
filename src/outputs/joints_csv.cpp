// SPDX-License-Identifier: Apache-2.0
#include "outputs/joints_csv.hpp"

#include <iterator>

#include <fmt/format.h>

namespace choreo::outputs {
namespace {

constexpr std::size_t kNumbers = std::tuple_size_v<PersonJoints::Point>;

float between(float a, float b, double share) { return float((1 - share) * double(a) + share * double(b)); }

PersonJoints between(const PersonJoints& a, const PersonJoints& b, double share) {
  PersonJoints out;
  out.score = between(a.score, b.score, share);
  for (std::size_t k = 0; k < out.points.size(); ++k) {
    for (std::size_t i = 0; i < kNumbers; ++i) {
      out.points[k][i] = between(a.points[k][i], b.points[k][i], share);
    }
  }
  return out;
}

void write(std::string& csv, const PersonJoints& person) {
  const auto out = std::back_inserter(csv);
  fmt::format_to(out, "{:.3f}", person.score);
  for (const auto& p : person.points) {
    fmt::format_to(out, ",{:.2f},{:.2f},{:.3f},{:.4f},{:.4f},{:.4f}", p[0], p[1], p[2], p[3], p[4], p[5]);
  }
}

}  // namespace

JointsLook::JointsLook(double time, const vision::PersonLook* look) : time_s(time) {
  if (look == nullptr) return;
  person.emplace();
  person->score = float(look->score);
  for (std::size_t k = 0; k < look->points.size(); ++k) {
    const auto& p = look->points[k];
    const auto& m = look->metres[k];
    person->points[k] = {float(p.at.x), float(p.at.y), float(p.visibility), float(m.x), float(m.y), float(m.z)};
  }
}

std::string joints_csv(std::span<const JointsFrame> frames, std::span<const JointsLook> looks) {
  std::string csv = "frame,time_s,looked,score";
  for (const char* name : vision::kPersonPointNames) {
    for (const char* what : {"x_px", "y_px", "visibility", "x_m", "y_m", "z_m"}) {
      fmt::format_to(std::back_inserter(csv), ",{}_{}", name, what);
    }
  }
  csv += '\n';
  std::size_t next = 0;  // The first look at or behind the frame.
  for (const auto& frame : frames) {
    while (next < looks.size() && looks[next].time_s < frame.time_s) ++next;
    const bool looked = next < looks.size() && looks[next].time_s == frame.time_s;
    fmt::format_to(std::back_inserter(csv), "{},{:.6f},{:d},", frame.frame, frame.time_s, looked);
    if (looked && looks[next].person) {
      write(csv, *looks[next].person);
    } else if (!looked && next > 0 && next < looks.size() && looks[next - 1].person && looks[next].person) {
      const auto& a = looks[next - 1];
      const auto& b = looks[next];
      write(csv, between(*a.person, *b.person, (frame.time_s - a.time_s) / (b.time_s - a.time_s)));
    } else {
      csv.append(kNumbers * vision::kPersonPoints, ',');
    }
    csv += '\n';
  }
  return csv;
}

}  // namespace choreo::outputs

// SPDX-License-Identifier: Apache-2.0
// What is asked of every driver, asked of libfreenect's on fakenect. It plays a dump once and never rewinds, so that
// the dump is long: many names of a few pictures. What it does at its end is freenect_test's business.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "devices/conformance.hpp"
#include "devices/freenect/freenect_driver.hpp"
#include "devices/kinect_fixture.hpp"
#include "pipeline/steady_clock.hpp"
#include "support/temp_folder.hpp"

namespace choreo::devices {
namespace {

ConformanceSubject fakenect() {
  static const pipeline::SteadyClock clock;
  constexpr int kFrames = 600;
  const auto dump = std::make_shared<test::TempFolder>();
  {
    outputs::KinectDumpWriter writer(dump->path());
    writer.write_colour(test::kinect_colour(1), std::chrono::seconds(100));
    writer.write_words(test::kinect_words(1), std::chrono::milliseconds(100'004));
  }
  std::ifstream index(*dump / "INDEX.txt");
  std::string colour;
  std::string depth;
  index >> colour >> depth;
  std::ofstream longer(*dump / "INDEX.txt", std::ios::app);
  for (int k = 1; k < kFrames; ++k) {
    const double at = 100 + k / 30.0;
    const auto name = [&](char kind, double late, const char* ending) {
      return fmt::format("{}-{:.6f}-{}.{}", kind, at + late, std::uint32_t(std::uint64_t((at + late) * 60e6)), ending);
    };
    for (const auto& [from, to] : {std::pair{colour, name('r', 0, "ppm")}, {depth, name('d', 0.004, "pgm")}}) {
      std::filesystem::create_hard_link(*dump / from, *dump / to);
      longer << to << '\n';
    }
  }
  longer.close();
  ::setenv("FAKENECT_PATH", dump->path().c_str(), 1);
  return {"fakenect", freenect_driver(clock), "freenect://", "freenect://?depth=deep", {}, {}, dump};
}

}  // namespace

std::vector<ConformanceCase> conformance_subjects() { return {{"fakenect", ConformanceKind::kPlayer, fakenect}}; }

}  // namespace choreo::devices

// SPDX-License-Identifier: Apache-2.0
// Live runs with a window on a real X server.
#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include <gmock/gmock.h>

#include "end_to_end/refusal_fixture.hpp"
#include "support/eventually.hpp"
#include "support/x_server.hpp"

namespace choreo::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

#define NEEDS(server) ASSERT_FALSE((server).display().empty()) << "Xvfb cannot be started; it is in script/packages.txt"

// Waits until a thread of the process has that name. @return false where it ended without, or after half a minute.
bool wait_for_thread(int process, const std::string& name) {
  namespace fs = std::filesystem;
  bool found = false;
  const auto found_or_gone = [&] {
    std::error_code gone;
    fs::directory_iterator task("/proc/" + std::to_string(process) + "/task", gone);
    for (; !gone && task != fs::directory_iterator(); task.increment(gone)) {
      std::string comm;
      std::ifstream(task->path() / "comm") >> comm;
      found = found || comm == name;
    }
    return found || gone;
  };
  return eventually(found_or_gone, std::chrono::seconds(30)) && found;
}

class LiveOnADisplay : public RefusalTest {
 protected:
  Outcome live(const XServer& server, const std::string& source, RunOptions options = {}) {
    options.environment.emplace_back("DISPLAY", server.display());
    options.environment.emplace_back("SDL_VIDEODRIVER", "x11");
    return choreoscope({"live", source, "--out", folder_ / "live"}, options);
  }
};

TEST_F(LiveOnADisplay, ShowsItsWindowAndEndsByItself) {
  const XServer server;
  NEEDS(server);
  std::atomic<bool> had_a_window = false;
  std::jthread witness;
  RunOptions options;
  options.started = [&](int process) {
    witness = std::jthread([&had_a_window, process] { had_a_window = wait_for_thread(process, "window"); });
  };
  const auto run = live(server, "synthetic://walking?size=160x120&fps=15&duration=2", options);
  witness.join();
  EXPECT_TRUE(had_a_window);
  EXPECT_EQ(run.status, 0) << run.told();
  EXPECT_THAT(run.err, Not(HasSubstr("no display"))) << run.told();
  EXPECT_THAT(run.err, Not(HasSubstr("window"))) << run.told();
}

TEST_F(LiveOnADisplay, WhereTheDisplayGoesAwayOnlyTheWindowEnds) {
  XServer server;
  NEEDS(server);
  std::jthread saboteur;
  RunOptions options;
  options.started = [&](int process) {
    saboteur = std::jthread([&server, process] {
      if (!wait_for_thread(process, "picture")) return;  // The stages start when the window is there.
      server.crash();
    });
  };
  const auto run = live(server, "synthetic://walking?size=160x120&fps=15&duration=8", options);
  EXPECT_EQ(run.status, 0) << run.told();
  EXPECT_THAT(run.err, HasSubstr("the display is gone: the run goes on without its window"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "live" + "/z.npy")) << run.told();
}

TEST_F(LiveOnADisplay, ADisplayThatCannotBeOpenedIsSaidInOneLine) {
  RunOptions options;
  options.environment.emplace_back("DISPLAY", ":987");
  options.environment.emplace_back("SDL_VIDEODRIVER", "x11");
  const auto run = choreoscope({"live", kQuick, "--out", folder_ / "live"}, options);
  EXPECT_THAT(complaint_of(run, 1), HasSubstr("no window can be opened"));
  EXPECT_THAT(hint_of(run), HasSubstr("--headless"));
}

}  // namespace
}  // namespace choreo::test

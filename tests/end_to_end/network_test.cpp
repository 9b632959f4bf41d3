// SPDX-License-Identifier: Apache-2.0
// Live runs of the built program from a camera on the network: cut and back, frozen, not there.
#include <csignal>
#include <future>
#include <thread>

#include <gmock/gmock.h>

#include "end_to_end/choreoscope_run.hpp"
#include "support/loopback_server.hpp"
#include "support/motion_jpeg.hpp"

namespace choreo::test {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

class NetworkLive : public ::testing::Test {
 protected:
  Outcome live(const std::string& source, const std::vector<std::string>& more, const RunOptions& options = {}) {
    std::vector<std::string> arguments{"live", source, "--headless", "--out", folder_ / "live"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return choreoscope(arguments, options);
  }

  TempFolder folder_;
};

TEST_F(NetworkLive, GoesOnWhereTheCameraIsCutAndBack) {
  std::promise<void> sent;
  auto server = std::make_unique<LoopbackServer>([&sent, first = true](Caller& caller) mutable {
    (void)caller.request();
    bool there = send_multipart_head(caller);
    for (int k = 0; there && k < 100; ++k) there = send_part(caller, jpeg_of(numbered_picture(k))) && caller.wait(25ms);
    if (there && std::exchange(first, false)) sent.set_value();
    caller.wait_for_the_end();
  });
  const int port = server->port();
  const auto source = "http://me:s3cret@127.0.0.1:" + std::to_string(port) + "/video?size=small";
  auto run = std::async(std::launch::async, [&] {
    return live(source, {"--span", "0:4.5", "--background", "first:0.5s"});
  });
  ASSERT_EQ(sent.get_future().wait_for(60s), std::future_status::ready);
  server.reset();
  std::this_thread::sleep_for(700ms);  // The cable is out.
  server = std::make_unique<LoopbackServer>([](Caller& caller) { serve_motion_jpeg(caller, 25ms); }, port);
  const auto outcome = run.get();
  EXPECT_EQ(outcome.status, 0) << outcome.told();
  const Results results(folder_ / "live");
  EXPECT_GT(results.n, 60U) << "before the cut and after it there are more than 100";
  double longest = 0;
  for (std::size_t k = 1; k < results.n; ++k) {
    ASSERT_GT(results.time_s[k], results.time_s[k - 1]);
    longest = std::max(longest, results.time_s[k] - results.time_s[k - 1]);
  }
  EXPECT_GT(longest, 0.6) << "the gap stays a gap";
  EXPECT_LT(longest, 3);
  EXPECT_EQ(results.summary["source"], "http://me:***@127.0.0.1:" + std::to_string(port) + "/video?size=small");
  EXPECT_THAT(results.summary["warnings"].get<std::vector<std::string>>(), Contains(HasSubstr("was lost 1 time")));
  EXPECT_THAT(outcome.told(), Not(HasSubstr("s3cret")));
}

TEST_F(NetworkLive, CtrlCEndsItWhileTheCameraIsFrozen) {
  std::promise<void> frozen;
  const LoopbackServer server([&, first = true](Caller& caller) mutable {
    (void)caller.request();
    bool there = send_multipart_head(caller);
    for (int k = 0; there && k < 170; ++k) there = send_part(caller, jpeg_of(numbered_picture(k))) && caller.wait(25ms);
    if (there && std::exchange(first, false)) frozen.set_value();
    caller.wait_for_the_end();
  });
  RunOptions options;
  options.pokes = {{" is lost: ", SIGINT}};
  auto run = std::async(std::launch::async, [&] { return live(server.address() + "/?silence=3", {}, options); });
  ASSERT_EQ(frozen.get_future().wait_for(60s), std::future_status::ready);
  const auto begin = std::chrono::steady_clock::now();
  const auto outcome = run.get();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 8s) << "lost after three seconds, and no wait after that";
  EXPECT_EQ(outcome.poked, 1U) << outcome.told();
  EXPECT_EQ(outcome.status, 130) << outcome.told();
  EXPECT_GT(Results(folder_ / "live").n, 20U) << "what was seen is kept";
}

TEST_F(NetworkLive, ARecordingIsPlayedAtItsOwnTime) {
  ASSERT_EQ(choreoscope({"synth", "walking?size=64x48&fps=30&duration=1&empty=0", "-o", folder_ / "clip.mkv"}).status,
            0);
  const LoopbackServer server([bytes = read_bytes(folder_ / "clip.mkv")](Caller& caller) {
    (void)caller.request();
    if (caller.send("HTTP/1.1 200 OK\r\nConnection: close\r\nContent-Length: " + std::to_string(bytes.size()) +
                    "\r\n\r\n")) {
      (void)caller.send(bytes);
    }
  });
  const auto outcome = live(server.address() + "/clip.mkv", {"--background", "first:0.2s"});
  ASSERT_EQ(outcome.status, 0) << outcome.told();
  const Results results(folder_ / "live");
  EXPECT_EQ(results.n + results.summary["timings"]["dropped"].get<std::size_t>(), 30U);
  EXPECT_GE(results.summary["timings"]["frames_s"], 0.9);
}

TEST_F(NetworkLive, WhereNobodyIsItIsRefusedAndShowsNoPassword) {
  const auto host = "127.0.0.1:" + std::to_string(deserted_port());
  for (const std::string scheme : {"http", "rtsp"}) {
    const auto outcome = live(scheme + "://me:s3cret@" + host + "/", {});
    EXPECT_THAT(complaint_of(outcome, 2), AllOf(HasSubstr(scheme + "://me:***@" + host), HasSubstr("refused")));
    EXPECT_THAT(outcome.told(), Not(HasSubstr("s3cret")));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "live")) << "left behind";
  }
}

}  // namespace
}  // namespace choreo::test

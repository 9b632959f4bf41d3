// SPDX-License-Identifier: Apache-2.0
// Cameras on the network that refuse, send rubbish, freeze, go away and come back.
#include <atomic>
#include <cstdio>

#include "devices/network_fixture.hpp"

namespace choreo::devices {
namespace {

using test::Caller;
using test::LoopbackServer;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class NetworkTrouble : public NetworkTest {
 protected:
  /// A server that sends `text` whatever it is asked, and then waits or hangs up.
  static auto says(std::string text, bool waits = false) {
    return [text, waits](Caller& caller) {
      (void)caller.request();
      if (caller.send(text) && waits) caller.wait_for_the_end();
    };
  }
  static std::string reply(const std::string& status, const std::string& type, const std::string& body) {
    return "HTTP/1.0 " + status + "\r\nContent-Type: " + type + "\r\nContent-Length: " + std::to_string(body.size()) +
           "\r\n\r\n" + body;
  }
};

TEST_F(NetworkTrouble, WhereNobodyListensIsTheUsersMistake) {
  for (const std::string scheme : {"http", "rtsp", "tcp"}) {
    const auto error = refusal(scheme + "://127.0.0.1:" + std::to_string(test::deserted_port()) + "/video");
    EXPECT_THAT(error.what(), HasSubstr("Connection refused")) << scheme;
    EXPECT_THAT(error.hint(), HasSubstr("check the address"));
  }
  EXPECT_THAT(refusal("http://no-such-host.invalid/video?patience=2", 4s).what(), HasSubstr("no-such-host.invalid"));
}

TEST_F(NetworkTrouble, WhatTheServerRefusesIsToldInItsWords) {
  const LoopbackServer missing(says(reply("404 Not Found", "text/html", "<html>no</html>")));
  EXPECT_THAT(refusal(missing.address()).what(), HasSubstr("404"));
  EXPECT_THAT(refusal(missing.address()).hint(), HasSubstr("path"));
  const LoopbackServer locked(
      says("HTTP/1.0 401 Unauthorized\r\nWWW-Authenticate: Basic realm=\"camera\"\r\nContent-Length: 0\r\n\r\n"));
  EXPECT_THAT(refusal(locked.address()).what(), HasSubstr("401"));
  EXPECT_THAT(refusal(locked.address()).hint(), HasSubstr("name:password@"));
}

TEST_F(NetworkTrouble, WhatAnRtspServerRefusesIsToldAsWell) {
  const auto answers = [](const std::string& status) {
    return [status](Caller& caller) {
      for (auto ask = caller.request(); !ask.empty(); ask = caller.request()) {
        const auto number = ask.substr(ask.find("CSeq:"));
        (void)caller.send("RTSP/1.0 " + status + "\r\n" + number.substr(0, number.find("\r\n")) + "\r\n\r\n");
      }
    };
  };
  const LoopbackServer missing(answers("404 Not Found"));
  EXPECT_THAT(refusal(missing.address("rtsp") + "/live").what(), HasSubstr("404"));
  const LoopbackServer locked(answers("401 Unauthorized"));
  EXPECT_THAT(refusal(locked.address("rtsp") + "/live").hint(), HasSubstr("name:password@"));
}

TEST_F(NetworkTrouble, WhatIsNoVideoIsRefused) {
  std::string noise;
  cv::RNG random(7);
  for (int k = 0; k < 300000; ++k) noise += char(random.uniform(0, 256));
  const LoopbackServer page(says(reply("200 OK", "text/html", "<html>" + std::string(5000, 'x') + "</html>")));
  const LoopbackServer text(says(reply("200 OK", "text/plain", "There is no camera here.\n")));
  const LoopbackServer rubbish(says("HTTP/1.0 200 OK\r\n\r\n" + noise));
  const LoopbackServer bare(says(noise.substr(0, 5000)));
  const LoopbackServer empty(says(reply("200 OK", "image/jpeg", "")));
  const LoopbackServer nothing(says(""));
  const LoopbackServer parts(
      says("HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=next\r\n\r\n"
           "--next\r\nContent-Type: text/html\r\nContent-Length: 5\r\n\r\nhello\r\n"));
  const LoopbackServer length(
      says("HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=next\r\n\r\n"
           "--next\r\nContent-Type: image/jpeg\r\nContent-Length: -7\r\n\r\nhello\r\n"));
  for (const auto* server : {&page, &text, &rubbish, &bare, &empty, &nothing, &parts, &length}) {
    EXPECT_FALSE(refusal(server->address() + "/video?patience=1").hint().empty());
  }
  EXPECT_THAT(refusal(rubbish.address("rtsp") + "/video?patience=1").what(), HasSubstr("rtsp://127.0.0.1"));
}

TEST_F(NetworkTrouble, WhoeverStaysSilentIsRefusedWhenPatienceIsOver) {
  const LoopbackServer silent([](Caller& caller) { caller.wait_for_the_end(); });
  const LoopbackServer half(
      says("HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=next\r\n\r\n"
           "--next\r\nContent-Type: image/jpeg\r\nContent-Length: 5000\r\n\r\nhalf",
           true));
  const LoopbackServer heads([](Caller& caller) {
    (void)caller.request();
    bool there = caller.send("HTTP/1.0 200 OK\r\n");
    while (there) there = caller.send("X-More: and so on\r\n");
  });
  const LoopbackServer line([](Caller& caller) {
    (void)caller.request();
    while (caller.send(std::string(1000, 'x'))) continue;
  });
  for (const auto* server : {&silent, &half, &heads, &line}) {
    EXPECT_THAT(refusal(server->address() + "/video?patience=0.5").what(),
                AllOf(HasSubstr("does not answer"), HasSubstr("within 0.5 s")));
  }
  EXPECT_THAT(refusal(silent.address("rtsp") + "/video?patience=0.5").what(), HasSubstr("within 0.5 s"));
}

TEST_F(NetworkTrouble, APictureWithoutEndIsNotCollected) {
  const LoopbackServer flood([](Caller& caller) {
    (void)caller.request();
    (void)test::send_multipart_head(caller);
    (void)caller.send("--next\r\nContent-Type: image/jpeg\r\nContent-Length: 2000000000\r\n\r\n");
    const std::string much(1U << 20U, 'x');
    while (caller.send(much)) continue;
  });
  EXPECT_THAT(refusal(flood.address() + "?patience=20", 10s).what(), HasSubstr("without end"));
}

TEST_F(NetworkTrouble, SettingsOutOfRangeAreRefused) {
  for (const auto* settings : {"patience=0", "patience=never", "silence=-1", "silence=1e9"}) {
    EXPECT_TRUE(test::error_of([&] { (void)open(std::string("http://127.0.0.1:1/?") + settings); })) << settings;
  }
  for (const auto* settings : {"transport=sctp", "listen=perhaps"}) {
    EXPECT_TRUE(test::error_of([&] { (void)open(std::string("rtsp://127.0.0.1:1/?") + settings); })) << settings;
  }
}

TEST_F(NetworkTrouble, OneThatClosesIsLostAtOnceAndTakenUpAgain) {
  auto server = std::make_unique<LoopbackServer>([](Caller& caller) { test::serve_motion_jpeg(caller); });
  const int port = server->port();
  const auto source = open(server->address());
  FramePtr before;
  for (int k = 0; k < 5; ++k) before = read(*source);
  ASSERT_TRUE(before);
  const auto cut = clock_.now();
  server.reset();
  ASSERT_TRUE(read_until(*source, DeviceState::kLost));
  EXPECT_LT(events_.back().at - cut, 1s);
  EXPECT_THAT(events_.back().why, HasSubstr("ended the stream"));
  EXPECT_EQ(read(*source, 400ms), nullptr) << "nobody is there";
  EXPECT_EQ(events_.back().state, DeviceState::kLost);
  const auto back = clock_.now();
  server = std::make_unique<LoopbackServer>([](Caller& caller) { test::serve_motion_jpeg(caller); }, port);
  ASSERT_TRUE(read_until(*source, DeviceState::kRunning));
  EXPECT_LT(events_.back().at - back, 2s);
  const auto after = read(*source);
  ASSERT_TRUE(after);
  EXPECT_GT(after->sequence, before->sequence + 1);
  EXPECT_GT(after->device_time, before->device_time + 400ms);
  EXPECT_THAT(states(), ElementsAre("starting", "running", "lost", "running"));
  EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("was lost 1 time")));
  std::printf("closed: lost %.0f ms later; listening again: running %.0f ms later\n",
              1e3 * to_seconds(events_[2].at - cut), 1e3 * to_seconds(events_[3].at - back));
}

TEST_F(NetworkTrouble, OneThatFreezesIsLostWithinASecondAndTakenUpAgain) {
  std::atomic<bool> frozen{false};
  const LoopbackServer server([&](Caller& caller) {
    (void)caller.request();
    bool there = test::send_multipart_head(caller);
    for (int k = 0; there; ++k) {
      const auto jpeg = test::jpeg_of(test::numbered_picture(k));
      if (frozen) {
        (void)caller.send("--next\r\nContent-Type: image/jpeg\r\nContent-Length: " + std::to_string(jpeg.size()) +
                          "\r\n\r\n");
        (void)caller.send(std::span(jpeg).first(jpeg.size() / 2));
        return caller.wait_for_the_end();
      }
      there = test::send_part(caller, jpeg) && caller.wait(20ms);
    }
  });
  const auto source = open(server.address());
  auto last = read(*source);
  frozen = true;
  while (auto frame = read(*source, 100ms)) last = frame;
  ASSERT_TRUE(read_until(*source, DeviceState::kLost));
  // Between the last picture and the one that froze there were 20 ms.
  EXPECT_LT(events_.back().at - last->device_time, 1020ms);
  EXPECT_THAT(events_.back().why, HasSubstr("no frame for"));
  EXPECT_EQ(read(*source, 300ms), nullptr);
  EXPECT_EQ(events_.back().state, DeviceState::kLost) << "half a picture is none";
  frozen = false;
  EXPECT_TRUE(read_until(*source, DeviceState::kRunning));
  EXPECT_TRUE(read(*source));
}

TEST_F(NetworkTrouble, ASlowCameraIsGivenTheTimeItNeeds) {
  const LoopbackServer server([](Caller& caller) { test::serve_motion_jpeg(caller, 1200ms); });
  const auto source = open(server.address() + "/?silence=3");
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(read(*source));
  EXPECT_THAT(states(), ElementsAre("starting", "running"));
}

TEST_F(NetworkTrouble, OneThatComesBackWithOtherPicturesIsNotTaken) {
  std::atomic<int> width{160};
  const LoopbackServer server([&](Caller& caller) {
    (void)caller.request();
    bool there = test::send_multipart_head(caller);
    for (int k = 0; there; ++k) {
      there = test::send_part(caller, test::jpeg_of(test::numbered_picture(k, {width, 96}))) && caller.wait(20ms);
    }
  });
  const auto source = open(server.address());
  EXPECT_TRUE(read(*source));
  width = 320;
  ASSERT_TRUE(read_until(*source, DeviceState::kLost)) << "pictures of another size are none";
  EXPECT_EQ(read(*source, 1s), nullptr);
  EXPECT_THAT(source->warnings(), Contains(HasSubstr("320 x 96 instead of 160 x 96")));
  width = 160;
  EXPECT_TRUE(read_until(*source, DeviceState::kRunning));
}

TEST_F(NetworkTrouble, OpeningAndReadingEndOnRequest) {
  std::atomic<bool> called{false};
  const LoopbackServer silent([&](Caller& caller) {
    (void)caller.request();
    called = true;
    called.notify_all();
    caller.wait_for_the_end();
  });
  std::stop_source stop;
  const std::jthread later([&] {
    called.wait(false);
    stop.request_stop();
  });
  auto begin = clock_.now();
  const auto error = test::error_of([&] { (void)open(silent.address(), false, stop.get_token()); });
  EXPECT_LT(clock_.now() - begin, 1s);
  ASSERT_TRUE(error);
  EXPECT_THAT(error->what(), HasSubstr("interrupted"));

  const LoopbackServer server([](Caller& caller) {
    (void)caller.request();
    (void)test::send_multipart_head(caller);
    (void)test::send_part(caller, test::jpeg_of(test::numbered_picture(0, {1280, 720})));
    caller.wait_for_the_end();
  });
  const auto source = open(server.address() + "?silence=60");
  EXPECT_TRUE(read(*source));
  begin = clock_.now();
  EXPECT_EQ(read(*source, 150ms), nullptr);
  EXPECT_LT(clock_.now() - begin, 1s);
}

TEST_F(NetworkTrouble, DestructionIsQuickWhateverThePeerDoes) {
  std::atomic<bool> frozen{false};
  const LoopbackServer server([&](Caller& caller) {
    if (frozen) return caller.wait_for_the_end();
    (void)caller.request();
    bool there = test::send_multipart_head(caller);
    for (int k = 0; there && !frozen; ++k) {
      there = test::send_part(caller, test::jpeg_of(test::numbered_picture(k))) && caller.wait(20ms);
    }
    caller.wait_for_the_end();
  });
  const auto took = [&](std::unique_ptr<Source> source) {
    const auto begin = clock_.now();
    source.reset();
    return clock_.now() - begin;
  };
  EXPECT_LT(took(open(server.address())), 500ms) << "while pictures come";
  auto source = open(server.address());
  EXPECT_TRUE(read(*source));
  frozen = true;
  EXPECT_LT(took(std::move(source)), 500ms) << "while it is frozen";
  frozen = false;
  source = open(server.address());
  EXPECT_TRUE(read(*source));
  frozen = true;
  ASSERT_TRUE(read_until(*source, DeviceState::kLost));
  const int callers = server.callers();
  (void)read(*source, 400ms);
  EXPECT_GE(server.callers(), callers);
  EXPECT_LT(took(std::move(source)), 500ms) << "while it is taken up again";
  EXPECT_EQ(events_.back().state, DeviceState::kStopped);
}

TEST_F(NetworkTrouble, ThePasswordOpensAndIsNeverShown) {
  std::atomic<bool> there{true};
  // Base64 of me:s3cret.
  const LoopbackServer server([&](Caller& caller) {
    const auto request = caller.request();
    if (request.find("Authorization: Basic bWU6czNjcmV0") == std::string::npos) {
      (void)caller.send(
          "HTTP/1.1 401 Unauthorized\r\nWWW-Authenticate: Basic realm=\"camera\"\r\nContent-Length: 0\r\n\r\n");
      return;
    }
    bool sending = test::send_multipart_head(caller);
    for (int k = 0; sending && there; ++k) {
      sending = test::send_part(caller, test::jpeg_of(test::numbered_picture(k))) && caller.wait(20ms);
    }
  });
  const auto at = "@127.0.0.1:" + std::to_string(server.port());
  const auto source = open("http://me:s3cret" + at + "/video");
  EXPECT_TRUE(read(*source));
  EXPECT_EQ(source->info().name, "http://me:***" + at + "/video");
  there = false;
  ASSERT_TRUE(read_until(*source, DeviceState::kLost));
  for (const auto& event : events_) EXPECT_THAT(event.why, Not(HasSubstr("s3cret")));
  for (const auto& line : source->warnings()) EXPECT_THAT(line, Not(HasSubstr("s3cret")));
  EXPECT_THAT(refusal("http://me:wr0ng" + at).what(), AllOf(HasSubstr("me:***@"), Not(HasSubstr("wr0ng"))));
  const auto nobody = ":s3cret@127.0.0.1:" + std::to_string(test::deserted_port());
  for (const std::string scheme : {"http://me", "rtsp://me", "rtsps://me"}) {
    const auto error = refusal(scheme + nobody);
    EXPECT_THAT(std::string(error.what()) + error.hint(), Not(HasSubstr("s3cret")));
  }
}

}  // namespace
}  // namespace choreo::devices

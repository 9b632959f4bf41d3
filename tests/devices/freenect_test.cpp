// SPDX-License-Identifier: Apache-2.0
// The libfreenect driver: on fakenect, which plays dumps in place of a Kinect, in a process of its own; and what needs
// no library at all.
#include <sys/stat.h>

#include <algorithm>

#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>

#include <gmock/gmock.h>

#include "devices/freenect/bounded_list.hpp"
#include "devices/freenect/pairing.hpp"
#include "devices/kinect_fixture.hpp"
#include "support/places.hpp"
#include "support/program.hpp"
#include "support/temp_folder.hpp"

namespace choreo::devices::freenect {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::TempFolder;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

// Ticks of 60 MHz.
std::uint32_t ticks(Nanoseconds time) { return static_cast<std::uint32_t>(time.count() * 3 / 50); }

class PairingTest : public ::testing::Test {
 protected:
  bool colour(Nanoseconds at, Nanoseconds arrival, std::uint8_t what = 0) {
    return pairing_.add_colour(&what, ticks(at), arrival);
  }
  bool depth(Nanoseconds at, Nanoseconds arrival, std::uint8_t what = 0) {
    return pairing_.add_depth(&what, ticks(at), arrival);
  }
  bool colour(Nanoseconds at) { return colour(at, at); }
  bool depth(Nanoseconds at) { return depth(at, at); }
  Pairing pairing_{1, 1};
};

TEST_F(PairingTest, WhatIsOfOneMomentIsAPairWhicheverComesFirst) {
  EXPECT_FALSE(colour(100ms, 100ms, 7));
  EXPECT_TRUE(depth(110ms, 110ms, 8));
  EXPECT_EQ(pairing_.colour.bytes[0], 7);
  EXPECT_EQ(pairing_.depth.bytes[0], 8);
  EXPECT_EQ(pairing_.colour.ticks, ticks(100ms));
  EXPECT_FALSE(depth(140ms));
  EXPECT_TRUE(colour(133ms));
}

TEST_F(PairingTest, APictureIsInOnePairOnly) {
  EXPECT_FALSE(colour(100ms));
  EXPECT_TRUE(depth(100ms));
  EXPECT_FALSE(depth(110ms)) << "the colour is used up";
}

TEST_F(PairingTest, ALostPartnerLeavesTheOtherAlone) {
  EXPECT_FALSE(colour(0ms));
  EXPECT_FALSE(colour(33ms));  // The depth of 0 ms was lost.
  EXPECT_TRUE(depth(35ms));
  EXPECT_FALSE(depth(68ms));  // The colour of 66 ms was lost.
  EXPECT_FALSE(colour(100ms));
  EXPECT_TRUE(depth(102ms));
  EXPECT_EQ(pairing_.colour.counter, 3U) << "the lost one shows in the numbers";
}

TEST_F(PairingTest, WhatNeverArrivedLeavesAHoleInTheNumbers) {
  Pairing alone(1, 0);
  const std::uint8_t byte = 0;
  std::vector<std::uint32_t> numbers;
  // Pictures 3 to 6 and 9 are lost; those that come, come up to 90 ms late; the ticks wrap.
  constexpr int kCome[] = {0, 1, 2, 7, 8, 10, 11};
  for (const int k : kCome) {
    const auto at = 71400ms + k * 33'333'333ns;
    ASSERT_TRUE(alone.add_colour(&byte, ticks(at), at + (k * 37 % 90) * 1ms));
    numbers.push_back(alone.colour.counter);
  }
  EXPECT_THAT(numbers, ElementsAre(0, 1, 2, 7, 8, 10, 11));
}

TEST_F(PairingTest, TicksThatJumpInventNoHole) {
  Pairing alone(1, 0);
  const std::uint8_t byte = 0;
  std::vector<std::uint32_t> numbers;
  Nanoseconds arrival = 0s;
  for (const std::uint32_t told : {5U, 2'000'005U, 3'000'000'000U, 3'002'000'000U, 3'002'000'000U}) {
    ASSERT_TRUE(alone.add_colour(&byte, told, arrival));
    numbers.push_back(alone.colour.counter);
    arrival += 33ms;
  }
  EXPECT_THAT(numbers, ElementsAre(0, 1, 2, 3, 4));
}

TEST(PairQueue, GivesTheOldestAndLosesIfItMustTheOldest) {
  PairQueue queue(3, 1, 1);
  Shot colour, depth;
  colour.bytes.resize(1);
  depth.bytes.resize(1);
  EXPECT_FALSE(queue.take(colour, depth));
  for (std::uint8_t k = 0; k < 5; ++k) {
    colour.bytes[0] = k;
    depth.bytes[0] = std::uint8_t(k + 100);
    queue.put(colour, depth);
    ASSERT_EQ(colour.bytes.size(), 1U);
    ASSERT_EQ(depth.bytes.size(), 1U);
  }
  std::vector<int> taken;
  while (queue.take(colour, depth)) {
    taken.push_back(colour.bytes[0]);
    EXPECT_EQ(depth.bytes[0], colour.bytes[0] + 100);
  }
  EXPECT_THAT(taken, ElementsAre(2, 3, 4));
  EXPECT_TRUE(queue.empty());
}

TEST_F(PairingTest, HalfAFrameIsTheLimit) {
  EXPECT_FALSE(colour(100ms));
  EXPECT_FALSE(depth(117ms));
  EXPECT_FALSE(colour(133ms + 700us));
  EXPECT_TRUE(depth(150ms));
}

TEST_F(PairingTest, TicksThatWrapBetweenThemDoNoHarm) {
  const std::uint8_t byte = 0;
  EXPECT_FALSE(pairing_.add_colour(&byte, 0xffffff00U, 0ns));
  EXPECT_TRUE(pairing_.add_depth(&byte, 0x00000100U, 0ns));
}

TEST_F(PairingTest, WithoutDepthEveryColourIsOne) {
  Pairing alone(1, 0);
  const std::uint8_t byte = 5;
  for (std::uint32_t k = 0; k < 3; ++k) {
    EXPECT_TRUE(alone.add_colour(&byte, k, 0ns));
    EXPECT_EQ(alone.colour.counter, k);
  }
}

TEST_F(PairingTest, ClocksThatDisagreeAreGivenUpForTheArrivals) {
  int pairs = 0;
  for (int k = 0; k < 40; ++k) {
    const auto at = k * 33ms;
    pairs += colour(at, at) ? 1 : 0;
    pairs += depth(at + 10s, at + 5ms) ? 1 : 0;  // Ten seconds off, but here.
  }
  EXPECT_TRUE(pairing_.by_arrival());
  EXPECT_GE(pairs, 20);
  EXPECT_LE(pairs, 26) << "half a second went by first";
}

TEST_F(PairingTest, ADepthThatNeverComesIsNoDisagreement) {
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(colour(k * 33ms));
  EXPECT_FALSE(pairing_.by_arrival());
}

TEST(TickClock, GoesOnAsTheTicksDoWhateverTheArrivals) {
  TickClock clock;
  EXPECT_EQ(clock.time(1000, 5s), 0ns);
  EXPECT_EQ(clock.time(1000 + 2'000'000, 5s + 90ms), 33'333'333ns);
  EXPECT_EQ(clock.time(1000 + 5'000'000, 5s + 91ms), 83'333'333ns);
}

TEST(TickClock, GoesOnOverAWrap) {
  TickClock clock;
  (void)clock.time(0xffffffffU - 999'999U, 0s);
  EXPECT_EQ(clock.time(1'000'000, 33ms), 33'333'333ns);
}

TEST(TickClock, TicksThatStandStillOrJumpAreNotBelieved) {
  TickClock clock;
  (void)clock.time(7, 0s);
  EXPECT_EQ(clock.time(7, 33ms), 33ms);
  EXPECT_EQ(clock.time(4'000'000'000U, 66ms), 66ms);
  EXPECT_EQ(clock.time(4'000'000'000U + 2'000'000U, 99ms), 66ms + 33'333'333ns) << "and believed again";
}

TEST(FreenectList, ALookThatTakesTooLongIsGivenUp) {
  const auto let_go = std::make_shared<std::promise<void>>();
  const auto before = std::chrono::steady_clock::now();
  const auto list = list_within(100ms, [waiting = let_go->get_future().share()] {
    waiting.wait();
    return DeviceList();
  });
  EXPECT_LT(std::chrono::steady_clock::now() - before, 5s);
  EXPECT_THAT(list.devices, IsEmpty());
  EXPECT_THAT(list.trouble, HasSubstr("hangs"));
  let_go->set_value();
}

TEST(FreenectList, WhatIsToldInTimeIsPassedOn) {
  const auto list = list_within(60s, [] {
    DeviceList one;
    one.devices.push_back({"freenect://1", {}, {}, {}, {}, {}, {}});
    return one;
  });
  ASSERT_EQ(list.devices.size(), 1U);
  EXPECT_EQ(list.devices[0].source, "freenect://1");
  EXPECT_EQ(list_within(60s, []() -> DeviceList { throw std::runtime_error("broken"); }).trouble, "broken");
}

// What the probe said.
struct Seen {
  struct Line {
    std::uint64_t sequence = 0;
    std::int64_t time = 0, age = 0;
    std::uint64_t bgr = 0, depth = 0, words = 0;
  };
  std::vector<Line> frames;
  std::vector<std::string> states;  ///< And why, where that was said.
  std::vector<std::string> warnings;
  std::string error;
  test::Outcome outcome;
};

class Fakenect : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(fs::exists(CHOREO_FAKENECT)) << "there is no fakenect in " CHOREO_FAKENECT " (package libfreenect-dev)";
  }

  Seen probe(const std::vector<std::string>& words, bool fake = true) {
    test::RunOptions options;
    options.limit = 60s;
    if (fake) options.environment = {{"LD_LIBRARY_PATH", CHOREO_FAKENECT}, {"FAKENECT_PATH", dump_}};
    Seen seen;
    seen.outcome = test::run_program(test::built("freenect_probe"), words, options);
    std::istringstream in(seen.outcome.out);
    for (std::string line; std::getline(in, line);) {
      std::istringstream word(line);
      std::string kind;
      std::getline(word, kind, ' ');
      std::string rest;
      if (kind == "frame") {
        auto& f = seen.frames.emplace_back();
        word >> f.sequence >> f.time >> f.age >> f.bgr >> f.depth >> f.words;
        continue;
      }
      std::getline(word, rest);
      while (rest.ends_with(' ')) rest.pop_back();
      if (kind == "event") seen.states.push_back(rest);
      if (kind == "warning") seen.warnings.push_back(rest);
      if (kind == "error") seen.error = rest;
    }
    return seen;
  }

  void write(int frames) { test::write_kinect_dump(dump_, frames); }

  // Which picture of the dump each frame shows.
  static std::vector<int> numbers(const Seen& seen, int frames) {
    std::map<std::uint64_t, int> known;
    for (int k = 0; k < frames; ++k) known[test::fingerprint(test::kinect_colour(k))] = k;
    std::vector<int> all;
    for (const auto& frame : seen.frames) all.push_back(known.contains(frame.bgr) ? known.at(frame.bgr) : -1);
    return all;
  }
  static void expect_increasing(const Seen& seen) {
    for (std::size_t k = 1; k < seen.frames.size(); ++k) {
      EXPECT_GT(seen.frames[k].sequence, seen.frames[k - 1].sequence);
      EXPECT_GT(seen.frames[k].time, seen.frames[k - 1].time);
    }
  }

  TempFolder folder_;
  std::string dump_ = folder_ / "dump";
};

TEST_F(Fakenect, FramesComeThroughPixelExactAtTheKinectsRate) {
  constexpr int kFrames = 30;
  write(kFrames);
  const auto seen = probe({"freenect://?depth=raw", std::to_string(kFrames), "3"});
  ASSERT_GE(seen.frames.size(), 15U) << seen.outcome.told();
  expect_increasing(seen);
  const auto numbers = Fakenect::numbers(seen, kFrames);
  std::vector<std::int64_t> ages;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const auto& frame = seen.frames[k];
    ages.push_back(frame.age);
    ASSERT_GE(numbers[k], 0) << "frame " << k << " is no picture of the dump";
    const auto words = test::kinect_words(numbers[k]);
    EXPECT_EQ(frame.words, test::fingerprint(cv::Mat(words)));
    EXPECT_EQ(frame.depth, test::fingerprint(kinect_depth(words)));
    EXPECT_EQ(frame.sequence, static_cast<std::uint64_t>(numbers[k] - numbers[0])) << "what was missed shows as a gap";
    EXPECT_GE(frame.age, 0);
  }
  std::sort(ages.begin(), ages.end());
  std::printf("fakenect 640x480 at 30: age of a pair when the pipeline gets it: median %.1f ms, at most %.1f ms\n",
              1e-6 * double(ages[ages.size() / 2]), 1e-6 * double(ages.back()));
  const double seconds = to_seconds(Nanoseconds{seen.frames.back().time - seen.frames.front().time});
  EXPECT_NEAR(seconds / (numbers.back() - numbers.front()), 1 / 30.0, 0.003);
}

TEST_F(Fakenect, DepthLiesOnTheColourUnlessToldOtherwise) {
  write(4);
  const auto seen = probe({"freenect:", "2", "3"});
  ASSERT_GE(seen.frames.size(), 1U) << seen.outcome.told();
  const auto number = numbers(seen, 4).front();
  ASSERT_GE(number, 0);
  EXPECT_EQ(seen.frames[0].depth, test::fingerprint(kinect_registered(kinect_depth(test::kinect_words(number)))));
  const auto off = probe({"freenect://?depth=off", "2", "3"});
  ASSERT_GE(off.frames.size(), 1U) << off.outcome.told();
  EXPECT_EQ(off.frames[0].depth, 0U);
}

TEST_F(Fakenect, LightAndTiltAreSetBesideTheFrames) {
  write(6);
  const auto seen = probe({"freenect://A00361A00965107A?led=blink-green&tilt=-7.5", "2", "3"});
  EXPECT_EQ(seen.frames.size(), 2U) << seen.outcome.told();
  EXPECT_THAT(seen.warnings, IsEmpty());
}

TEST_F(Fakenect, TheEndOfTheDumpIsALossAndStaysOne) {
  write(6);
  const auto seen = probe({"freenect://", "100", "2"});
  EXPECT_GE(seen.frames.size(), 3U) << seen.outcome.told();
  EXPECT_THAT(seen.states,
              ElementsAre("starting", "running", StartsWith("lost the Kinect v1 does not answer"), "stopped"))
      << "an attempt to take it up again that fails is no start";
  EXPECT_THAT(seen.warnings, ElementsAre(HasSubstr("was lost 1 time")));
  EXPECT_EQ(seen.outcome.status, 0);
}

TEST_F(Fakenect, ALostKinectIsTakenUpAgainAndTheFramesGoOn) {
  constexpr int kFrames = 24;
  write(kFrames);
  // An empty line is an error once: what comes behind it is read when the device is opened again.
  std::string index;
  std::istringstream in([&] {
    const auto bytes = test::read_bytes(dump_ + "/INDEX.txt");
    return std::string(bytes.begin(), bytes.end());
  }());
  int lines = 0;
  for (std::string line; std::getline(in, line);) index += line + (++lines == kFrames ? "\n\n" : "\n");
  test::write_bytes(dump_ + "/INDEX.txt", index);

  const auto seen = probe({"freenect://", "100", "3"});
  EXPECT_THAT(seen.states,
              ElementsAre("starting", "running", StartsWith("lost"), "running", StartsWith("lost"), "stopped"))
      << seen.outcome.told();
  expect_increasing(seen);
  const auto numbers = Fakenect::numbers(seen, kFrames);
  EXPECT_THAT(numbers, Each(::testing::Ge(0)));
  EXPECT_TRUE(std::is_sorted(numbers.begin(), numbers.end()));
  EXPECT_GE(std::count_if(numbers.begin(), numbers.end(), [](int n) { return n < kFrames / 2; }), 3);
  EXPECT_GE(std::count_if(numbers.begin(), numbers.end(), [](int n) { return n >= kFrames / 2; }), 3);
}

TEST_F(Fakenect, WhoeverReadsSlowlyGetsTheNewestAndSeesTheGap) {
  write(50);
  const auto seen = probe({"freenect://?depth=off", "4", "5", "400"});
  ASSERT_EQ(seen.frames.size(), 4U) << seen.outcome.told();
  for (std::size_t k = 1; k < 4; ++k) {
    EXPECT_GE(seen.frames[k].sequence - seen.frames[k - 1].sequence, 8U) << "400 ms are twelve frames";
    EXPECT_LT(seen.frames[k].age, 200'000'000) << "the oldest of eight that wait is 230 ms old";
  }
}

TEST_F(Fakenect, WhoeverWantsEveryFrameLosesNoneInAShortPause) {
  write(45);
  const auto seen = probe({"freenect://?depth=off", "7", "5", "60", "every"});
  ASSERT_EQ(seen.frames.size(), 7U) << seen.outcome.told();
  for (std::size_t k = 1; k < 7; ++k) EXPECT_EQ(seen.frames[k].sequence, seen.frames[k - 1].sequence + 1);
}

TEST_F(Fakenect, DepthThatStopsIsALossThoughColourGoesOn) {
  write(60);
  std::string index;
  const auto bytes = test::read_bytes(dump_ + "/INDEX.txt");
  std::istringstream in(std::string(bytes.begin(), bytes.end()));
  int depths = 0;
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with("d") || ++depths <= 15) index += line + "\n";
  }
  test::write_bytes(dump_ + "/INDEX.txt", index);
  const auto seen = probe({"freenect://", "100", "2"});
  EXPECT_THAT(seen.states, Contains(StartsWith("lost no frame for 0."))) << seen.outcome.told();
  EXPECT_LE(seen.frames.size(), 15U) << "colour alone is not what was asked for";
}

TEST_F(Fakenect, MayBeOpenedAndClosedAsOftenAsOneLikes) {
  write(60);
  const auto seen = probe({"freenect://", "cycle", "20"});
  EXPECT_EQ(seen.outcome.status, 0) << seen.outcome.told();
  EXPECT_THAT(seen.states, testing::SizeIs(40));
  EXPECT_THAT(seen.states, Not(Contains(StartsWith("failed"))));
}

TEST_F(Fakenect, ALibraryThatDoesNotComeBackIsGivenUp) {
  // fakenect waits for whoever writes into this pipe, for ever.
  fs::create_directories(dump_);
  ASSERT_EQ(::mkfifo((dump_ + "/INDEX.txt").c_str(), 0600), 0);
  const auto before = std::chrono::steady_clock::now();
  const auto seen = probe({"freenect://", "1", "3.8"});
  EXPECT_LT(std::chrono::steady_clock::now() - before, 10s);
  EXPECT_EQ(seen.outcome.status, 0) << seen.outcome.told();
  EXPECT_THAT(seen.states, Contains(StartsWith("lost no frame for 3")));
}

TEST_F(Fakenect, WhatItHasNotOrNobodyHasIsRefused) {
  write(2);
  const std::map<std::string, std::string> refusals = {
      {"freenect://?video=ir", "no infrared"},
      {"freenect://?video=ir&depth=registered", "depth=raw lies on video=ir"},
      {"freenect://?video=yuv", "rgb, ir"},
      {"freenect://?depth=near", "registered, raw, off"},
      {"freenect://?led=purple", "blink-red-yellow"},
      {"freenect://?tilt=31", "-30 to 30"},
      {"freenect://?tilt=up", "-30 to 30"},
      {"freenect://?til=3", "did you mean \"tilt\""}};
  for (const auto& [source, told] : refusals) {
    const auto seen = probe({source, "1", "3"});
    EXPECT_EQ(seen.outcome.status, 2) << seen.outcome.told();
    EXPECT_THAT(seen.error, HasSubstr(told)) << source;
  }
}

TEST_F(Fakenect, TheFakeIsListedAsOne) {
  write(1);
  EXPECT_THAT(probe({"list"}).outcome.out,
              AllOf(HasSubstr("device freenect:// \n"), HasSubstr("setting led unchanged,off,green"),
                    HasSubstr("setting tilt -30 30 degrees"), HasSubstr("setting video rgb,ir"),
                    HasSubstr("setting depth registered,raw,off")));
}

class RealLibrary : public Fakenect {
 protected:
  void SetUp() override {}
};

TEST_F(RealLibrary, WithoutAKinectItListsNoneAndRefusesClearly) {
  const auto list = probe({"list"}, false).outcome;
  EXPECT_EQ(list.status, 0) << list.told();
  if (list.out.find("device") != std::string::npos) GTEST_SKIP() << "a Kinect is plugged in here";
  for (const auto* source : {"freenect://", "freenect://A00361A00965107A", "freenect://?led=red&tilt=3"}) {
    const auto seen = probe({source, "1", "3"}, false);
    EXPECT_EQ(seen.outcome.status, 2) << seen.outcome.told();
    EXPECT_THAT(seen.error, AnyOf(HasSubstr("no Kinect v1"), HasSubstr("cannot use USB")));
    EXPECT_THAT(seen.error, Not(::testing::EndsWith("/ "))) << "a hint follows";
    EXPECT_THAT(seen.outcome.err, IsEmpty()) << "the library says nothing by itself";
  }
}

}  // namespace
}  // namespace choreo::devices::freenect

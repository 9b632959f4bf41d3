// SPDX-License-Identifier: Apache-2.0
// What choreoscope and its helper for OpenNI2 say to each other, and what is not taken from a helper gone mad.
#include "devices/openni2/protocol.hpp"

#include <random>

#include <gmock/gmock.h>

#include "devices/fourcc.hpp"

namespace choreo::devices::openni2 {
namespace {

const Mode kColourMode{Sensor::kColour, kRgb3, 640, 480, 30};
const Mode kDepthMode{Sensor::kDepth, kZ16, 320, 240, 30};

Picture picture() { return {kColourMode, 7, 640 * 480 * 3, 12, 34567}; }

Opened opened() { return {{"uri", "maker", "name", "serial", "", 1, 2}, {kColourMode, kDepthMode}, 99}; }

std::vector<Message> one_of_each() {
  Request request;
  request.action = Action::kDevice;
  request.video = Video::kInfrared;
  request.registered = false;
  request.width = 640;
  request.height = 480;
  request.location = "1d27/0601@1/5";
  return {request,
          Release{3},
          Hello{},
          opened().device,
          ModeFound{kDepthMode},
          opened(),
          picture(),
          Warning{"careful"},
          Trouble{TroubleKind::kRefused, "no", "yes"},
          End{}};
}

bool refused(const Message& message) {
  try {
    (void)decode(encode(message));
  } catch (const BadMessage&) {
    return true;
  }
  return false;
}

TEST(OpenNi2Protocol, EveryMessageArrivesAsItWasSent) {
  const auto all = one_of_each();
  ASSERT_EQ(all.size(), std::variant_size_v<Message>);
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_EQ(all[k].index(), k);
    EXPECT_EQ(decode(encode(all[k])), all[k]) << k;
  }
}

TEST(OpenNi2Protocol, TheLongestTextsFitAMessage) {
  const std::string endless(100000, 'x');
  const Opened full{{endless, endless, endless, endless, endless, 1, 2}, {kColourMode, kDepthMode}, 1};
  const auto bytes = encode(full);
  EXPECT_LE(bytes.size(), kMostMessage);
  const auto back = std::get<Opened>(decode(bytes));
  EXPECT_EQ(back.device.trouble, endless.substr(0, back.device.trouble.size()));
  EXPECT_GE(back.device.uri.size(), 256U) << "as long as OpenNI2's own";
}

TEST(OpenNi2Protocol, WhatIsCutOffOrGoesOnIsRefused) {
  for (const auto& message : one_of_each()) {
    const auto bytes = encode(message);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_THROW((void)decode(std::span(bytes).first(size)), BadMessage) << message.index() << " at " << size;
    }
    auto longer = bytes;
    longer.push_back(0);
    EXPECT_THROW((void)decode(longer), BadMessage) << message.index();
  }
  EXPECT_THROW((void)decode(std::vector<std::uint8_t>(kMostMessage + 1)), BadMessage);
}

TEST(OpenNi2Protocol, AnotherVersionOrLanguageIsRefused) {
  auto version = encode(Hello{});
  version[4] ^= 1U;
  EXPECT_THROW((void)decode(version), BadMessage);
  auto language = encode(Hello{});
  language[0] ^= 1U;
  EXPECT_THROW((void)decode(language), BadMessage);
  auto type = encode(Hello{});
  type[8] = 200;
  EXPECT_THROW((void)decode(type), BadMessage);
}

TEST(OpenNi2Protocol, APictureThatReachesBeyondItsSlotIsRefused) {
  EXPECT_FALSE(refused(picture()));
  auto slot = picture();
  slot.slot = kSlots;
  EXPECT_TRUE(refused(slot));
  auto fewer = picture();
  fewer.bytes -= 1;
  EXPECT_TRUE(refused(fewer));
  auto more = picture();
  more.bytes += 1;
  EXPECT_TRUE(refused(more));
  auto packet = picture();
  packet.mode.fourcc = kMjpg;
  packet.bytes = kSlotBytes;
  EXPECT_FALSE(refused(packet));
  packet.bytes = kSlotBytes + 1;
  EXPECT_TRUE(refused(packet));
  packet.bytes = 0;
  EXPECT_TRUE(refused(packet));
}

TEST(OpenNi2Protocol, ModesThatCannotBeAreRefused) {
  const auto bad = [](std::uint32_t fourcc, std::uint32_t width, std::uint32_t height,
                      Sensor sensor = Sensor::kColour) {
    return refused(ModeFound{{sensor, fourcc, width, height, 30}});
  };
  EXPECT_FALSE(bad(kRgb3, 2048, 2048));
  EXPECT_TRUE(bad(kRgb3, 4096, 4096)) << "more than a slot";
  EXPECT_TRUE(bad(kGrey, 0, 480));
  EXPECT_TRUE(bad(kGrey, 640, 0));
  EXPECT_TRUE(bad(kGrey, 4097, 1));
  EXPECT_TRUE(bad(kGrey, 0xFFFFFFFFU, 0xFFFFFFFFU));
  EXPECT_TRUE(bad(kYuyv, 641, 480)) << "two pixels share their colour";
  EXPECT_TRUE(bad(kNv12, 640, 480)) << "OpenNI2 has no such format";
  EXPECT_TRUE(bad(kZ16, 640, 480)) << "colour is no depth";
  EXPECT_TRUE(bad(kRgb3, 640, 480, Sensor::kDepth)) << "depth is no colour";
  EXPECT_TRUE(bad(kRgb3, 640, 480, static_cast<Sensor>(0)));
}

TEST(OpenNi2Protocol, WhatIsOpenedIsOneVideoAndOneDepthAtMost) {
  const auto bad = [](std::vector<Mode> streams) { return refused(Opened{{}, std::move(streams), 0}); };
  EXPECT_FALSE(bad({kColourMode}));
  EXPECT_FALSE(bad({kDepthMode}));
  EXPECT_FALSE(bad({kColourMode, kDepthMode}));
  EXPECT_TRUE(bad({}));
  EXPECT_TRUE(bad({kColourMode, kColourMode}));
  EXPECT_TRUE(bad({kDepthMode, kDepthMode}));
  EXPECT_TRUE(bad({kColourMode, kDepthMode, kDepthMode}));
}

TEST(OpenNi2Protocol, FlippedBytesAreRefusedOrMeanSomething) {
  std::mt19937 chance(7);
  const auto all = one_of_each();
  std::size_t taken = 0;
  for (int k = 0; k < 20000; ++k) {
    auto bytes = encode(all[chance() % all.size()]);
    for (auto flips = 1 + chance() % 3; flips > 0; --flips) {
      bytes[chance() % bytes.size()] ^= static_cast<std::uint8_t>(1U << (chance() % 8));
    }
    try {
      EXPECT_EQ(encode(decode(bytes)), bytes);
      ++taken;
    } catch (const BadMessage&) {
    }
  }
  EXPECT_GT(taken, 0U);
}

}  // namespace
}  // namespace choreo::devices::openni2

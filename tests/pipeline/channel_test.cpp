// SPDX-License-Identifier: Apache-2.0
// The queue between threads: its order, its bounds, and that no wait is for ever.
#include "pipeline/channel.hpp"

#include <memory>
#include <numeric>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace choreo::pipeline {
namespace {

using ::testing::ElementsAre;

template <typename T>
std::vector<T> taken(Channel<T>& channel) {
  std::vector<T> all;
  while (auto item = channel.pop()) all.push_back(std::move(*item));
  return all;
}

TEST(Channel, FirstInIsFirstOut) {
  Channel<int> channel(3);
  for (const int i : {7, 8, 9}) EXPECT_TRUE(channel.push(i));
  channel.close();
  EXPECT_THAT(taken(channel), ElementsAre(7, 8, 9));
}

TEST(Channel, WhatWaitsCanBeTakenAfterClosingAndNothingCanBeAdded) {
  Channel<int> channel(3);
  EXPECT_TRUE(channel.push(1));
  channel.close();
  channel.close();
  EXPECT_FALSE(channel.push(2));
  EXPECT_EQ(channel.pop(), 1);
  EXPECT_EQ(channel.pop(), std::nullopt);
  EXPECT_EQ(channel.stats().pushed, 1u);
}

TEST(Channel, TakesThingsThatCannotBeCopied) {
  Channel<std::unique_ptr<int>> channel(1);
  EXPECT_TRUE(channel.push(std::make_unique<int>(5)));
  EXPECT_EQ(**channel.pop(), 5);
}

// In the tests of waiting, the other thread may not be waiting yet when it is woken. Both ways the outcome is the same,
// which is what is tested: no wake-up is lost.

TEST(Channel, AWriterWaitingForRoomEndsWhenTheChannelCloses) {
  for (int round = 0; round < 200; ++round) {
    Channel<int> channel(1);
    ASSERT_TRUE(channel.push(1));
    bool pushed = true;
    {
      const std::jthread writer([&] { pushed = channel.push(2); });
      channel.close();
    }
    EXPECT_FALSE(pushed);
    EXPECT_THAT(taken(channel), ElementsAre(1));
  }
}

TEST(Channel, AWriterWaitingForRoomEndsWhenItsTokenIsStopped) {
  for (int round = 0; round < 200; ++round) {
    Channel<int> channel(1);
    ASSERT_TRUE(channel.push(1));
    bool pushed = true;
    std::jthread writer([&](const std::stop_token& stop) { pushed = channel.push(2, stop); });
    writer.request_stop();
    writer.join();
    EXPECT_FALSE(pushed);
    EXPECT_EQ(channel.stats().pushed, 1u);
  }
}

TEST(Channel, AReaderWaitingForAnItemEndsWhenTheChannelClosesOrItsTokenIsStopped) {
  for (int round = 0; round < 200; ++round) {
    Channel<int> channel(1);
    std::optional<int> item = 1;
    std::jthread reader([&](const std::stop_token& stop) { item = channel.pop(stop); });
    if (round % 2 == 0) {
      channel.close();
    } else {
      reader.request_stop();
    }
    reader.join();
    EXPECT_EQ(item, std::nullopt);
  }
}

TEST(Channel, AStoppedTokenDoesNotTakeAwayWhatNeedsNoWaiting) {
  std::stop_source stopped;
  stopped.request_stop();
  Channel<int> channel(2);
  EXPECT_TRUE(channel.push(1, stopped.get_token()));
  EXPECT_EQ(channel.pop(stopped.get_token()), 1);
}

TEST(Channel, BetweenThreadsNothingIsLostOrMixedUp) {
  for (const std::size_t capacity : {1u, 2u, 7u}) {
    Channel<int> channel(capacity);
    std::vector<int> got;
    {
      const std::jthread reader([&] { got = taken(channel); });
      for (int i = 0; i < 2000; ++i) ASSERT_TRUE(channel.push(i));
      channel.close();
    }
    std::vector<int> expected(2000);
    std::iota(expected.begin(), expected.end(), 0);
    EXPECT_EQ(got, expected);
    const auto stats = channel.stats();
    EXPECT_EQ(stats.pushed, 2000u);
    EXPECT_EQ(stats.dropped, 0u);
    EXPECT_LE(stats.longest, capacity);
    EXPECT_GE(stats.mean_length, 1.0);
    EXPECT_LE(stats.mean_length, double(capacity));
  }
}

TEST(Channel, SeveralWritersAndReadersShareTheItemsAmongThem) {
  Channel<int> channel(3);
  constexpr int kEach = 500;
  std::vector<long> sums(3, 0);
  {
    std::vector<std::jthread> readers;
    for (auto& sum : sums) {
      readers.emplace_back([&channel, &sum] {
        while (const auto item = channel.pop()) sum += *item;
      });
    }
    {
      std::vector<std::jthread> writers;
      for (int w = 0; w < 3; ++w) {
        writers.emplace_back([&channel] {
          for (int i = 1; i <= kEach; ++i) channel.push(i);
        });
      }
    }
    channel.close();
  }
  EXPECT_EQ(std::accumulate(sums.begin(), sums.end(), 0L), 3L * kEach * (kEach + 1) / 2);
}

TEST(Channel, DroppingTheOldestKeepsTheNewestAndCounts) {
  Channel<int> channel(2, Overflow::kDropOldest);
  for (int i = 1; i <= 5; ++i) EXPECT_TRUE(channel.push(i)) << "never waits";
  const auto stats = channel.stats();
  EXPECT_EQ(stats.pushed, 5u);
  EXPECT_EQ(stats.dropped, 3u);
  EXPECT_EQ(stats.longest, 2u);
  channel.close();
  EXPECT_FALSE(channel.push(6));
  EXPECT_THAT(taken(channel), ElementsAre(4, 5));
  EXPECT_EQ(channel.stats().dropped, 3u) << "what comes after closing is refused, not dropped";
}

TEST(Channel, ADroppedItemEndsOutsideOfTheLock) {
  // Its end looks at the channel: within the lock that would never come back.
  struct Asks {
    Channel<std::unique_ptr<Asks>>* channel;
    std::uint64_t* dropped;
    ~Asks() { *dropped = channel->stats().dropped; }
  };
  std::uint64_t dropped = 0;
  Channel<std::unique_ptr<Asks>> channel(1, Overflow::kDropOldest);
  for (int i = 0; i < 2; ++i) channel.push(std::unique_ptr<Asks>(new Asks{&channel, &dropped}));
  EXPECT_EQ(dropped, 1u);
  (void)channel.pop();
}

TEST(Channel, TheMeanLengthCountsEachItemAsItArrives) {
  Channel<int> channel(4);
  EXPECT_EQ(channel.stats().mean_length, 0.0);
  channel.push(1);  // 1 waits
  channel.push(2);  // 2 wait
  channel.push(3);  // 3 wait
  (void)channel.pop();
  channel.push(4);  // 3 again
  EXPECT_DOUBLE_EQ(channel.stats().mean_length, (1 + 2 + 3 + 3) / 4.0);
  EXPECT_EQ(channel.stats().longest, 3u);
}

}  // namespace
}  // namespace choreo::pipeline

// SPDX-License-Identifier: Apache-2.0
// Text for somebody who does not read it: it waits, in its order, and holds up nobody.
#include "cli/async_writer.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace choreo::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A pipe that takes as little as a pipe can.
class AsyncWriting : public ::testing::Test {
 protected:
  AsyncWriting() {
    EXPECT_EQ(::pipe2(ends_.data(), O_CLOEXEC), 0);
    EXPECT_GT(::fcntl(ends_[1], F_SETPIPE_SZ, 1), 0);
  }
  ~AsyncWriting() override {
    for (const int end : ends_) ::close(end);
  }

  void fill() {
    const std::string whole(std::size_t(::fcntl(ends_[1], F_GETPIPE_SZ)), '.');
    ASSERT_EQ(::write(ends_[1], whole.data(), whole.size()), ssize_t(whole.size()));
    filling_ = whole.size();
  }
  // Everything up to a line.
  std::vector<std::string> read_until(const std::string& last) {
    std::string text;
    for (std::array<char, 4096> some{}; !text.ends_with(last + "\n");) {
      const auto count = ::read(ends_[0], some.data(), some.size());
      if (count <= 0) break;
      text.append(some.data(), std::size_t(count));
    }
    std::vector<std::string> lines;
    std::istringstream in(text.substr(std::min(filling_, text.size())));
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  }

  std::array<int, 2> ends_{};
  std::size_t filling_ = 0;
};

TEST_F(AsyncWriting, WhatIsReadIsWrittenAtOnce) {
  AsyncWriter writer(ends_[1]);
  writer.put("one\n");
  writer.put("two\n");
  writer.flush_briefly();
  EXPECT_FALSE(writer.is_behind());
  EXPECT_THAT(read_until("two"), ElementsAre("one", "two"));
}

TEST_F(AsyncWriting, WhatIsNotReadWaitsAndComesInItsOrder) {
  fill();
  AsyncWriter writer(ends_[1]);
  for (int k = 0; k < 500; ++k) {
    writer.put(std::to_string(k) + "\n");
    writer.flush_briefly();  // In vain, which is found out once.
  }
  EXPECT_TRUE(writer.is_behind());
  const auto lines = read_until("499");
  ASSERT_EQ(lines.size(), 500u);
  for (std::size_t k = 0; k < lines.size(); ++k) EXPECT_EQ(lines[k], std::to_string(k));
  writer.drain({});
  EXPECT_FALSE(writer.is_behind());
}

TEST_F(AsyncWriting, WhatIsTooMuchIsLeftOutAndCounted) {
  fill();
  AsyncWriter writer(ends_[1]);
  constexpr std::size_t kLines = 1000;
  const std::string long_line(1000, '-');
  for (std::size_t k = 0; k < kLines; ++k) writer.put(std::to_string(k) + long_line + "\n");
  writer.put("a bar", false);
  writer.put("\nthe end\n");
  const auto lines = read_until("the end");
  // One where all of it was too much at once; two where the writer had woken up in between.
  const std::string begins = "choreoscope: warning: ";
  std::size_t left_out = 0;
  std::size_t notices = 0;
  for (const auto& line : lines) {
    if (!line.starts_with(begins)) continue;
    EXPECT_THAT(line, HasSubstr("left out here"));
    left_out += std::stoul(line.substr(begins.size()));
    ++notices;
  }
  EXPECT_GE(notices, 1u);
  EXPECT_EQ(lines.size() - notices - 2 + left_out, kLines) << "but for the bar and the end";
  EXPECT_EQ(lines.back(), "the end");
}

TEST_F(AsyncWriting, AStopEndsTheWaitForAReader) {
  fill();
  const auto begin = std::chrono::steady_clock::now();
  {
    AsyncWriter writer(ends_[1]);
    writer.put("unread\n");
    std::stop_source stop;
    stop.request_stop();
    writer.drain(stop.get_token());
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  (void)read_until("unread");  // Whoever still writes is let go before the pipe is.
}

TEST_F(AsyncWriting, WhereNobodyCanReadNothingWaits) {
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  AsyncWriter writer(ends_[1]);
  ::close(ends_[0]);
  ends_[0] = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  writer.put("unread\n");
  writer.drain({});
  EXPECT_FALSE(writer.is_behind());
  std::signal(SIGPIPE, before);
}

}  // namespace
}  // namespace choreo::cli

// SPDX-License-Identifier: Apache-2.0
// Pipes and network peers that are slow, silent or gone.
#include <atomic>
#include <chrono>
#include <filesystem>
#include <future>
#include <thread>

#include <gmock/gmock.h>

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "devices/video_fixture.hpp"
#include "support/eventually.hpp"

namespace choreo::devices {
namespace {

using test::all_frames;
using test::same_pixels;
using ::testing::HasSubstr;
using namespace std::chrono_literals;

// A TCP server on a free port of this machine that takes one caller, sends it `bytes`, then stays silent.
class SilentServer {
 public:
  explicit SilentServer(test::Bytes bytes) : bytes_(std::move(bytes)) {
    listener_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || ::listen(listener_, 1) != 0 ||
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      throw std::runtime_error("no local server");
    }
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] {
      caller_ = ::accept(listener_, nullptr, nullptr);
      std::size_t sent = 0;
      while (caller_ >= 0 && sent < bytes_.size()) {
        const auto count = ::send(caller_, bytes_.data() + sent, bytes_.size() - sent, MSG_NOSIGNAL);
        if (count <= 0) break;
        sent += static_cast<std::size_t>(count);
      }
    });
  }
  ~SilentServer() {
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    if (caller_ >= 0) ::close(caller_);
    ::close(listener_);
  }
  [[nodiscard]] std::string address() const { return "tcp://127.0.0.1:" + std::to_string(port_); }

 private:
  test::Bytes bytes_;
  int listener_ = -1;
  int caller_ = -1;
  int port_ = 0;
  std::thread thread_;
};

// Whether this process has that file open.
bool is_open(const std::string& path) {
  for (const auto& descriptor : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    if (std::filesystem::read_symlink(descriptor.path(), gone) == path) return true;
  }
  return false;
}

class VideoWaitingTest : public VideoFileTest {
 protected:
  static std::unique_ptr<Source> open_remote(const std::string& address) {
    const auto uri = parse_source_uri(address, [](const std::string&) { return false; });
    return open_remote_recording(uri, {}, 500ms);
  }
};

TEST_F(VideoWaitingTest, APipeIsReadButNotRepeatable) {
  const auto pictures = write_noise("a.mkv", 5);
  const auto bytes = test::read_bytes(folder_ / "a.mkv");
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  std::thread sender([&] {
    EXPECT_TRUE(test::eventually([&] { return is_open(folder_ / "pipe"); }))
        << "the reader is there first, as it may be";
    test::write_bytes(folder_ / "pipe", bytes);
  });
  const auto source = open("pipe");
  EXPECT_FALSE(source->info().repeatable);
  const auto frames = all_frames(*source);
  sender.join();
  ASSERT_EQ(frames.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_TRUE(same_pixels(frames[i]->bgr, pictures[i]));
}

TEST_F(VideoWaitingTest, AStopEndsTheWaitForAPipeThatNobodyWritesTo) {
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  std::stop_source stop;
  std::thread stopper([&] {
    EXPECT_TRUE(test::eventually([&] { return is_open(folder_ / "pipe"); }));
    stop.request_stop();
  });
  OpenOptions options;
  options.stop = stop.get_token();
  const auto begin = std::chrono::steady_clock::now();
  const auto error = test::error_of([&] { (void)registry_.open(folder_ / "pipe", options); });
  stopper.join();
  ASSERT_TRUE(error);
  EXPECT_THAT(error->what(), HasSubstr("interrupted"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 2s);
}

TEST_F(VideoWaitingTest, AStopEndsTheWaitForTheNextFrame) {
  write_noise("a.mkv", 40, {64, 64});
  const auto bytes = test::read_bytes(folder_ / "a.mkv");
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  std::promise<void> done;
  std::stop_source stop;
  std::atomic<int> count{0};
  std::thread sender([&] {
    const int pipe = ::open((folder_ / "pipe").c_str(), O_WRONLY);
    const auto half = bytes.size() * 3 / 4;
    EXPECT_EQ(::write(pipe, bytes.data(), half), static_cast<ssize_t>(half));
    // Three quarters of forty frames came; the stop finds the reader waiting for more.
    EXPECT_TRUE(test::eventually([&] {
      int waiting = 0;
      return ::ioctl(pipe, FIONREAD, &waiting) == 0 && waiting == 0 && count >= 20;
    }));
    stop.request_stop();
    done.get_future().wait();  // It is silent, but stays.
    ::close(pipe);
  });
  const auto source = open("pipe");
  while (source->read(stop.get_token())) ++count;
  EXPECT_TRUE(stop.stop_requested()) << "not ended before";
  EXPECT_GE(count, 20);
  EXPECT_LT(count, 40);
  EXPECT_TRUE(source->warnings().empty()) << "an interrupted recording is not a truncated one";
  done.set_value();
  sender.join();
}

TEST_F(VideoWaitingTest, APeerThatNeverSendsIsAFailureAfterAWhile) {
  const SilentServer server({});
  const auto begin = std::chrono::steady_clock::now();
  const auto error = test::error_of([&] { (void)open_remote(server.address()); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kFailure);
  EXPECT_THAT(error->what(), HasSubstr("nothing came for 0.5 s"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 3s);
}

TEST_F(VideoWaitingTest, APeerThatFallsSilentIsAFailureAfterItsFrames) {
  test::VideoRecipe recipe;
  recipe.encoder = "mpeg2video";
  recipe.pixel_format = AV_PIX_FMT_YUV420P;
  recipe.format = "mpegts";
  recipe.width = 320;
  recipe.height = 240;
  recipe.time_base = {1, 25};
  recipe.times.clear();
  for (int i = 0; i < 400; ++i) recipe.times.push_back(i);
  recipe.paint = [](AVFrame& frame, int index) {
    const auto count = static_cast<unsigned>(frame.linesize[0] * 240);
    for (unsigned i = 0; i < count; ++i) {
      frame.data[0][i] = static_cast<std::uint8_t>(i * i * static_cast<unsigned>(index + 1) >> 7);
    }
  };
  make_video(folder_ / "a.ts", recipe);
  const SilentServer server(test::read_bytes(folder_ / "a.ts"));
  const auto source = open_remote(server.address());
  EXPECT_FALSE(source->info().repeatable);
  int count = 0;
  const auto error = test::error_of([&] {
    while (source->read({})) ++count;
  });
  EXPECT_GT(count, 0);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kFailure);
  EXPECT_THAT(error->what(), HasSubstr("fell silent"));
}

TEST_F(VideoWaitingTest, APeerThatIsNotThereIsTheUsersMistake) {
  std::string address;
  {
    const SilentServer gone({});
    address = gone.address();
  }
  const auto error = test::error_of([&] { (void)open_remote(address); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_THAT(error->what(), HasSubstr("Connection refused"));
}

}  // namespace
}  // namespace choreo::devices

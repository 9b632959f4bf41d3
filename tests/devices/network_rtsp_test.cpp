// SPDX-License-Identifier: Apache-2.0
// RTSP, with a sender that calls: FFmpeg's own.
#include <atomic>
#include <cstdio>
#include <memory>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/dict.h>
}

#include "devices/media/libav.hpp"
#include "devices/media/raw_converter.hpp"
#include "devices/network_fixture.hpp"

namespace choreo::devices {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Calls an RTSP address and sends numbered pictures, 40 ms a step of the time stamp and one every `pace`, until it is
/// destroyed. Calls again as long as nobody answers.
class RtspSender {
 public:
  RtspSender(std::string address, const char* encoder, AVPixelFormat pixels, const char* transport = "tcp",
             std::chrono::milliseconds pace = 40ms)
      : address_(std::move(address)),
        encoder_name_(encoder),
        pixels_(pixels),
        transport_(transport),
        pace_(pace),
        thread_([this] { run(); }) {}
  ~RtspSender() {
    over_ = true;
    thread_.join();
  }
  RtspSender(const RtspSender&) = delete;
  RtspSender& operator=(const RtspSender&) = delete;

  void pause() { paused_ = true; }
  [[nodiscard]] Nanoseconds sent_at(int number) const {
    const std::scoped_lock lock(mutex_);
    return sent_.at(std::size_t(number));
  }

 private:
  void run() {
    while (!over_) {
      if (!send()) std::this_thread::sleep_for(50ms);
    }
  }

  bool send() {
    AVFormatContext* made = nullptr;
    if (avformat_alloc_output_context2(&made, nullptr, "rtsp", address_.c_str()) < 0) return false;
    const std::unique_ptr<AVFormatContext, void (*)(AVFormatContext*)> container(made, avformat_free_context);
    made->interrupt_callback = {[](void* self) { return static_cast<RtspSender*>(self)->over_ ? 1 : 0; }, this};
    const auto* codec = avcodec_find_encoder_by_name(encoder_name_);
    const std::unique_ptr<AVCodecContext, void (*)(AVCodecContext*)> encoder(
        avcodec_alloc_context3(codec), [](AVCodecContext* c) { avcodec_free_context(&c); });
    encoder->width = 160;
    encoder->height = 96;
    encoder->pix_fmt = pixels_;
    encoder->color_range = pixels_ == AV_PIX_FMT_YUVJ420P ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
    encoder->time_base = {1, 25};
    encoder->gop_size = 12;
    encoder->max_b_frames = 0;
    encoder->bit_rate = 2'000'000;
    encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    AVDictionary* settings = nullptr;
    av_dict_set(&settings, "huffman", "default", 0);  // RTP knows no other tables of JPEG.
    av_dict_set(&settings, "tune", "zerolatency", 0);
    const int opened = avcodec_open2(encoder.get(), codec, &settings);
    av_dict_free(&settings);
    if (opened < 0) return false;
    auto* stream = avformat_new_stream(made, nullptr);
    avcodec_parameters_from_context(stream->codecpar, encoder.get());
    stream->time_base = encoder->time_base;
    AVDictionary* options = nullptr;
    av_dict_set(&options, "rtsp_transport", transport_, 0);
    const int begun = avformat_write_header(made, &options);
    av_dict_free(&options);
    if (begun < 0) return false;
    bool good = true;
    for (int k = 0; good && !over_; ++k) {
      good = send_picture(*encoder, *made, k);
      std::this_thread::sleep_for(pace_);
      while (paused_ && !over_) std::this_thread::sleep_for(10ms);
    }
    if (good) av_write_trailer(made);
    return good;
  }

  bool send_picture(AVCodecContext& encoder, AVFormatContext& container, int number) {
    const std::unique_ptr<AVFrame, void (*)(AVFrame*)> frame(av_frame_alloc(), [](AVFrame* f) { av_frame_free(&f); });
    frame->width = encoder.width;
    frame->height = encoder.height;
    frame->format = pixels_;
    frame->pts = number;
    av_frame_get_buffer(frame.get(), 0);
    const auto picture = test::numbered_picture(number, {encoder.width, encoder.height});
    for (int y = 0; y < frame->height; ++y) {
      for (int x = 0; x < frame->width; ++x) {
        frame->data[0][y * frame->linesize[0] + x] = picture.at<cv::Vec3b>(y, x)[1];
      }
    }
    for (const int plane : {1, 2}) std::fill_n(frame->data[plane], frame->linesize[plane] * frame->height / 2, 128);
    {
      const std::scoped_lock lock(mutex_);
      sent_.resize(std::size_t(number) + 1);
      sent_.back() = clock_.now();
    }
    if (avcodec_send_frame(&encoder, frame.get()) < 0) return false;
    const std::unique_ptr<AVPacket, void (*)(AVPacket*)> packet(av_packet_alloc(),
                                                                [](AVPacket* p) { av_packet_free(&p); });
    while (avcodec_receive_packet(&encoder, packet.get()) == 0) {
      av_packet_rescale_ts(packet.get(), encoder.time_base, container.streams[0]->time_base);
      if (av_write_frame(&container, packet.get()) < 0) return false;
      av_packet_unref(packet.get());
    }
    return true;
  }

  const std::string address_;
  const char* encoder_name_;
  AVPixelFormat pixels_;
  const char* transport_;
  const std::chrono::milliseconds pace_;
  pipeline::SteadyClock clock_;
  mutable std::mutex mutex_;
  std::vector<Nanoseconds> sent_;
  std::atomic<bool> over_{false};
  std::atomic<bool> paused_{false};
  std::thread thread_;
};

class NetworkRtsp : public NetworkTest {
 protected:
  NetworkRtsp() { silence_libav(); }
  std::string address_ = "rtsp://127.0.0.1:" + std::to_string(test::deserted_port()) + "/live";
};

class NetworkRtspCodec : public NetworkRtsp, public ::testing::WithParamInterface<const char*> {};

INSTANTIATE_TEST_SUITE_P(Codecs, NetworkRtspCodec, ::testing::Values("mpeg4", "libx264"),
                         [](const auto& codec) { return std::string(codec.param); });

// The sender's clock goes at half the pace of ours: arrivals are 80 ms apart, stamps 40 ms. Where the stamps are heeded
// the quickest of the first pictures settles where the clocks meet, and a later one had to arrive 40 ms a picture
// quicker to change that: no busy machine does it.
TEST_P(NetworkRtspCodec, GivesPicturesInOrderAtTheSendersTimes) {
  ASSERT_NE(avcodec_find_encoder_by_name(GetParam()), nullptr) << "this FFmpeg has no " << GetParam();
  const RtspSender sender(address_, GetParam(), AV_PIX_FMT_YUV420P, "tcp", 80ms);
  const auto source = open(address_ + "?listen=1");
  EXPECT_EQ(source->info().size, cv::Size(160, 96));
  FramePtr last;
  Nanoseconds youngest = Nanoseconds::max();
  for (int k = 0; k < 40; ++k) {
    const auto frame = read(*source);
    ASSERT_TRUE(frame);
    EXPECT_FALSE(frame->raw_colour);
    if (k > 20) {
      const int step = test::number_of(frame->bgr) - test::number_of(last->bgr);
      EXPECT_GE(step, 1);
      EXPECT_NEAR(to_seconds(frame->device_time - last->device_time), 0.040 * step, 0.010) << k;
      youngest = std::min(youngest, clock_.now() - sender.sent_at(test::number_of(frame->bgr)));
    }
    last = frame;
  }
  EXPECT_LT(youngest, 500ms) << "in a queue all would be old";
  std::printf("RTSP over TCP, %s 160x96: age since it was drawn: at least %.1f ms\n", GetParam(),
              1e3 * to_seconds(youngest));
  EXPECT_THAT(states(), ElementsAre("starting", "running"));
}

TEST_F(NetworkRtsp, MotionJpegIsKeptAsItCame) {
  const RtspSender sender(address_, "mjpeg", AV_PIX_FMT_YUVJ420P);
  const auto source = open(address_ + "?listen=1", true);
  int last = -1;
  for (int k = 0; k < 10; ++k) {
    const auto frame = read(*source);
    ASSERT_TRUE(frame);
    ASSERT_TRUE(frame->raw_colour);
    EXPECT_GT(test::number_of(frame->bgr), last);
    last = test::number_of(frame->bgr);
    EXPECT_TRUE(test::same_pixels(frame->bgr, RawConverter().to_bgr(*frame->raw_colour)));
  }
}

TEST_F(NetworkRtsp, PicturesComeOverUdpWhereThatIsAskedFor) {
  const RtspSender sender(address_, "mpeg4", AV_PIX_FMT_YUV420P, "udp");
  const auto source = open(address_ + "?listen=1&transport=udp");
  int last = -1;
  for (int k = 0; k < 10; ++k) {
    const auto frame = read(*source);
    ASSERT_TRUE(frame);
    EXPECT_GT(test::number_of(frame->bgr), last);
    last = test::number_of(frame->bgr);
  }
}

TEST_F(NetworkRtsp, ASenderThatHangsUpIsLostAndMayCallAgain) {
  auto sender = std::make_unique<RtspSender>(address_, "mpeg4", AV_PIX_FMT_YUV420P);
  const auto source = open(address_ + "?listen=1");
  auto before = read(*source);
  ASSERT_TRUE(before);
  const auto cut = clock_.now();
  sender.reset();
  ASSERT_TRUE(read_until(*source, DeviceState::kLost));
  EXPECT_LT(events_.back().at - cut, 1200ms);
  sender = std::make_unique<RtspSender>(address_, "mpeg4", AV_PIX_FMT_YUV420P);
  ASSERT_TRUE(read_until(*source, DeviceState::kRunning));
  const auto after = read(*source);
  ASSERT_TRUE(after);
  EXPECT_GT(after->sequence, before->sequence);
  EXPECT_GT(after->device_time, before->device_time);
}

TEST_F(NetworkRtsp, ASenderThatFallsSilentIsLostWithinASecond) {
  RtspSender sender(address_, "mpeg4", AV_PIX_FMT_YUV420P);
  const auto source = open(address_ + "?listen=1");
  auto last = read(*source);
  ASSERT_TRUE(last);
  sender.pause();
  while (auto frame = read(*source, 200ms)) last = frame;
  ASSERT_TRUE(read_until(*source, DeviceState::kLost));
  EXPECT_LT(events_.back().at - last->device_time, 1100ms);
  EXPECT_THAT(events_.back().why, HasSubstr("no frame for"));
}

TEST_F(NetworkRtsp, WhereNobodyCallsPatienceEnds) {
  EXPECT_THAT(refusal(address_ + "?listen=1&patience=0.5").what(), HasSubstr("no picture came within 0.5 s"));
}

}  // namespace
}  // namespace choreo::devices

// SPDX-License-Identifier: Apache-2.0
#include "outputs/video_writer.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <new>
#include <optional>
#include <system_error>
#include <thread>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/log.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include "core/error.hpp"

namespace choreo::outputs {
namespace {

struct Deleter {
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
  void operator()(AVFormatContext* p) const {
    avio_closep(&p->pb);
    avformat_free_context(p);
  }
  void operator()(AVFrame* p) const { av_frame_free(&p); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
  void operator()(SwsContext* p) const { sws_freeContext(p); }
};

template <typename T>
using Owned = std::unique_ptr<T, Deleter>;

const AVCodec* encoder_of(VideoCodec codec) {
  switch (codec) {
    case VideoCodec::kLossless:
      return avcodec_find_encoder(AV_CODEC_ID_FFV1);
    case VideoCodec::kH264:
      return avcodec_find_encoder_by_name("libx264");
    case VideoCodec::kMpeg4:
      return avcodec_find_encoder(AV_CODEC_ID_MPEG4);
  }
  return nullptr;
}

const char* name_of(VideoCodec codec) {
  switch (codec) {
    case VideoCodec::kLossless:
      return "FFV1";
    case VideoCodec::kH264:
      return "H.264";
    case VideoCodec::kMpeg4:
      return "MPEG-4";
  }
  return "";
}

std::string text_of(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

std::string ending_of(const std::string& path) {
  auto ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

VideoContainer container_of(const std::string& path) {
  const auto ending = ending_of(path);
  if (ending == ".mkv") return VideoContainer::kMatroska;
  if (ending == ".mp4") return VideoContainer::kMp4;
  throw usage_error(fmt::format("\"{}\" does not end in .mkv or .mp4", path), {},
                    "end the name in .mkv for a lossless video, or in .mp4 for a small one");
}

}  // namespace

bool can_encode(VideoCodec codec) { return encoder_of(codec) != nullptr; }

VideoCodec video_codec_for(const std::string& path) {
  const auto codec = container_of(path) == VideoContainer::kMatroska ? VideoCodec::kLossless
                     : can_encode(VideoCodec::kH264)                 ? VideoCodec::kH264
                                                                     : VideoCodec::kMpeg4;
  if (!can_encode(codec)) throw usage_error(fmt::format("this FFmpeg cannot write {} video", name_of(codec)));
  return codec;
}

class VideoWriter::File {
 public:
  File(std::string path, cv::Size size, const VideoOptions& options)
      : path_(std::move(path)), part_(path_ + ".part"), size_(size), options_(options) {
    if (options_.container == VideoContainer::kByEnding) options_.container = container_of(path_);
    av_log_set_level(AV_LOG_QUIET);
    refuse_what_cannot_be();
    open_encoder();
    open_container();
  }

  ~File() {
    if (!part_exists_) return;
    container_.reset();
    std::remove(part_.c_str());
  }

  File(const File&) = delete;
  File& operator=(const File&) = delete;

  void write(const cv::Mat& picture, Nanoseconds time) {
    const bool fits = picture.type() == CV_8UC1 || (picture.type() == CV_8UC3 && !options_.grey);
    if (!fits || picture.size() != size_) {
      throw failure(fmt::format("\"{}\": a picture of {}x{} with {} channels does not fit into a {} video of {}x{}",
                                path_, picture.cols, picture.rows, picture.channels(),
                                options_.grey ? "grey" : "colour", size_.width, size_.height));
    }
    if (time.count() < 0 || (last_time_ && time <= *last_time_)) {
      throw failure(fmt::format("\"{}\": a picture's time of {} s does not come after {} s", path_, to_seconds(time),
                                last_time_ ? to_seconds(*last_time_) : 0.0));
    }
    last_time_ = time;
    if (const int code = av_frame_make_writable(frame_.get()); code < 0) give_up(code);
    fill_frame(picture);
    const auto units = av_rescale_q(time.count(), AVRational{1, 1'000'000'000}, encoder_->time_base);
    frame_->pts = last_units_ ? std::max(units, *last_units_ + 1) : units;
    if (options_.rate.numerator <= 0 && last_units_) frame_units_ = frame_->pts - *last_units_;
    last_units_ = frame_->pts;
    encode(frame_.get());
  }

  void close() {
    encode(nullptr);
    if (const int code = av_write_trailer(container_.get()); code < 0) give_up(code);
    avio_flush(container_->pb);
    const int written = container_->pb->error;
    const int closed = avio_closep(&container_->pb);
    if (written < 0 || closed < 0) give_up(std::min(written, closed));
    if (std::rename(part_.c_str(), path_.c_str()) != 0) give_up(AVERROR(errno));
    part_exists_ = false;
  }

 private:
  [[nodiscard]] bool is_matroska() const { return options_.container == VideoContainer::kMatroska; }

  [[noreturn]] void give_up(int code) const {
    throw failure(fmt::format("\"{}\" cannot be written: {}", path_, text_of(code)), {},
                  code == AVERROR(ENOSPC) ? "make room on the disk, or write elsewhere" : "");
  }

  void refuse_what_cannot_be() const {
    if (!is_matroska() && options_.codec == VideoCodec::kLossless) {
      throw usage_error(fmt::format("\"{}\": lossless video does not go into .mp4", path_), {}, "end the name in .mkv");
    }
    if (!can_encode(options_.codec)) {
      throw usage_error(fmt::format("this FFmpeg cannot write {} video", name_of(options_.codec)), {},
                        "end the name in .mkv for a lossless video");
    }
    if (size_.width < 1 || size_.height < 1 || size_.width > 16384 || size_.height > 16384) {
      throw usage_error(fmt::format("a video of {}x{} pixels cannot be written", size_.width, size_.height), {},
                        "sides of 1 to 16384 pixels are possible");
    }
    std::error_code problem;
    if (std::filesystem::is_directory(path_, problem)) {
      throw usage_error(fmt::format("\"{}\" is a folder, not a file to write to", path_));
    }
  }

  void open_encoder() {
    const auto* codec = encoder_of(options_.codec);
    encoder_.reset(avcodec_alloc_context3(codec));
    frame_.reset(av_frame_alloc());
    packet_.reset(av_packet_alloc());
    if (!encoder_ || !frame_ || !packet_) throw std::bad_alloc();
    const bool lossless = options_.codec == VideoCodec::kLossless;
    auto& e = *encoder_;
    e.width = lossless ? size_.width : (size_.width + 1) / 2 * 2;
    e.height = lossless ? size_.height : (size_.height + 1) / 2 * 2;
    e.time_base = is_matroska() ? AVRational{1, 1000} : AVRational{1, 60000};
    e.sample_aspect_ratio = {1, 1};
    if (options_.rate.numerator > 0) e.framerate = {options_.rate.numerator, options_.rate.denominator};
    e.flags |= AV_CODEC_FLAG_BITEXACT | AV_CODEC_FLAG_GLOBAL_HEADER;
    if (lossless) {
      prepare_lossless();
    } else {
      prepare_lossy();
    }
    const auto rate = options_.rate.numerator > 0 ? e.framerate : AVRational{25, 1};
    frame_units_ = std::max<std::int64_t>(1, av_rescale_q(1, av_inv_q(rate), e.time_base));
    if (const int code = avcodec_open2(&e, codec, nullptr); code < 0) give_up(code);

    frame_->format = e.pix_fmt;
    frame_->width = e.width;
    frame_->height = e.height;
    frame_->color_range = e.color_range;
    frame_->colorspace = e.colorspace;
    if (const int code = av_frame_get_buffer(frame_.get(), 0); code < 0) give_up(code);
  }

  void prepare_lossless() {
    auto& e = *encoder_;
    e.pix_fmt = options_.grey ? AV_PIX_FMT_GRAY8 : AV_PIX_FMT_0RGB32;
    e.color_range = AVCOL_RANGE_JPEG;
    e.gop_size = 1;  // Every picture stands alone, so damage does not spread.
    const int least = std::min(size_.width, size_.height);
    const bool large = size_.width > 352 || size_.height > 288;
    // FFmpeg's slices lose all pixels where they are one pixel wide or high; version 1 has none, nor checksums.
    e.level = least < 4 ? 1 : 3;
    // The bytes depend on the number of slices, which therefore does not follow the number of cores. One alone is
    // possible only up to 352x288 (ffv1enc.c).
    e.slices = least < 4 ? 0 : (!large && least < 64 ? 1 : 4);
    e.thread_type = FF_THREAD_SLICE;
    e.thread_count = std::clamp<int>(static_cast<int>(std::thread::hardware_concurrency()), 1, std::max(e.slices, 1));
    if (e.level == 3) av_opt_set_int(e.priv_data, "slicecrc", 1, 0);
  }

  void prepare_lossy() {
    auto& e = *encoder_;
    const bool large = e.height >= 720;
    e.pix_fmt = AV_PIX_FMT_YUV420P;
    e.color_range = AVCOL_RANGE_MPEG;
    e.colorspace = large ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M;
    e.color_primaries = large ? AVCOL_PRI_BT709 : AVCOL_PRI_SMPTE170M;
    e.color_trc = large ? AVCOL_TRC_BT709 : AVCOL_TRC_SMPTE170M;
    if (options_.codec == VideoCodec::kH264) {
      e.thread_count = 4;  // x264's bytes depend on it: fixed, whatever the number of cores.
      av_opt_set(e.priv_data, "preset", "medium", 0);
      av_opt_set(e.priv_data, "crf", "18", 0);
    } else {
      e.thread_count = 1;
      e.flags |= AV_CODEC_FLAG_QSCALE;
      e.global_quality = 3 * FF_QP2LAMBDA;
    }
    constexpr int kFlags = SWS_BICUBIC | SWS_ACCURATE_RND | SWS_BITEXACT | SWS_FULL_CHR_H_INP;
    colours_.reset(sws_getContext(e.width, e.height, AV_PIX_FMT_BGR24, e.width, e.height, e.pix_fmt, kFlags, nullptr,
                                  nullptr, nullptr));
    if (!colours_) throw std::bad_alloc();
    const auto* matrix = sws_getCoefficients(large ? SWS_CS_ITU709 : SWS_CS_ITU601);
    (void)sws_setColorspaceDetails(colours_.get(), matrix, 1, matrix, 0, 0, 1 << 16, 1 << 16);
  }

  void open_container() {
    AVFormatContext* container = nullptr;
    const char* format = is_matroska() ? "matroska" : "mp4";
    if (const int code = avformat_alloc_output_context2(&container, nullptr, format, nullptr); code < 0) give_up(code);
    container_.reset(container);
    // Without it there are random identities, dates and version numbers in the file.
    container->flags |= AVFMT_FLAG_BITEXACT;
    stream_ = avformat_new_stream(container, nullptr);
    if (stream_ == nullptr) throw std::bad_alloc();
    if (const int code = avcodec_parameters_from_context(stream_->codecpar, encoder_.get()); code < 0) give_up(code);
    stream_->time_base = encoder_->time_base;
    stream_->sample_aspect_ratio = encoder_->sample_aspect_ratio;
    if (options_.rate.numerator > 0) stream_->avg_frame_rate = encoder_->framerate;

    if (const int code = avio_open(&container->pb, ("file:" + part_).c_str(), AVIO_FLAG_WRITE); code < 0) {
      throw usage_error(fmt::format("\"{}\" cannot be written: {}", path_, text_of(code)), {},
                        "name a file in a folder that exists and may be written to");
    }
    part_exists_ = true;
    try {
      if (const int code = avformat_write_header(container, nullptr); code < 0) give_up(code);
    } catch (...) {
      std::remove(part_.c_str());
      throw;
    }
  }

  void fill_frame(const cv::Mat& picture) {
    const auto step = static_cast<std::size_t>(frame_->linesize[0]);
    if (options_.codec == VideoCodec::kLossless) {
      cv::Mat target(frame_->height, frame_->width, options_.grey ? CV_8UC1 : CV_8UC4, frame_->data[0], step);
      if (options_.grey) {
        picture.copyTo(target);
      } else {
        cv::cvtColor(picture, target, picture.channels() == 1 ? cv::COLOR_GRAY2BGRA : cv::COLOR_BGR2BGRA);
      }
      return;
    }
    cv::Mat colour = picture;
    if (picture.channels() == 1) cv::cvtColor(picture, colour, cv::COLOR_GRAY2BGR);
    cv::Mat even = colour;
    if (frame_->width != size_.width || frame_->height != size_.height) {
      cv::copyMakeBorder(colour, even, 0, frame_->height - size_.height, 0, frame_->width - size_.width,
                         cv::BORDER_REPLICATE);
    }
    const std::uint8_t* planes[4] = {even.data, nullptr, nullptr, nullptr};
    const int strides[4] = {static_cast<int>(even.step[0]), 0, 0, 0};
    sws_scale(colours_.get(), planes, strides, 0, even.rows, frame_->data, frame_->linesize);
  }

  void encode(const AVFrame* frame) {
    int code = avcodec_send_frame(encoder_.get(), frame);
    if (code < 0) give_up(code);
    while ((code = avcodec_receive_packet(encoder_.get(), packet_.get())) >= 0) {
      // A last picture of no length would lie outside of an MP4's edit list, and players would leave it out.
      if (packet_->duration == 0) packet_->duration = frame_units_;
      av_packet_rescale_ts(packet_.get(), encoder_->time_base, stream_->time_base);
      packet_->stream_index = stream_->index;
      if (code = av_interleaved_write_frame(container_.get(), packet_.get()); code < 0) give_up(code);
      if (container_->pb->error < 0) give_up(container_->pb->error);
    }
    if (code != AVERROR(EAGAIN) && code != AVERROR_EOF) give_up(code);
  }

  std::string path_;
  std::string part_;
  cv::Size size_;
  VideoOptions options_;
  Owned<AVCodecContext> encoder_;
  Owned<AVFrame> frame_;
  Owned<AVPacket> packet_;
  Owned<SwsContext> colours_;
  Owned<AVFormatContext> container_;
  AVStream* stream_ = nullptr;
  bool part_exists_ = false;
  std::optional<Nanoseconds> last_time_;
  std::optional<std::int64_t> last_units_;
  std::int64_t frame_units_ = 1;  // How long a picture is shown: as declared, else as long as the one before.
};

VideoWriter::VideoWriter(std::string path, cv::Size size, const VideoOptions& options)
    : file_(std::make_unique<File>(std::move(path), size, options)) {}
VideoWriter::~VideoWriter() = default;
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;

void VideoWriter::write(const cv::Mat& picture, Nanoseconds time) {
  if (!file_) throw failure("the video is closed already");
  file_->write(picture, time);
}

void VideoWriter::close() {
  if (!file_) return;
  const auto file = std::move(file_);
  file->close();
}

}  // namespace choreo::outputs

// SPDX-License-Identifier: Apache-2.0
#include "outputs/take_container.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>
#include <system_error>

#include <fmt/format.h>

extern "C" {
#include <libavutil/dict.h>
#include <libavutil/intreadwrite.h>
}

#include "core/error.hpp"

namespace choreo::outputs {
namespace {

using devices::take::Part;

constexpr AVRational kMilliseconds{1, 1000};  // Matroska's clock, whatever one asks for.
constexpr AVRational kNanoseconds{1, 1'000'000'000};

void add(AVDictionary*& to, const devices::take::Tags& tags) {
  for (const auto& [name, text] : tags) av_dict_set(&to, name.c_str(), text.c_str(), 0);
}

}  // namespace

void TakeContainer::Closer::operator()(AVFormatContext* context) const {
  avio_closep(&context->pb);
  avformat_free_context(context);
}

TakeContainer::TakeContainer(std::string path) : path_(std::move(path)), file_(std::fopen(path_.c_str(), "wxe")) {
  if (!file_ && errno == EEXIST) {
    throw usage_error(fmt::format("\"{}\" is there already", path_), {},
                      "it is being recorded, or was cut off: rename it, or choose another name");
  }
  if (!file_) {
    throw usage_error(fmt::format("\"{}\" cannot be written: {}", path_, std::generic_category().message(errno)), {},
                      "name a file in a folder that exists and may be written to");
  }
  devices::silence_libav();
  AVFormatContext* container = nullptr;
  if (const int code = avformat_alloc_output_context2(&container, nullptr, "matroska", nullptr); code < 0)
    give_up(code);
  container_.reset(container);
  container->flags |= AVFMT_FLAG_BITEXACT;  // Without it there are random numbers and dates in the file.
  if (const int code = avio_open(&container->pb, ("file:" + path_).c_str(), AVIO_FLAG_WRITE); code < 0) {
    std::remove(path_.c_str());
    throw usage_error(fmt::format("\"{}\" cannot be written: {}", path_, devices::libav_error_text(code)), {},
                      "name a file in a folder that exists and may be written to");
  }
}

TakeContainer::~TakeContainer() = default;

void TakeContainer::give_up(int code) const {
  throw failure(fmt::format("\"{}\" cannot be written: {}", path_, devices::libav_error_text(code)), {},
                code == AVERROR(ENOSPC) ? "make room on the disk, or record elsewhere" : "");
}

void TakeContainer::begin(const devices::take::FileFacts& facts, std::span<const std::unique_ptr<TakeEncoder>> encoders,
                          bool marks) {
  auto& container = *container_;
  for (const auto& encoder : encoders) {
    auto* stream = avformat_new_stream(&container, nullptr);
    if (stream == nullptr) throw std::bad_alloc();
    encoder->describe(*stream->codecpar);
    stream->time_base = kMilliseconds;
    stream->sample_aspect_ratio = {1, 1};
    const auto part = encoder->facts().part;
    // A player shows the colours.
    if (pictures_[0] == nullptr) stream->disposition = AV_DISPOSITION_DEFAULT;
    av_dict_set(&stream->metadata, "title", std::string(devices::take::name_of(part)).c_str(), 0);
    add(stream->metadata, devices::take::tags_of(encoder->facts()));
    pictures_[std::size_t(part)] = stream;
  }
  if (marks) {
    marks_ = avformat_new_stream(&container, nullptr);
    if (marks_ == nullptr) throw std::bad_alloc();
    marks_->codecpar->codec_type = AVMEDIA_TYPE_SUBTITLE;
    marks_->codecpar->codec_id = AV_CODEC_ID_TEXT;
    marks_->time_base = kMilliseconds;
    av_dict_set(&marks_->metadata, "title", "marks of the run that recorded this", 0);
  }
  add(container.metadata, devices::take::tags_of(facts));
  if (const int code = avformat_write_header(&container, nullptr); code < 0) give_up(code);
  begun_ = true;
  flush();
}

void TakeContainer::append(AVPacket& packet, AVStream& stream) {
  av_packet_rescale_ts(&packet, kMilliseconds, stream.time_base);
  packet.stream_index = stream.index;
  if (const int code = av_write_frame(container_.get(), &packet); code < 0) give_up(code);
}

void TakeContainer::write(AVPacket& packet, devices::take::Stamp stamp, Part part, Nanoseconds time,
                          Nanoseconds length) {
  stamp.checksum = devices::take::checksum(stamp, {packet.data, std::size_t(packet.size)});
  const auto bytes = devices::take::bytes_of(stamp);
  auto* side = av_packet_new_side_data(&packet, AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL, 8 + bytes.size());
  if (side == nullptr) throw std::bad_alloc();
  AV_WB64(side, 1);
  std::memcpy(side + 8, bytes.data(), bytes.size());
  packet.pts = packet.dts = av_rescale_q(time.count(), kNanoseconds, kMilliseconds);
  packet.duration = av_rescale_q(length.count(), kNanoseconds, kMilliseconds);
  last_units_ = std::max(last_units_, packet.pts);
  append(packet, *pictures_[std::size_t(part)]);
}

void TakeContainer::write(const std::vector<devices::take::Mark>& marks) {
  std::string lines;
  for (const auto& mark : marks) lines += devices::take::line_of(mark);
  if (lines.empty() || marks_ == nullptr) return;
  devices::Libav<AVPacket> packet(av_packet_alloc());
  if (!packet || av_new_packet(packet.get(), static_cast<int>(lines.size())) < 0) throw std::bad_alloc();
  std::memcpy(packet->data, lines.data(), lines.size());
  // Where the file has come to: a block further back would make players seek.
  packet->pts = packet->dts = last_units_;
  packet->duration = 1;
  packet->flags |= AV_PKT_FLAG_KEY;
  append(*packet, *marks_);
}

void TakeContainer::flush() {
  // Ends the cluster, which FFmpeg keeps in memory until then.
  if (const int code = av_write_frame(container_.get(), nullptr); code < 0) give_up(code);
  avio_flush(container_->pb);
  if (container_->pb->error < 0) give_up(container_->pb->error);
}

void TakeContainer::sync() {
  // Some file systems cannot, such as a network's.
  if (::fdatasync(::fileno(file_.get())) != 0 && errno != EINVAL && errno != ENOTSUP && errno != EROFS)
    give_up(AVERROR(errno));
}

void TakeContainer::finish() {
  if (begun_) {
    if (const int code = av_write_trailer(container_.get()); code < 0) give_up(code);
  }
  avio_flush(container_->pb);
  const int written = container_->pb->error;
  const int closed = avio_closep(&container_->pb);
  if (written < 0 || closed < 0) give_up(std::min(written, closed));
  sync();
}

}  // namespace choreo::outputs

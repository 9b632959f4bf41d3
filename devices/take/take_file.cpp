// SPDX-License-Identifier: Apache-2.0
#include "devices/take/take_file.hpp"

#include <algorithm>
#include <fstream>
#include <new>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <filesystem>

extern "C" {
#include <libavutil/dict.h>
#include <libavutil/intreadwrite.h>
}

#include "core/error.hpp"

namespace choreo::devices::take {
namespace {

// More than any run keeps in flight, compressed; a file whose marks never come must not fill the memory.
constexpr std::size_t kMostWaiting = std::size_t{1} << 30U;

FindTag finder(const AVDictionary* tags) {
  return [tags](const char* name) -> std::optional<std::string> {
    const auto* entry = av_dict_get(tags, name, nullptr, 0);
    return entry == nullptr ? std::nullopt : std::optional<std::string>(entry->value);
  };
}

std::span<const std::uint8_t> payload(const AVPacket& packet) {
  return {packet.data, static_cast<std::size_t>(std::max(packet.size, 0))};
}

// Block additional 1, behind the eight bytes with which FFmpeg says which one it is.
std::optional<Stamp> stamp_beside(const AVPacket& packet) {
  std::size_t size = 0;
  const auto* side = av_packet_get_side_data(&packet, AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL, &size);
  if (side == nullptr || size < 8 || AV_RB64(side) != 1) return std::nullopt;
  return stamp_of({side + 8, size - 8});
}

}  // namespace

bool looks_like_take(const std::string& path) {
  constexpr std::size_t kLook = 64 * 1024;
  std::error_code problem;
  if (!std::filesystem::is_regular_file(path, problem)) return false;
  std::ifstream file(path, std::ios::binary);
  std::string start(kLook, '\0');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return start.starts_with("\x1a\x45\xdf\xa3") && start.find(kTakeTag) != std::string::npos;
}

TakeFile::TakeFile(const std::string& path, std::stop_token stop)
    : path_(path),
      open_stop_(std::move(stop)),
      bytes_(path, [this] { return open_stop_.stop_requested() || read_stop_.stop_requested(); }) {
  silence_libav();
  forget_libav_message();
  auto* context = avformat_alloc_context();
  if (context == nullptr) throw std::bad_alloc();
  context->pb = bytes_.context();
  context->flags |= AVFMT_FLAG_CUSTOM_IO;
  const int code = avformat_open_input(&context, nullptr, av_find_input_format("matroska"), nullptr);
  container_.reset(context);  // Null where it failed, and then freed.
  if (code < 0) {
    if (open_stop_.stop_requested()) throw failure(fmt::format("\"{}\": opening was interrupted", path));
    throw usage_error(fmt::format("\"{}\" is no take that can be read: {}", path, libav_error_text(code)), {},
                      "choreoscope record writes takes");
  }
  find_tracks();
}

void TakeFile::find_tracks() {
  const auto facts = file_facts(finder(container_->metadata));
  if (!facts) {
    throw usage_error(fmt::format("\"{}\" is no take that this version reads", path_), {},
                      "choreoscope record writes takes; other videos are read as file:NAME");
  }
  facts_ = *facts;
  for (unsigned i = 0; i < container_->nb_streams; ++i) {
    auto* stream = container_->streams[i];
    const auto find = finder(stream->metadata);
    if (stream->codecpar->codec_type == AVMEDIA_TYPE_SUBTITLE && marks_index_ < 0) {
      marks_index_ = static_cast<int>(i);
    } else if (const auto pictures = stream_facts(find); pictures) {
      auto& track = streams_[std::size_t(pictures->part)];
      if (!track.facts) track = {*pictures, static_cast<int>(i)};
    }
  }
  if (!streams_[0].facts && !streams_[1].facts) {
    throw usage_error(fmt::format("\"{}\" is a take without colour and without depth", path_), {},
                      "the recording was cut off before its first frame");
  }
}

const AVCodecParameters& TakeFile::parameters(Part part) const {
  return *container_->streams[streams_[std::size_t(part)].index]->codecpar;
}

std::optional<Nanoseconds> TakeFile::declared_duration() const {
  const auto duration = libav_time(container_->duration, AVRational{1, AV_TIME_BASE});
  return duration && duration->count() > 0 ? duration : std::nullopt;
}

// Takes one packet from the file. False at the end, or where a stop was requested.
bool TakeFile::pull() {
  Libav<AVPacket> packet(av_packet_alloc());
  if (!packet) throw std::bad_alloc();
  const int code = av_read_frame(container_.get(), packet.get());
  if (code < 0) {
    if (open_stop_.stop_requested() || read_stop_.stop_requested()) {
      // FFmpeg remembers the interruption as the end; a later read may go on.
      container_->pb->eof_reached = container_->pb->error = 0;
      return false;
    }
    ended_ = true;
    read_error_ = code == AVERROR_EOF ? container_->pb->error : code;
    return false;
  }
  for (const auto part : {Part::kColour, Part::kDepth}) {
    if (packet->stream_index == streams_[std::size_t(part)].index) {
      add_picture(std::move(packet), part);
      return true;
    }
  }
  if (packet->stream_index == marks_index_) add_marks(*packet);
  return true;
}

void TakeFile::add_picture(Libav<AVPacket> packet, Part part) {
  const auto stamp = stamp_beside(*packet);
  const auto own = part == Part::kColour ? Stamp::kColour : Stamp::kDepth;
  // Of a damaged block nothing is to be trusted, its time and number as little as its picture.
  if (!stamp || packet->size <= 0 || stamp->checksum != checksum(*stamp, payload(*packet)) ||
      (stamp->parts & own) == 0) {
    ++damaged_;
    ++lost_parts_;
    return;
  }
  const auto units = packet->pts != AV_NOPTS_VALUE ? packet->pts : packet->dts;
  const auto time = libav_time(units, container_->streams[packet->stream_index]->time_base);
  last_time_ = std::max(last_time_, time.value_or(last_time_));
  const auto bytes = static_cast<std::size_t>(packet->size);
  const bool second = last_ && stamp->sequence == last_->sequence;
  if (second) {
    if (stamp->time != last_->time || stamp->parts != last_->parts || frames_.empty() ||
        frames_.back().packets[std::size_t(part)]) {
      ++damaged_;
      return;
    }
    frames_.back().packets[std::size_t(part)] = std::move(packet);
  } else {
    if (last_ && (stamp->sequence < last_->sequence || stamp->time <= last_->time)) {
      ++damaged_;
      return;
    }
    auto& frame = frames_.emplace_back();
    frame.stamp = *stamp;
    frame.packets[std::size_t(part)] = std::move(packet);
    last_ = *stamp;
  }
  waiting_bytes_ += bytes;
}

void TakeFile::add_marks(const AVPacket& packet) {
  const std::string_view lines(reinterpret_cast<const char*>(packet.data),
                               static_cast<std::size_t>(std::max(packet.size, 0)));
  for (const auto& mark : marks_of(lines)) {
    if (mark.kind == kLateFaceMark) late_faces_.insert(mark.sequence);
    if (mark.kind == kLatePersonMark) late_people_.insert(mark.sequence);
    if (mark.kind != kProcessedMark || (last_marked_ && mark.sequence <= *last_marked_)) continue;
    processed_.insert(mark.sequence);
    last_marked_ = mark.sequence;
  }
}

// A run goes through its frames in order: what it passed over was overtaken.
Fate TakeFile::fate_of(std::uint64_t sequence) const {
  if (processed_.contains(sequence)) return Fate::kProcessed;
  if (ended_ || lost_marks_ || (last_marked_ && *last_marked_ > sequence)) return Fate::kOvertaken;
  return Fate::kUnknown;
}

std::optional<StoredFrame> TakeFile::next(const std::stop_token& stop, bool want_fate) {
  read_stop_ = stop;
  for (;;) {
    if (stop.stop_requested() || open_stop_.stop_requested()) return std::nullopt;
    const bool known = !frames_.empty() && (frames_.size() > 1 || frames_.front().is_whole() || ended_);
    if (known && want_fate && waiting_bytes_ > kMostWaiting) lost_marks_ = true;
    if (known && (!want_fate || fate_of(frames_.front().stamp.sequence) != Fate::kUnknown)) {
      auto frame = std::move(frames_.front());
      frames_.pop_front();
      for (const auto& packet : frame.packets) waiting_bytes_ -= packet ? static_cast<std::size_t>(packet->size) : 0;
      fate_ = fate_of(frame.stamp.sequence);
      const auto was_late = [sequence = frame.stamp.sequence](std::set<std::uint64_t>& late) {
        const bool is = late.contains(sequence);
        late.erase(late.begin(), late.upper_bound(sequence));
        return is;
      };
      late_face_ = was_late(late_faces_);
      late_person_ = was_late(late_people_);
      processed_.erase(processed_.begin(), processed_.upper_bound(frame.stamp.sequence));
      if (frame.is_whole()) return frame;
      // One picture whose other was damaged is no further damage.
      if (lost_parts_ > 0) {
        --lost_parts_;
      } else {
        ++damaged_;
      }
      continue;
    }
    if (ended_) return std::nullopt;
    if (!pull() && !ended_) return std::nullopt;
  }
}

}  // namespace choreo::devices::take

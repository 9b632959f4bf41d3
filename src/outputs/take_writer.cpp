// SPDX-License-Identifier: Apache-2.0
#include "outputs/take_writer.hpp"

#include <fcntl.h>
#include <pthread.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <new>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::outputs {
namespace {

namespace fs = std::filesystem;
using devices::Frame;
using devices::take::Part;
using devices::take::Stamp;

constexpr double kUndeclaredFps = 30;
constexpr auto kLongestWait = std::chrono::minutes(1);

std::size_t bytes_of(const Frame& frame) {
  const auto raw = [](const devices::RawPicturePtr& picture) { return picture ? picture->bytes.size() : 0; };
  return frame.bgr.total() * frame.bgr.elemSize() + frame.depth.total() * frame.depth.elemSize() +
         raw(frame.raw_colour) + raw(frame.raw_depth);
}

void check_name(const std::string& path, bool force, const std::string& if_there) {
  if (fs::path(path).extension() != ".mkv" || fs::path(path).stem().empty()) {
    throw usage_error(fmt::format("\"{}\" does not end in .mkv", path), {}, "takes are Matroska: name it take.mkv");
  }
  std::error_code problem;
  const auto type = fs::status(path, problem).type();
  if (type != fs::file_type::not_found && !problem) {
    if (type != fs::file_type::regular) throw usage_error(fmt::format("\"{}\" is no file to write to", path));
    if (!force) throw usage_error(fmt::format("\"{}\" is there already", path), {}, if_there);
  }
  const auto folder = fs::absolute(path).parent_path();
  if (!fs::is_directory(folder, problem)) {
    throw usage_error(fmt::format("\"{}\" is no folder", folder.string()), {}, "make it first");
  }
}

void require_room(const std::string& path, const devices::SourceInfo& source) {
  std::error_code problem;
  const auto space = fs::space(fs::absolute(path).parent_path(), problem);
  if (problem) return;
  const double fps = source.nominal_fps > 0 ? source.nominal_fps : kUndeclaredFps;
  const double second = 2.0 * source.size.width * source.size.height * fps;
  if (double(space.available) >= second) return;
  throw usage_error(fmt::format("there is no room for \"{}\": {:.1f} MB are free, a second takes up to {:.1f} MB", path,
                                1e-6 * double(space.available), 1e-6 * second),
                    {}, "make room on the disk, or record elsewhere");
}

// False, with errno, where that is impossible, or something is there that is not to be replaced.
bool moved(const std::string& from, const std::string& to, bool replace) {
  if (!replace && ::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  // Not every file system knows that call's flag.
  if (!replace && errno != EINVAL) return false;
  return std::rename(from.c_str(), to.c_str()) == 0;
}

}  // namespace

std::string TakeWriter::unfinished(const std::string& path) {
  return fs::path(path).replace_extension(".unfinished.mkv").string();
}

TakeWriter::TakeWriter(std::string path, const devices::SourceInfo& source, TakeOptions options)
    : path_(std::move(path)), source_(source), options_(std::move(options)) {
  check_name(path_, options_.force, options_.if_there);
  require_room(path_, source_);
  container_ = std::make_unique<TakeContainer>(unfinished(path_));
  thread_ = std::thread([this] { work(); });
}

TakeWriter::~TakeWriter() {
  try {
    if (!closed_) (void)close();
  } catch (const std::exception&) {
    // Who wants to know calls close.
  }
}

void TakeWriter::add(devices::FramePtr frame) {
  const auto bytes = bytes_of(*frame);
  std::unique_lock lock(mutex_);
  // One frame always has room, however large it is.
  const auto room = [&] { return problem_ || waiting_.empty() || waiting_bytes_ + bytes <= options_.queue_bytes; };
  if (options_.full == FullQueue::kWait) changed_.wait_for(lock, kLongestWait, room);
  if (problem_ || ending_) return;
  if (!room()) {
    ++report_.left_out;
    if (options_.marks) left_out_.push_back(frame->sequence);
    return;
  }
  waiting_bytes_ += bytes;
  waiting_.push_back(std::move(frame));
  lock.unlock();
  changed_.notify_all();
}

void TakeWriter::processed(std::uint64_t sequence) {
  const std::scoped_lock lock(mutex_);
  if (problem_ || !options_.marks) return;
  while (!left_out_.empty() && left_out_.front() < sequence) left_out_.pop_front();
  if (!left_out_.empty() && left_out_.front() == sequence) {
    ++report_.processed_missing;
  } else {
    marks_.push_back({devices::take::kProcessedMark, sequence, {}});
  }
}

void TakeWriter::mark(const char* kind, std::uint64_t sequence) {
  const std::scoped_lock lock(mutex_);
  if (problem_ || !options_.marks) return;
  marks_.push_back({kind, sequence, {}});
}

void TakeWriter::work() {
  pthread_setname_np(pthread_self(), "take");
  try {
    write_waiting();
    if (container_->has_begun()) container_->finish();
  } catch (const std::exception& error) {
    std::deque<devices::FramePtr> dropped;  // Destroyed after the lock is released.
    {
      const std::scoped_lock lock(mutex_);
      problem_ = std::current_exception();
      dropped.swap(waiting_);
      waiting_bytes_ = 0;
      marks_.clear();
    }
    changed_.notify_all();
    if (options_.on_trouble) options_.on_trouble(error.what());
  }
}

void TakeWriter::write_waiting() {
  for (;;) {
    devices::FramePtr frame;
    std::vector<devices::take::Mark> marks;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
      marks.swap(marks_);
      if (!waiting_.empty()) {
        frame = waiting_.front();
        waiting_.pop_front();
        waiting_bytes_ -= bytes_of(*frame);
      }
    }
    changed_.notify_all();
    if (frame) hold_or_write(frame);
    if (!frame) write_held();
    // The marks of the first frames may be there before the file has begun; they come after one is written.
    if (container_->has_begun()) {
      container_->write(marks);
      container_->flush();
      const auto now = std::chrono::steady_clock::now();
      if (now - synced_ >= std::chrono::seconds(1)) {
        container_->sync();
        synced_ = now;
      }
    }
    if (!frame) return;
  }
}

// A device may pair its first frames late: the header wants to know of the depth.
void TakeWriter::hold_or_write(devices::FramePtr frame) {
  if (!encoders_.empty()) return write(*frame);
  held_.push_back(std::move(frame));
  constexpr auto kLongest = std::chrono::seconds(1);
  const bool expected = source_.depth && options_.depth;
  if (expected && held_.back()->depth.empty() && held_.back()->device_time - held_.front()->device_time < kLongest) {
    return;
  }
  write_held();
}

void TakeWriter::write_held() {
  if (held_.empty()) return;
  begin(*held_.back());
  for (const auto& frame : std::exchange(held_, {})) write(*frame);
}

// Whether a frame's worth of FFV1 leaves the machine time for other things.
TakeCodec TakeWriter::measured(const Frame& frame) const {
  // Where the source waits, nothing is lost by being slow.
  if (options_.full == FullQueue::kWait && source_.repeatable) return TakeCodec::kFfv1;
  const double fps = source_.nominal_fps > 0 ? source_.nominal_fps : kUndeclaredFps;
  double least = 1e9;
  std::vector<std::pair<TakePicture, std::unique_ptr<TakeEncoder>>> trials;
  for (const auto part : {Part::kColour, Part::kDepth}) {
    const auto picture = picture_of(frame, part);
    if (picture.bytes == nullptr || !(part == Part::kColour ? options_.colour : options_.depth)) continue;
    trials.emplace_back(picture, std::make_unique<TakeEncoder>(part, picture, source_, TakeCodec::kFfv1));
  }
  for (int k = 0; k < 3; ++k) {
    const auto start = std::chrono::steady_clock::now();
    for (const auto& [picture, encoder] : trials) (void)encoder->encode(picture);
    least = std::min(least, to_seconds(std::chrono::steady_clock::now() - start));
  }
  constexpr double kShare = 0.5;
  return least * fps <= kShare ? TakeCodec::kFfv1 : TakeCodec::kFfvhuff;
}

void TakeWriter::begin(const Frame& frame) {
  auto codec = options_.codec == TakeCodec::kAuto ? measured(frame) : options_.codec;
  std::string codecs;
  for (const auto part : {Part::kColour, Part::kDepth}) {
    const auto picture = picture_of(frame, part);
    if (picture.bytes == nullptr || !(part == Part::kColour ? options_.colour : options_.depth)) continue;
    encoders_.push_back(std::make_unique<TakeEncoder>(part, picture, source_, codec));
    codecs += fmt::format("{}{} {}", codecs.empty() ? "" : ", ", devices::take::name_of(part),
                          encoders_.back()->facts().codec);
  }
  if (encoders_.empty()) {
    throw failure(fmt::format("\"{}\" has none of the pictures that are to be recorded", source_.name), {},
                  "choose what it has with --streams");
  }
  devices::take::FileFacts facts;
  facts.source = source_.name;
  facts.program = options_.program;
  facts.controls = source_.controls;
  facts.settings = options_.settings;
  facts.nominal_fps = std::clamp(source_.nominal_fps, 0.0, 1000.0);
  facts.foreseeable = source_.repeatable && source_.foreseeable;
  container_->begin(facts, encoders_, options_.marks);
  const std::scoped_lock lock(mutex_);
  report_.codecs = codecs;
}

void TakeWriter::write(const Frame& frame) {
  if (last_ && (frame.device_time <= *last_ || frame.sequence <= *last_sequence_)) {
    throw failure(
        fmt::format("\"{}\": frame {} does not come after frame {}", source_.name, frame.sequence, *last_sequence_));
  }
  if (!first_) first_ = frame.device_time;
  Stamp stamp;
  stamp.time = frame.device_time;
  stamp.sequence = frame.sequence;
  for (const auto& encoder : encoders_) {
    if (picture_of(frame, encoder->facts().part).bytes == nullptr) continue;
    stamp.parts |= encoder->facts().part == Part::kColour ? Stamp::kColour : Stamp::kDepth;
  }
  const bool late = options_.depth && encoders_.back()->facts().part == Part::kColour && !frame.depth.empty();
  const auto length = from_seconds(1.0 / (source_.nominal_fps > 0 ? source_.nominal_fps : kUndeclaredFps));
  for (const auto& encoder : encoders_) {
    const auto part = encoder->facts().part;
    const auto picture = picture_of(frame, part);
    if (picture.bytes == nullptr) continue;  // A Kinect's depth without its colours, or the other way round.
    container_->write(encoder->encode(picture), stamp, part, frame.device_time - *first_, length);
  }
  last_ = frame.device_time;
  const std::scoped_lock lock(mutex_);
  report_.frames += stamp.parts != 0 ? 1 : 0;
  report_.without_depth += late ? 1 : 0;
  report_.length = *last_ - *first_;
  if (last_sequence_) report_.gaps += frame.sequence - *last_sequence_ - 1;
  last_sequence_ = frame.sequence;
}

void TakeWriter::stop() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void TakeWriter::discard() {
  if (closed_) return;
  stop();
  closed_ = true;
  container_.reset();
  std::remove(unfinished(path_).c_str());
}

TakeReport TakeWriter::close() {
  if (closed_) return report_;
  stop();
  closed_ = true;
  const auto part = unfinished(path_);
  const bool begun = container_->has_begun();
  container_.reset();
  if (!begun) std::remove(part.c_str());
  if (problem_) {
    try {
      std::rethrow_exception(problem_);
    } catch (const std::exception& error) {
      const auto* known = dynamic_cast<const Error*>(&error);
      throw failure(fmt::format("the recording broke off after {}: {}", counted(report_.frames, "frame"), error.what()),
                    {},
                    begun              ? fmt::format("what came before is in \"{}\"", part)
                    : known != nullptr ? known->hint()
                                       : std::string());
    }
  }
  if (!begun) return report_;
  if (!moved(part, path_, options_.force)) {
    throw failure(
        fmt::format("\"{}\" cannot be renamed to \"{}\": {}", part, path_, std::generic_category().message(errno)));
  }
  std::error_code problem;
  const auto bytes = fs::file_size(path_, problem);
  report_.bytes = problem ? 0 : bytes;
  // Frames that were left out are gaps in the file, but none of the source's.
  report_.gaps -= std::min(report_.gaps, report_.left_out);
  return report_;
}

}  // namespace choreo::outputs

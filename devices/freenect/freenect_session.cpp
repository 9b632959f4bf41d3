// SPDX-License-Identifier: Apache-2.0
#include "devices/freenect/freenect_session.hpp"

#include <pthread.h>
#include <sys/time.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "core/text.hpp"
#include "devices/fourcc.hpp"
#include "devices/freenect/freenect_library.hpp"
#include "devices/media/kinect_depth.hpp"
#include "devices/media/raw_converter.hpp"

namespace choreo::devices::freenect {
namespace {

using namespace std::chrono_literals;

constexpr int kInfraredLines = 488;  // Four above and four below what the depth has.
constexpr auto kOpening = 5s;
constexpr auto kOpeningWithMotor = 25s;  // The audio chip's firmware may be loaded first, for as much as 10 s.
constexpr auto kClosing = 3s;
constexpr auto kClosingInterrupted = 500ms;  // Whoever stopped the opening waits.
constexpr auto kHangs = 400ms;               // The library has not come back from a call for so long:
constexpr auto kClosingWhatHangs = 50ms;     // it is not waited for.
constexpr timeval kEventSlice{0, 100'000};
constexpr int kInterrupted = -10;  // libusb's LIBUSB_ERROR_INTERRUPTED: a signal came, nothing is lost.

bool is_depth(const freenect_frame_mode& mode, freenect_depth_format format) { return mode.depth_format == format; }
bool is_video(const freenect_frame_mode& mode, freenect_video_format format) { return mode.video_format == format; }

// The mode of a format at 640 x 480, as far as the library lists it: fakenect aborts when asked for one it lacks.
std::optional<freenect_frame_mode> depth_mode(freenect_depth_format format) {
  for (int k = 0; k < freenect_get_depth_mode_count(); ++k) {
    const auto mode = freenect_get_depth_mode(k);
    if (mode.is_valid != 0 && mode.resolution == FREENECT_RESOLUTION_MEDIUM && is_depth(mode, format)) return mode;
  }
  return std::nullopt;
}
std::optional<freenect_frame_mode> video_mode(freenect_video_format format) {
  for (int k = 0; k < freenect_get_video_mode_count(); ++k) {
    const auto mode = freenect_get_video_mode(k);
    if (mode.is_valid != 0 && mode.resolution == FREENECT_RESOLUTION_MEDIUM && is_video(mode, format)) return mode;
  }
  return std::nullopt;
}

// Stops and closes a device.
struct CloseDevice {
  void operator()(freenect_device* device) const {
    freenect_stop_depth(device);
    freenect_stop_video(device);
    freenect_close_device(device);
  }
};
using Device = std::unique_ptr<freenect_device, CloseDevice>;

}  // namespace

// What the session and the library's thread share.
struct Session::Shared {
  Shared(const Wish& w, const Clock& c, std::size_t colour_bytes, std::size_t depth_bytes)
      : wish(w),
        clock(c),
        last_turn(c.now().count()),
        pairing(colour_bytes, depth_bytes),
        pairs(w.every_frame ? kMostWaiting : 1, colour_bytes, depth_bytes) {}

  // Called back by the library, in its thread.
  static void on_video(freenect_device* device, void* bytes, std::uint32_t ticks) noexcept;
  static void on_depth(freenect_device* device, void* bytes, std::uint32_t ticks) noexcept;
  void publish() noexcept;
  void warn(std::string line);

  const Wish wish;
  const Clock& clock;  // Not read once `stop` is set: a thread that was given up may outlive it.
  std::atomic<bool> stop{false};
  std::atomic<Nanoseconds::rep> last_turn;  // When the library's thread last came round.

  // Of the library's thread.
  Pairing pairing;
  bool registers = false;  // Whether depth comes registered, in millimetres.

  std::mutex mutex;
  std::condition_variable_any changed;
  bool streaming = false;
  bool over = false;  // There is no more to come,
  bool gone = false;  // and the thread ends.
  std::string lost;   // Why.
  std::optional<Error> refused;
  std::string serial;
  std::vector<std::string> warnings;
  PairQueue pairs;
};

void Session::Shared::on_video(freenect_device* device, void* bytes, std::uint32_t ticks) noexcept {
  auto& self = *static_cast<Shared*>(freenect_get_user(device));
  if (!self.stop && self.pairing.add_colour(bytes, ticks, self.clock.now())) self.publish();
}

void Session::Shared::on_depth(freenect_device* device, void* bytes, std::uint32_t ticks) noexcept {
  auto& self = *static_cast<Shared*>(freenect_get_user(device));
  if (!self.stop && self.pairing.add_depth(bytes, ticks, self.clock.now())) self.publish();
}

void Session::Shared::publish() noexcept {
  {
    // Whoever else holds this swaps some pointers, too.
    const std::scoped_lock lock(mutex);
    pairs.put(pairing.colour, pairing.depth);
  }
  changed.notify_all();
}

void Session::Shared::warn(std::string line) {
  const std::scoped_lock lock(mutex);
  warnings.push_back(std::move(line));
}

namespace {

// Which one to open, by its serial number; empty for the first.
// @throws DeviceLost where it is not there.
std::string chosen_serial(const Context& context, const Wish& wish) {
  const int count = context.count();
  if (count == 0) throw DeviceLost("no Kinect v1 is plugged in");
  const auto serials = context.serials();
  if (!serials) return wish.serial;
  if (wish.serial.empty()) return serials->empty() ? "" : serials->front();
  if (std::find(serials->begin(), serials->end(), wish.serial) != serials->end()) return wish.serial;
  const int closed = count - static_cast<int>(serials->size());
  if (closed > 0 && !wish.was_there) {
    throw usage_error(
        fmt::format("no Kinect v1 has the serial number \"{}\", but {} may not be opened", wish.serial, closed), {},
        kUsbRemedy);
  }
  throw DeviceLost(fmt::format("no Kinect v1 with the serial number \"{}\" is plugged in{}", wish.serial,
                               serials->empty() ? "" : "; there is " + join(*serials)));
}

Device try_to_open(const Context& context, int subdevices, const std::string& serial) {
  freenect_select_subdevices(context.get(), static_cast<freenect_device_flags>(subdevices));
  freenect_device* device = nullptr;
  const int code = serial.empty() ? freenect_open_device(context.get(), &device, 0)
                                  : freenect_open_device_by_camera_serial(context.get(), &device, serial.c_str());
  return Device(code < 0 ? nullptr : device);
}

// The cameras alone where nothing else is asked for: then no motor, audio chip or firmware can stand in the way.
Device open_device(Context& context, const Wish& wish, const std::string& serial, bool& motor) {
  motor = false;
  if (wish.led || wish.tilt) {
    constexpr int kMotor = FREENECT_DEVICE_CAMERA | FREENECT_DEVICE_MOTOR;
    for (const int subdevices : {kMotor, kMotor | FREENECT_DEVICE_AUDIO}) {
      auto device = try_to_open(context, subdevices, serial);
      motor = device != nullptr && context.has_motor().value_or(true);
      if (motor) return device;
    }
    (void)context.take_complaints();
  }
  auto device = try_to_open(context, FREENECT_DEVICE_CAMERA, serial);
  if (device) return device;
  const auto complaint = context.take_complaints();
  const auto what = "the Kinect v1 cannot be opened" + (complaint.empty() ? "" : ": " + complaint);
  if (is_about_permission(complaint) && !wish.was_there) throw usage_error(what, {}, kUsbRemedy);
  throw DeviceLost(what);
}

}  // namespace

void Session::stream(Shared& shared) {
  const auto& wish = shared.wish;
  Context context;
  const auto serial = chosen_serial(context, wish);
  bool motor = false;
  const auto device = open_device(context, wish, serial, motor);
  freenect_set_user(device.get(), &shared);

  const auto video = video_mode(wish.infrared ? FREENECT_VIDEO_IR_8BIT : FREENECT_VIDEO_RGB);
  if (!video || static_cast<std::size_t>(video->bytes) != shared.pairing.colour.bytes.size()) {
    throw usage_error(fmt::format("this libfreenect gives no {} of 640x480", wish.infrared ? "infrared" : "colour"));
  }
  const auto broke = [&](const char* what) {
    const auto complaint = context.take_complaints();
    return DeviceLost(what + (complaint.empty() ? "" : ": " + complaint));
  };
  freenect_set_video_callback(device.get(), Shared::on_video);
  if (freenect_set_video_mode(device.get(), *video) < 0) throw broke("the Kinect's colour cannot be set");
  if (wish.depth != DepthView::kOff) {
    auto depth = wish.depth == DepthView::kRegistered ? depth_mode(FREENECT_DEPTH_REGISTERED) : std::nullopt;
    shared.registers = depth.has_value();
    if (!depth) depth = depth_mode(FREENECT_DEPTH_11BIT);
    if (!depth || static_cast<std::size_t>(depth->bytes) != shared.pairing.depth.bytes.size()) {
      throw usage_error("this libfreenect gives no depth of 640x480");
    }
    freenect_set_depth_callback(device.get(), Shared::on_depth);
    if (freenect_set_depth_mode(device.get(), *depth) < 0) throw broke("the Kinect's depth cannot be set");
    if (freenect_start_depth(device.get()) < 0) throw broke("the Kinect's depth cannot start");
  }
  if (freenect_start_video(device.get()) < 0) throw broke("the Kinect's colour cannot start");
  if (wish.led && (!motor || freenect_set_led(device.get(), static_cast<freenect_led_options>(*wish.led)) < 0)) {
    shared.warn("the Kinect's LED cannot be set; models 1473 and 1517 need the firmware audios.bin for it");
  }
  if (wish.tilt && (!motor || freenect_set_tilt_degs(device.get(), *wish.tilt) < 0)) {
    shared.warn("the Kinect cannot be tilted; models 1473 and 1517 need the firmware audios.bin for it");
  }
  {
    const std::scoped_lock lock(shared.mutex);
    shared.serial = serial;
    shared.streaming = true;
  }
  shared.changed.notify_all();

  bool told = false;
  while (!shared.stop) {
    shared.last_turn = shared.clock.now().count();
    auto slice = kEventSlice;
    const int code = freenect_process_events_timeout(context.get(), &slice);
    if (code < 0 && code != kInterrupted) throw broke("the Kinect v1 does not answer any more");
    if (shared.pairing.by_arrival() && !std::exchange(told, true)) {
      shared.warn("the Kinect's times of colour and depth disagree: paired by when they arrived");
    }
  }
}

void Session::run(const std::shared_ptr<Shared>& shared) noexcept {
  pthread_setname_np(pthread_self(), "freenect");
  std::string lost;
  std::optional<Error> refused;
  try {
    stream(*shared);
  } catch (const Error& error) {
    refused = error;
  } catch (const std::exception& error) {
    lost = error.what();
  }
  {
    const std::scoped_lock lock(shared->mutex);
    shared->lost = std::move(lost);
    shared->refused = std::move(refused);
    shared->over = shared->gone = true;
  }
  shared->changed.notify_all();
}

Session::Session(const Wish& wish, const Clock& clock, const std::stop_token& stop) : wish_(wish) {
  const auto pixels = static_cast<std::size_t>(kKinectSize.area());
  const auto colour_bytes = wish.infrared ? std::size_t{640} * kInfraredLines : pixels * 3;
  const auto depth_bytes = wish.depth == DepthView::kOff ? 0 : pixels * 2;
  info_.size = kKinectSize;
  info_.nominal_fps = kKinectFps;
  info_.depth = wish.depth != DepthView::kOff;
  info_.registers_depth = wish.depth == DepthView::kRegistered;
  colour_.bytes.resize(colour_bytes);
  depth_.bytes.resize(depth_bytes);
  shared_ = std::make_shared<Shared>(wish, clock, colour_bytes, depth_bytes);
  thread_ = std::thread([shared = shared_] { run(shared); });
  bool answered = false;
  bool over = false;
  {
    std::unique_lock lock(shared_->mutex);
    const bool with_motor = wish.led || wish.tilt;
    answered = shared_->changed.wait_for(lock, stop, with_motor ? kOpeningWithMotor : kOpening,
                                         [&] { return shared_->streaming || shared_->over; });
    over = shared_->over && shared_->pairs.empty();
  }
  if (answered && !over) return;
  end(stop.stop_requested() ? Nanoseconds(kClosingInterrupted) : kClosing);
  if (!answered && stop.stop_requested()) throw DeviceLost("opening was interrupted");
  if (!answered) throw DeviceLost("the Kinect v1 does not answer");
  tell_why();
}

Session::~Session() { end(kClosing); }

void Session::end(Nanoseconds patience) noexcept {
  if (!thread_.joinable()) return;
  shared_->stop = true;
  const bool hangs = shared_->clock.now() - Nanoseconds{shared_->last_turn} > kHangs;
  bool gone = false;
  {
    std::unique_lock lock(shared_->mutex);
    gone = shared_->changed.wait_for(lock, hangs ? kClosingWhatHangs : patience, [&] { return shared_->gone; });
  }
  if (gone) {
    thread_.join();
  } else {
    thread_.detach();  // It keeps what it shares alive, and ends when the library lets it.
  }
}

void Session::tell_why() const {
  const std::scoped_lock lock(shared_->mutex);
  if (shared_->refused) throw Error(*shared_->refused);
  throw DeviceLost(shared_->lost.empty() ? "the Kinect v1 stopped" : shared_->lost);
}

std::string Session::serial() const {
  const std::scoped_lock lock(shared_->mutex);
  return shared_->serial;
}

std::optional<DeviceFrame> Session::wait(Nanoseconds patience) {
  bool over = false;
  {
    std::unique_lock lock(shared_->mutex);
    const auto ready = [&] { return !shared_->pairs.empty() || shared_->over; };
    if (!shared_->changed.wait_for(lock, patience, ready)) return std::nullopt;
    over = !shared_->pairs.take(colour_, depth_);
  }
  if (over) tell_why();

  DeviceFrame frame;
  frame.counter = colour_.counter;
  frame.arrival = colour_.arrival;
  frame.device_time = ticks_.time(colour_.ticks, colour_.arrival);
  if (wish_.infrared) {
    const cv::Mat whole(kInfraredLines, kKinectSize.width, CV_8UC1, colour_.bytes.data());
    const int above = (kInfraredLines - kKinectSize.height) / 2;
    const cv::Mat seen = whole.rowRange(above, above + kKinectSize.height);
    cv::cvtColor(seen, frame.bgr, cv::COLOR_GRAY2BGR);
    if (wish_.keep_raw) frame.raw_colour = keep_raw(dense_layout(kGrey, kKinectSize), {seen.data, seen.total()});
  } else {
    cv::cvtColor(cv::Mat(kKinectSize, CV_8UC3, colour_.bytes.data()), frame.bgr, cv::COLOR_RGB2BGR);
  }
  if (wish_.depth == DepthView::kOff) return frame;
  if (shared_->registers) {
    frame.depth = cv::Mat(kKinectSize, CV_16UC1, depth_.bytes.data()).clone();
    return frame;
  }
  frame.depth = kinect_depth(depth_.bytes);
  if (wish_.depth == DepthView::kRegistered) frame.depth = kinect_registered(frame.depth);
  if (wish_.keep_raw) frame.raw_depth = keep_raw(dense_layout(kKinectDepth, kKinectSize), depth_.bytes);
  return frame;
}

std::vector<std::string> Session::take_warnings() {
  const std::scoped_lock lock(shared_->mutex);
  return std::exchange(shared_->warnings, {});
}

}  // namespace choreo::devices::freenect

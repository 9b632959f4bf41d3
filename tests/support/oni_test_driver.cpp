// SPDX-License-Identifier: Apache-2.0
// A driver for OpenNI2 whose camera is made up: 30 pictures a second of oni_pattern.hpp, or of the file that
// CHOREO_TEST_ONI_SCENE names (oni_scene.hpp), round and round. It reads, while it runs, a word from the file that
// CHOREO_TEST_ONI names: "gone" (unplugged), "silent", "crash", "colour" (it has no depth), "depth" (it has no colour),
// "plain" (it can neither register nor tell its serial number), "nodepth", "nocolour" (that stream falls silent),
// "rude" (its name is no name).
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(p) delete (p)
#include <Driver/OniDriverAPI.h>

#include "support/oni_scene.hpp"

namespace {

using namespace choreo::test;

std::string word() {
  const char* name = std::getenv("CHOREO_TEST_ONI");
  std::string text;
  if (name != nullptr) std::ifstream(name) >> text;
  return text;
}

const OniScene& scene() {
  static const OniScene scene(std::getenv("CHOREO_TEST_ONI_SCENE"));
  return scene;
}

OniVideoMode mode_of(OniSensorType type) {
  return {type == ONI_SENSOR_DEPTH ? ONI_PIXEL_FORMAT_DEPTH_1_MM : ONI_PIXEL_FORMAT_RGB888, scene().width(),
          scene().height(), kOniFps};
}

int stride_of(OniSensorType type) { return scene().width() * (type == ONI_SENSOR_DEPTH ? 2 : 3); }

template <typename T>
OniStatus give(const T& value, void* data, int* size) {
  if (*size < static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof value);
  *size = sizeof value;
  return ONI_STATUS_OK;
}

class Stream final : public oni::driver::StreamBase {
 public:
  explicit Stream(OniSensorType type) : type_(type) {}

  OniStatus start() override {
    running_ = true;
    return ONI_STATUS_OK;
  }
  void stop() override { running_ = false; }

  OniBool isPropertySupported(int id) override {
    return id == ONI_STREAM_PROPERTY_VIDEO_MODE || id == ONI_STREAM_PROPERTY_STRIDE ||
           id == ONI_STREAM_PROPERTY_CROPPING;
  }
  OniStatus getProperty(int id, void* data, int* size) override {
    if (id == ONI_STREAM_PROPERTY_VIDEO_MODE) return give(mode_of(type_), data, size);
    if (id == ONI_STREAM_PROPERTY_STRIDE) return give(stride_of(type_), data, size);
    if (id == ONI_STREAM_PROPERTY_CROPPING) return give(OniCropping{}, data, size);
    return ONI_STATUS_NOT_IMPLEMENTED;
  }
  OniStatus setProperty(int id, const void*, int) override {
    return id == ONI_STREAM_PROPERTY_VIDEO_MODE ? ONI_STATUS_OK : ONI_STATUS_NOT_IMPLEMENTED;
  }
  // What a recorder is not told it does not write, and its recording cannot be played.
  void notifyAllProperties() override {
    const auto mode = mode_of(type_);
    const int stride = stride_of(type_);
    const OniCropping cropping{};
    raisePropertyChanged(ONI_STREAM_PROPERTY_VIDEO_MODE, &mode, sizeof mode);
    raisePropertyChanged(ONI_STREAM_PROPERTY_STRIDE, &stride, sizeof stride);
    raisePropertyChanged(ONI_STREAM_PROPERTY_CROPPING, &cropping, sizeof cropping);
  }

  void give_picture(int k) {
    if (!running_) return;
    auto* frame = getServices().acquireFrame();
    if (frame == nullptr) return;
    frame->sensorType = type_;
    frame->frameIndex = k + 1;
    frame->timestamp =
        kOniFirstUs + kOniStepUs * static_cast<std::uint64_t>(k) + (type_ == ONI_SENSOR_DEPTH ? kOniDepthLateUs : 0);
    frame->videoMode = mode_of(type_);
    frame->width = scene().width();
    frame->height = scene().height();
    frame->stride = stride_of(type_);
    frame->croppingEnabled = 0;
    frame->cropOriginX = frame->cropOriginY = 0;
    frame->dataSize = frame->stride * frame->height;
    if (type_ == ONI_SENSOR_DEPTH) {
      scene().film(k, static_cast<std::uint16_t*>(frame->data));
    } else {
      scene().film(k, static_cast<OniRgb*>(frame->data));
    }
    raiseNewFrame(frame);
    getServices().releaseFrame(frame);
  }

 private:
  OniSensorType type_;
  std::atomic<bool> running_ = false;
};

class Device final : public oni::driver::DeviceBase {
 public:
  explicit Device(std::function<void()> unplugged) : unplugged_(std::move(unplugged)), word_(word()) {
    thread_ = std::thread([this] { run(); });
  }
  ~Device() override {
    ending_ = true;
    thread_.join();
  }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  OniStatus getSensorInfoList(OniSensorInfo** all, int* count) override {
    *count = 0;
    for (const auto type : {ONI_SENSOR_COLOR, ONI_SENSOR_DEPTH}) {
      if (word_ == (type == ONI_SENSOR_COLOR ? "depth" : "colour")) continue;
      modes_[*count] = mode_of(type);
      sensors_[*count] = {type, 1, &modes_[*count]};
      ++*count;
    }
    *all = sensors_;
    return ONI_STATUS_OK;
  }
  oni::driver::StreamBase* createStream(OniSensorType type) override {
    const std::scoped_lock lock(mutex_);
    auto& place = streams_[type == ONI_SENSOR_DEPTH ? 1 : 0];
    place = new Stream(type);
    return place;
  }
  void destroyStream(oni::driver::StreamBase* stream) override {
    const std::scoped_lock lock(mutex_);
    for (auto& place : streams_) {
      if (place == stream) place = nullptr;
    }
    delete stream;
  }
  OniBool isPropertySupported(int id) override {
    return word_ != "plain" &&
           (id == ONI_DEVICE_PROPERTY_SERIAL_NUMBER || id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION);
  }
  OniStatus getProperty(int id, void* data, int* size) override {
    constexpr char kSerial[] = "T-0042";
    if (id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return give(registration_, data, size);
    if (id != ONI_DEVICE_PROPERTY_SERIAL_NUMBER || *size < static_cast<int>(sizeof kSerial)) {
      return ONI_STATUS_NOT_IMPLEMENTED;
    }
    std::memcpy(data, kSerial, sizeof kSerial);
    *size = sizeof kSerial;
    return ONI_STATUS_OK;
  }
  OniStatus setProperty(int id, const void* data, int size) override {
    if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION || size != sizeof registration_) return ONI_STATUS_NOT_IMPLEMENTED;
    std::memcpy(&registration_, data, sizeof registration_);
    return ONI_STATUS_OK;
  }
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override {
    return mode == ONI_IMAGE_REGISTRATION_OFF || word_ != "plain";
  }

 private:
  void run() {
    auto when = std::chrono::steady_clock::now();
    for (int k = 0; !ending_; ++k) {
      const auto now = word();
      if (now == "crash") std::abort();
      if (now == "gone") {
        unplugged_();
        return;
      }
      if (now != "silent") {
        const std::scoped_lock lock(mutex_);
        if (streams_[0] != nullptr && now != "nocolour") streams_[0]->give_picture(k);
        if (streams_[1] != nullptr && now != "nodepth") streams_[1]->give_picture(k);
      }
      when += std::chrono::microseconds(kOniStepUs);
      std::this_thread::sleep_until(when);
    }
  }

  std::function<void()> unplugged_;
  std::string word_;
  std::mutex mutex_;
  Stream* streams_[2] = {};
  OniVideoMode modes_[2] = {};
  OniSensorInfo sensors_[2] = {};
  OniImageRegistrationMode registration_ = ONI_IMAGE_REGISTRATION_OFF;
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

class Driver final : public oni::driver::DriverBase {
 public:
  explicit Driver(OniDriverServices* services) : DriverBase(services) {
    // Each process finds it at another port, as a camera that was plugged in anew.
    std::strcpy(info_.uri, ("choreo/" + std::to_string(::getpid())).c_str());
    std::strcpy(info_.vendor, "Choreo");
    std::strcpy(info_.name, word() == "rude" ? "Test\x1b[31m\nCamera" : "Test Camera");
    info_.usbVendorId = 0x1234;
    info_.usbProductId = 0x5678;
  }

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    const auto status = DriverBase::initialize(connected, disconnected, changed, cookie);
    if (word() != "gone") deviceConnected(&info_);
    return status;
  }
  oni::driver::DeviceBase* deviceOpen(const char*, const char*) override {
    return new Device([this] { deviceDisconnected(&info_); });
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }
  void shutdown() override {}

 private:
  OniDeviceInfo info_{};
};

}  // namespace

ONI_EXPORT_DRIVER(Driver)

// SPDX-License-Identifier: Apache-2.0
// oni_record FILE PICTURES: records the first device that OpenNI2 finds, without loss.
#include <OpenNI.h>
#include <unistd.h>

#include <cstdlib>

namespace {

int record(const char* file, int pictures) {
  using namespace openni;
  if (OpenNI::initialize() != STATUS_OK) return 3;
  Device device;
  if (device.open(ANY_DEVICE) != STATUS_OK) return 4;
  VideoStream streams[2];
  constexpr SensorType kTypes[] = {SENSOR_COLOR, SENSOR_DEPTH};
  Recorder recorder;
  if (recorder.create(file) != STATUS_OK) return 5;
  for (int s = 0; s < 2; ++s) {
    if (!device.hasSensor(kTypes[s])) continue;
    if (streams[s].create(device, kTypes[s]) != STATUS_OK || recorder.attach(streams[s]) != STATUS_OK) return 6;
  }
  if (recorder.start() != STATUS_OK) return 7;
  for (auto& stream : streams) {
    if (stream.isValid() && stream.start() != STATUS_OK) return 8;
  }
  auto& watched = streams[0].isValid() ? streams[0] : streams[1];
  for (int k = 0; k < pictures; ++k) {
    VideoStream* one = &watched;
    int which = 0;
    if (OpenNI::waitForAnyStream(&one, 1, &which, 5000) != STATUS_OK) return 9;
    VideoFrameRef frame;
    if (watched.readFrame(&frame) != STATUS_OK) return 10;
  }
  // The streams first: a recorder that is stopped while pictures come waits for ever, now and then.
  for (auto& stream : streams) {
    if (stream.isValid()) stream.stop();
  }
  recorder.stop();
  recorder.destroy();
  return 0;
}

}  // namespace

int main(int count, char** words) {
  const int status = count == 3 ? record(words[1], std::atoi(words[2])) : 2;
  // What the library does at its end is no part of this.
  ::_exit(status);
}

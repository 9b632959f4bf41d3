// SPDX-License-Identifier: Apache-2.0
#include "recognition/held_sign.hpp"

#include "body/semaphore_signs.hpp"

namespace choreo::recognition {

void SignHold::go_on(double time_s, const SignReading& reading) {
  to_ = time_s;
  if (!reading.sign || *reading.sign != body::semaphore_signs()[sign_].name) return;
  confidence_sum_ += reading.confidence;
  ++confidences_;
  if (reading.confidence > surest_) {
    surest_ = reading.confidence;
    runner_up_ = reading.runner_up;
  }
}

HeldSign SignHold::told() const {
  return {body::semaphore_signs()[sign_].name, from_, to_, confidences_ > 0 ? confidence_sum_ / confidences_ : 0,
          runner_up_};
}

}  // namespace choreo::recognition

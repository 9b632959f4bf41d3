// SPDX-License-Identifier: Apache-2.0
// What is said of signs: what a moment shows, and what was held from when to when.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace choreo::recognition {

/// What a moment shows.
struct SignReading {
  std::optional<std::string_view> sign;  ///< Nothing where no sign is near enough, or two are alike.
  double confidence = 0;                 ///< That the answer is right, be it a sign or none, 0 to 1.
  std::string_view runner_up;            ///< The next sign; where there is none, the nearest. Empty without arms.
};

/// A sign that was held, or a movement that was made.
struct HeldSign {
  std::string_view sign;  ///< A sign of body::semaphore_signs(), kAttention or kError.
  double from = 0;        ///< Seconds, in the time of what was read.
  double to = 0;
  double confidence = 0;       ///< Mean of the readings' while it was held, 0 to 1.
  std::string_view runner_up;  ///< The sign that came nearest beside it at the surest moment; empty for a movement.
};

/// What a moment says, and what it changes.
struct SemaphoreStep {
  SignReading now;               ///< Of the last 0.2 seconds, whether held or not; none where no arms are seen.
  std::optional<HeldSign> held;  ///< The sign that is being held, up to now.
  std::vector<HeldSign> ended;   ///< Signs that are over, in the order of their ends.
};

/// A sign that is being held.
class SignHold {
 public:
  /// @param sign  its place in body::semaphore_signs().
  SignHold(std::size_t sign, double from) : sign_(sign), from_(from), to_(from) {}

  /// It is still held then. On its way out it may be held and yet not be read.
  void go_on(double time_s, const SignReading& reading);

  [[nodiscard]] std::size_t sign() const { return sign_; }
  [[nodiscard]] double from() const { return from_; }
  [[nodiscard]] double to() const { return to_; }
  [[nodiscard]] HeldSign told() const;

 private:
  std::size_t sign_;
  double from_, to_;
  double confidence_sum_ = 0;
  int confidences_ = 0;
  double surest_ = -1;
  std::string_view runner_up_;
};

inline constexpr double kLeaveSign_s = 0.12;   ///< Seconds that arms must be elsewhere until a sign is over.
inline constexpr double kRecentSigns_s = 0.2;  ///< Seconds that are read as one moment.
inline constexpr double kSlowest_s = 1;        ///< Seconds from one frame or look to the next, up to which they follow
                                               ///< one another.

}  // namespace choreo::recognition

// SPDX-License-Identifier: Apache-2.0
// One conversation with the helper, up to whole moments: what a device and a recording have in common.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "devices/openni2/frame_maker.hpp"
#include "devices/openni2/helper_process.hpp"
#include "devices/openni2/pairing.hpp"

namespace choreo::devices::openni2 {

/// The helper told why it cannot go on.
class Refusal : public std::runtime_error {
 public:
  explicit Refusal(Trouble trouble) : std::runtime_error(trouble.text), trouble_(std::move(trouble)) {}
  [[nodiscard]] const Trouble& trouble() const { return trouble_; }

 private:
  Trouble trouble_;
};

/// @thread thread-bound
class Connection {
 public:
  /// Waits until the helper has opened what is asked for.
  /// @param patience  how long it may stay silent.
  /// @throws Refusal; HelperGone, also where it stays silent or stop is requested; Error as HelperProcess.
  Connection(const Request& request, const Descriptor& recording, Nanoseconds patience, const std::stop_token& stop);

  [[nodiscard]] const Opened& opened() const { return opened_; }
  /// Of the frames: that of the video, or of depth alone.
  [[nodiscard]] const Mode& leader() const;
  [[nodiscard]] bool has_depth() const;

  enum class Heard { kNothing, kSomething, kEnd };
  /// Takes one message and what it brings.
  /// @return kNothing where none came within `patience`.  @throws Refusal; HelperGone.
  [[nodiscard]] Heard hear(Nanoseconds patience);
  /// The next moment that is complete, of what was heard.
  [[nodiscard]] std::optional<Moment> next() { return pairing_->next(); }
  /// Forgets what was heard and is no complete moment yet.
  void forget() { pairing_->clear(); }
  /// Nothing more will be heard: `next` gives what waits.
  void end() { pairing_->end(); }

  /// How many pictures were heard, of all streams, and of stream `number` of `opened`.
  [[nodiscard]] std::uint64_t pictures() const { return all_pictures_; }
  [[nodiscard]] std::uint64_t pictures(std::size_t number) const { return pictures_.at(number); }
  [[nodiscard]] std::size_t unpaired_depths() const { return pairing_->unpaired_depths(); }
  [[nodiscard]] std::vector<std::string> take_warnings() { return std::exchange(warnings_, {}); }
  [[nodiscard]] HelperProcess& helper() { return helper_; }

 private:
  [[nodiscard]] Message message_within(Nanoseconds patience, const std::stop_token& stop);
  void take(const Picture& picture);

  HelperProcess helper_;
  Opened opened_;
  std::optional<Pairing> pairing_;
  std::vector<std::uint64_t> pictures_;
  std::uint64_t all_pictures_ = 0;
  std::vector<std::string> warnings_;
};

}  // namespace choreo::devices::openni2

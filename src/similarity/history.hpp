// SPDX-License-Identifier: Apache-2.0
// What every online history keeps, whatever the representation of the body.
#pragma once

#include <cstddef>

namespace choreo::similarity {

/// The latest states, in a ring whose memory is fixed when it is made.
///
/// A representation derives from this and adds `append`, which takes its own kind of state (nullptr: a gap) and gives
/// the row of Z and Z* of that state against the history, oldest first, the state itself last, NaN where either is a
/// gap. Every value equals what the representation's `Comparer` gives for that pair, to the last bit.
/// @thread reentrant; `append` and `drop_oldest` change the history.
class History {
 public:
  virtual ~History() = default;

  /// How many states fit.
  [[nodiscard]] virtual std::size_t capacity() const = 0;
  /// How many there are, gaps included.
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// What one more state of capacity costs, in bytes.
  [[nodiscard]] virtual std::size_t bytes_per_row() const = 0;
  /// All that the history holds, in bytes; the same from the first state to the last.
  [[nodiscard]] virtual std::size_t memory_bytes() const = 0;
  /// Forgets the `count` oldest states, at most all: who knows the times decides when a state is too old.
  virtual void drop_oldest(std::size_t count) = 0;
};

}  // namespace choreo::similarity

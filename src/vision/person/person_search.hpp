// SPDX-License-Identifier: Apache-2.0
// Follows one person from look to look, and finds them again.
#pragma once

#include <cstdint>
#include <optional>

#include <opencv2/core/mat.hpp>

#include "vision/person/person_network.hpp"

namespace choreo::vision {

/// Where to look: where the person was, or else in the whole picture and in each of the squares at its two ends, in
/// which those far away are larger.
struct PersonQuery {
  std::optional<PersonRegion> region;
  std::optional<int> turn;  ///< Which of the three alone; nothing: one after the other, until somebody is found.
};

/// Decides where to look next, by what was seen last. Reads no clock and no picture.
class PersonTrack {
 public:
  static constexpr double kLeastScore = 0.5;                  ///< Of a look that shows a person.
  enum class Seeks : std::uint8_t { kEverywhere, kInTurns };  ///< What a look takes in where nobody is known.

  explicit PersonTrack(Seeks seeks = Seeks::kEverywhere) : seeks_(seeks) {}

  [[nodiscard]] PersonQuery next() const {
    return {region_, seeks_ == Seeks::kInTurns ? std::optional(turn_) : std::nullopt};
  }
  /// What a look gave that was asked for.
  void update(const std::optional<PersonLook>& look);

 private:
  std::optional<PersonRegion> region_;
  Seeks seeks_;
  int turn_ = 0;
};

/// Carries a query out.
/// @thread thread-bound
class PersonSearch {
 public:
  PersonSearch(PersonNetwork network, PersonDetector detector)
      : network_(std::move(network)), detector_(std::move(detector)) {}

  /// @param picture  CV_8UC3, not empty.
  /// @return the person of the query's region; where nobody is there any more, or nobody was known, the largest one
  ///   that is found. Nothing where there is nobody. A look at somebody who was just found is done twice: the first
  ///   tells better where they are.
  [[nodiscard]] std::optional<PersonLook> search(const cv::Mat& picture, const PersonQuery& query);

 private:
  [[nodiscard]] std::optional<PersonLook> found(const cv::Mat& picture, int turn);

  PersonNetwork network_;
  PersonDetector detector_;
};

}  // namespace choreo::vision

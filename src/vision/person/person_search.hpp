// SPDX-License-Identifier: Apache-2.0
// Follows one person from look to look, finds them again, and looks for others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/person/person_network.hpp"

namespace choreo::vision {

/// Who is followed, of several who are found where nobody was.
enum class PersonChoice : std::uint8_t { kLargest, kLeft, kMiddle, kRight };

/// Where to look: where the person was, or else in the whole picture, in each of the squares at its two ends, in
/// which those far away are larger, and in one about what moved since the search before, for those who come in at the
/// side.
struct PersonQuery {
  std::optional<PersonRegion> region;
  std::optional<int> turn;  ///< Which of the four alone; nothing: one after the other, until somebody is found.
  std::vector<PersonLook> others = {};  ///< Who is not who was lost.
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

/// Whether two looks show one person: their joints are in the same places, to a twelfth of the region.
[[nodiscard]] bool show_the_same(const PersonLook& a, const PersonLook& b);

/// Where to look for the others.
struct OthersQuery {
  std::vector<PersonLook> known;    ///< As they were seen last.
  std::vector<std::size_t> looked;  ///< Which of these are looked at.
  bool seek = false;                ///< Whether more are searched for,
  std::optional<int> turn = {};     ///< in which part alone, by turns of any number; nothing: in all.
};

/// Decides where to look for others next: at all of them and now and then in a part of the picture, or, in turns, at
/// one of them or in a part.
class OthersTrack {
 public:
  static constexpr std::size_t kMost = 4;

  struct Other {
    PersonLook look;
    std::int64_t when = 0;
  };

  explicit OthersTrack(PersonTrack::Seeks seeks = PersonTrack::Seeks::kEverywhere) : seeks_(seeks) {}

  [[nodiscard]] OthersQuery next() const;
  /// What a query gave that was asked for, and of which time that is.
  void update(const OthersQuery& query, const std::vector<std::optional<PersonLook>>& looks, std::int64_t when);

  [[nodiscard]] const std::vector<Other>& known() const { return known_; }
  [[nodiscard]] PersonTrack::Seeks seeks() const { return seeks_; }

 private:
  PersonTrack::Seeks seeks_;
  std::vector<Other> known_;
  int looks_ = 0;  // In a row.
  int sought_ = 0;
};

/// Carries queries out.
/// @thread thread-bound
class PersonSearch {
 public:
  PersonSearch(PersonNetwork network, PersonDetector detector, PersonChoice choice = PersonChoice::kLargest)
      : network_(std::move(network)), detector_(std::move(detector)), choice_(choice) {}

  /// @param picture  CV_8UC3, not empty.
  /// @return the person of the query's region; where nobody is there any more, or nobody was known, the one
  ///   that is chosen of those who are found. Nothing where there is nobody. A look at somebody who was just found is
  ///   done twice: the first tells better where they are.
  [[nodiscard]] std::optional<PersonLook> search(const cv::Mat& picture, const PersonQuery& query);

  /// One look at that part; nothing where nobody is there.
  [[nodiscard]] std::optional<PersonLook> look(const cv::Mat& picture, const PersonRegion& region);

  /// @param person  who is none of the others; may be nobody.
  /// @return for each of `query.looked` whom it shows, or nothing where they are there no more; then those who are new.
  [[nodiscard]] std::vector<std::optional<PersonLook>> search_others(const cv::Mat& picture, const OthersQuery& query,
                                                                     const std::optional<PersonLook>& person);

 private:
  [[nodiscard]] std::vector<PersonRegion> detected(const cv::Mat& picture, cv::Rect part);
  [[nodiscard]] std::optional<PersonLook> largest(const cv::Mat& picture, const PersonQuery& query,
                                                  const cv::Mat& before);
  [[nodiscard]] std::optional<PersonLook> twice(const cv::Mat& picture, const PersonRegion& region);

  PersonNetwork network_;
  PersonDetector detector_;
  PersonChoice choice_;
  cv::Mat small_;  // The picture before, CV_8UC1.
};

}  // namespace choreo::vision

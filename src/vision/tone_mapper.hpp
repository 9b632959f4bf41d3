// SPDX-License-Identifier: Apache-2.0
// Which tone each pixel shows, at video rate: Bayes' rule in tables.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/tone_model.hpp"

namespace choreo::vision {

/// Posteriors looked up by blue, green and red, 64 steps each: a table of 256 KiB a tone, which a core's second cache
/// holds. A cell's centre stands for its 64 colours. Over all colours that is off by 0.0023 on average, by at most 0.35
/// where a tone ends, and on the wrong side of 0.5 for one colour in 400. Seven bits a channel would halve that, and
/// make a change of light cost eight times as much.
/// @thread reentrant; what changes tones excluded.
class ToneMapper {
 public:
  static constexpr int kBits = 6;  ///< A channel.

  explicit ToneMapper(ToneSet tones);

  /// Takes other tones, or the same in another light. @cost 3 to 5 ms for skin and clothes, no matter how large
  /// pictures are.
  void rebuild(ToneSet tones);

  /// Begins to make the tables of other tones; those in use stay until the new ones are whole. What was begun before
  /// is given up.
  void prepare(ToneSet tones);

  /// Does one of `parts` equal shares of what was begun. @return true where other tones are in use since.
  bool advance(int parts);

  [[nodiscard]] const ToneSet& tones() const { return tones_; }

  /// P(tone | colour) at every pixel, 255 being 1.
  /// @param picture  CV_8UC3, blue green red.
  /// @param mask     CV_8UC1 of its size; the result is 0 where it is 0. Empty: everywhere.
  /// @param tone     a place in `tones().tones` (asserted).
  /// @return CV_8UC1.
  /// @cost 0.2 to 0.5 ms for 640 x 480 on one core.
  [[nodiscard]] cv::Mat posterior(const cv::Mat& picture, const cv::Mat& mask, std::size_t tone) const;

  /// P(any of these tones | colour): the sum. 0 everywhere where none is given.
  [[nodiscard]] cv::Mat posterior(const cv::Mat& picture, const cv::Mat& mask,
                                  std::span<const std::size_t> tones) const;

 private:
  using Tables = std::vector<std::vector<std::uint8_t>>;  // One a tone.
  struct Cells;
  struct Begun {
    ToneSet tones;
    Tables tables;
    std::size_t shell = 0, at = 0;  // Where it goes on.
  };
  void fill(Begun& begun, std::size_t cells) const;

  ToneSet tones_;
  std::shared_ptr<const Cells> cells_;
  Tables tables_;
  std::optional<Begun> begun_;
};

}  // namespace choreo::vision

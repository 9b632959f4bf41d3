// SPDX-License-Identifier: Apache-2.0
// Learns the performer's skin from their face, and what they wear from below.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/face.hpp"
#include "vision/tone_model.hpp"
#include "vision/tone_options.hpp"

namespace choreo::vision {

/// Where skin is looked for in a face, in pixels: cheeks and forehead, without eyes, brows, nose, mouth and hair.
/// Cut at the picture's edge; may be empty.
[[nodiscard]] std::vector<cv::Rect> skin_areas(const TrackedFace& face, cv::Size picture);

/// Where clothes are looked for: the chest below a face, and hips and thighs. May be empty.
[[nodiscard]] std::array<cv::Rect, 2> clothes_areas(const TrackedFace& face, cv::Size picture);

/// Gathers pixels from face after face. The first `learn_s` seconds of face count alike; then the past is forgotten
/// with the time constant `adapt_s`, so that the tone follows the light (where that is 0, the tone stays). A face that
/// suddenly looks otherwise (a hand before it, another person) is left out; one that stays so for two seconds of looks
/// is learned anew. From one look to the next at most 0.2 seconds count, for that and for `learn_s`.
///
/// Arms are not lit as faces are: they are shaded (0.6 to 1.06 times as bright), redder towards the hands and out of
/// the cheeks' light. So the tone that is given out is wider than the face's own: along saturation, across it in hue,
/// and with v that bears on it but weakly.
/// @thread thread-bound
class ToneLearner {
 public:
  explicit ToneLearner(const ToneOptions& options);

  /// @param picture  CV_8UC3.
  /// @param face     in it, seen lately: what has coasted for more than half a second is not looked at.
  /// @param time_s   seconds, increasing.
  /// @param body     CV_8UC1 of the picture's size, 0 where no clothes can be; empty: not known.
  /// @return true where there are other tones than before: `skin` and `clothes` are to be asked.
  bool add(const cv::Mat& picture, const TrackedFace& face, double time_s, const cv::Mat& body = {});

  /// The learned skin, "skin"; nothing until some 60 pixels of face were seen.
  [[nodiscard]] const std::optional<Tone>& skin() const { return skin_; }

  /// The clothes, "clothes"; nothing where they are not to be learned, none are seen, or they cannot be told from skin
  /// (a bare chest: taken for clothes it would take the arms away).
  [[nodiscard]] const std::optional<Tone>& clothes() const { return clothes_; }

  /// Seconds of face that went into the tones, at most `learn_s`: how far the start-up is.
  [[nodiscard]] double learned_s() const { return learned_s_; }

  /// Forgets everybody.
  void reset() { *this = ToneLearner(options_); }

 private:
  // Sums over pixels of (x, y, v), and their histogram.
  struct Gathered {
    double weight = 0;
    cv::Vec3d sum;
    cv::Matx33d squares = cv::Matx33d::zeros();
    std::vector<float> cells;

    void fade(double factor);
    void add(const std::vector<ToneColour>& colours);
    [[nodiscard]] cv::Vec3d mean() const { return sum * (1 / weight); }
    [[nodiscard]] cv::Matx33d covariance() const;
  };

  [[nodiscard]] bool alike(const std::vector<ToneColour>& colours) const;
  void give_out();
  // What the arms of that skin may look like, or the rest of that cloth.
  [[nodiscard]] static GaussianTone::Parameters arms_of(const Gathered& from, double value_share, double noise);
  [[nodiscard]] std::shared_ptr<const ToneModel> model_of(const Gathered& from,
                                                          const GaussianTone::Parameters& parameters) const;

  ToneOptions options_;
  Gathered face_;
  std::array<Gathered, 2> worn_;  // As of `clothes_areas`.
  std::optional<double> last_s_, given_s_;
  std::optional<double> unlike_at_s_;  // The last look that was odd, where the last was.
  double unlike_s_ = 0;
  double learned_s_ = 0;
  std::optional<Tone> skin_, clothes_;
};

}  // namespace choreo::vision

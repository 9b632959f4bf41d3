// SPDX-License-Identifier: Apache-2.0
// The states of a run, of whichever representation, kept until they are compared with one another.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "pipeline/observation.hpp"
#include "similarity/and_count.hpp"
#include "similarity/comparer.hpp"

namespace choreo::cli {

/// One state a row, a gap where a frame has none.
class KeptStates {
 public:
  virtual ~KeptStates() = default;

  /// Takes the observation's state.
  virtual void add(pipeline::Observation& observation) = 0;
  /// Forgets the 2nd, the 4th, ... row.
  virtual void keep_every_second() = 0;
  [[nodiscard]] virtual std::size_t size() const = 0;

  /// What compares them; they are its own then.
  [[nodiscard]] virtual std::unique_ptr<const similarity::Comparer> comparer() = 0;
  /// Of what is compared, in pixels, once `comparer` was made; 0 x 0 where that is no picture.
  [[nodiscard]] virtual cv::Size canvas() const { return {}; }
};

/// Rows of a vector thinned out: those with an even index stay.
template <typename Row>
void keep_every_second(std::vector<Row>& rows) {
  const auto kept = (rows.size() + 1) / 2;
  for (std::size_t k = 1; k < kept; ++k) rows[k] = std::move(rows[2 * k]);
  rows.resize(kept);
}

/// Silhouettes.
class KeptMasks final : public KeptStates {
 public:
  explicit KeptMasks(similarity::AndCountKernel kernel) : kernel_(kernel) {}
  void add(pipeline::Observation& observation) override { states_.push_back(std::move(observation.state)); }
  void keep_every_second() override { cli::keep_every_second(states_); }
  [[nodiscard]] std::size_t size() const override { return states_.size(); }
  [[nodiscard]] std::unique_ptr<const similarity::Comparer> comparer() override;
  [[nodiscard]] cv::Size canvas() const override { return canvas_; }

 private:
  similarity::AndCountKernel kernel_;
  std::vector<std::unique_ptr<const body::MaskState>> states_;
  cv::Size canvas_;
};

/// Faces with two arms.
class KeptParticles final : public KeptStates {
 public:
  void add(pipeline::Observation& observation) override { states_.push_back(observation.particles); }
  void keep_every_second() override { cli::keep_every_second(states_); }
  [[nodiscard]] std::size_t size() const override { return states_.size(); }
  [[nodiscard]] std::unique_ptr<const similarity::Comparer> comparer() override;

 private:
  std::vector<std::optional<body::ParticleState>> states_;
};

}  // namespace choreo::cli

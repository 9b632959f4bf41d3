// SPDX-License-Identifier: Apache-2.0
#include "cli/kept_states.hpp"

#include "similarity/mask_comparer.hpp"
#include "similarity/particle_comparer.hpp"

namespace choreo::cli {

std::unique_ptr<const similarity::Comparer> KeptMasks::comparer() {
  auto comparer = std::make_unique<similarity::MaskComparer>(states_, kernel_);
  canvas_ = comparer->canvas();
  states_.clear();  // The comparer has its own.
  return comparer;
}

std::unique_ptr<const similarity::Comparer> KeptParticles::comparer() {
  auto comparer = std::make_unique<similarity::ParticleComparer>(states_);
  states_.clear();
  return comparer;
}

}  // namespace choreo::cli

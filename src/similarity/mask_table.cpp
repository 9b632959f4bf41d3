// SPDX-License-Identifier: Apache-2.0
#include "similarity/mask_table.hpp"

namespace choreo::similarity {

MaskTable::MaskTable(MaskStates states) : areas(states.size(), 0), remainders(states.size(), 0) {
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (!states[i]) continue;
    const auto& state = *states[i];
    areas[i] = state.area();
    remainders[i] = state.remainder_x();
    const auto box = state.box();
    canvas = canvas.empty() ? box : (canvas | box);
    for (int y = box.y; y < box.y + box.height; ++y) for_each_run(state, state.row(y), [&](int, int) { ++runs; });
  }
  if (!canvas.empty()) {
    canvas.x -= 1;
    canvas.width += 2;
  }
}

}  // namespace choreo::similarity

// SPDX-License-Identifier: Apache-2.0
// What stands and hangs in a room: painted flat onto its wall.
#pragma once

#include <cstdint>

#include "devices/synthetic/room_painter.hpp"

namespace choreo::devices::synthetic {

/// Shelves of books, paintings, a window, a sideboard and a plant: strong edges, colours of every hue.
/// @param seed  of the books.
void clutter(Painter& painter, std::uint64_t seed);

/// A cupboard, a curtain, a door and a table, all in mixtures of the skin tones: cupboard and curtain, behind the right
/// arm, in the performer's own, the door behind the left arm near it.
void furnish_in_wood(Painter& painter);

/// A portrait a quarter larger than the performer's head, up on the wall to the left.
void hang_poster(Painter& painter);

}  // namespace choreo::devices::synthetic

// SPDX-License-Identifier: Apache-2.0
// Survives an X display that goes away.
#pragma once

struct SDL_Window;

namespace choreo::outputs {

inline constexpr const char* kDisplayGone = "the display is gone";

/// Makes a window's broken connection to its X server known to `display_is_lost` instead of ending the process, which
/// is what Xlib does otherwise. Whatever the thread that calls this asks of SDL then throws Error (failure) once. Does
/// nothing for other displays than X11, and where Xlib is older than 1.7.
void survive_display_loss(SDL_Window* window);

/// Whether the connection broke. From then on nothing may be asked of the display, not even to destroy its windows; and
/// its libraries may wait for it for ever as the process ends (Mesa does): end with `std::_Exit`.
/// @thread thread-safe
[[nodiscard]] bool display_is_lost();

}  // namespace choreo::outputs

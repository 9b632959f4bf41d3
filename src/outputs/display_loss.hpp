// SPDX-License-Identifier: Apache-2.0
// Survives an X display that goes away.
#pragma once

struct SDL_Window;

namespace choreo::outputs {

/// Makes a window's broken connection to its X server set `lost` instead of ending the process, which is what Xlib does
/// otherwise. Once it is set nothing more may be asked of the window, not even to be destroyed.
///
/// Does nothing for other displays than X11, and where Xlib is older than 1.7.
/// @param lost  outlives the window; written by the thread that feeds the window.
void survive_display_loss(SDL_Window* window, bool& lost);

}  // namespace choreo::outputs

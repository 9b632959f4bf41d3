// SPDX-License-Identifier: Apache-2.0
#include "outputs/display_loss.hpp"

#include <SDL.h>
#include <SDL_syswm.h>
#include <dlfcn.h>

#include <atomic>
#include <thread>

#include "core/error.hpp"

namespace choreo::outputs {
namespace {

// Of the process: Xlib may call its handler as late as in the last moments of it.
std::atomic<bool> lost = false;

std::thread::id windows;  // The thread that feeds the window.

#ifdef SDL_VIDEO_DRIVER_X11

int say_nothing(Display* /*display*/) { return 0; }

// Xlib would go on, and SDL takes the answers that it gets from then on for real (XGetModifierMapping's null pointer).
// Where the window is fed, the way out leads past both: they are asked nothing any more.
void mark_lost(Display* /*display*/, void* /*data*/) {
  lost = true;
  if (std::this_thread::get_id() == windows) throw failure(kDisplayGone);
}

// SDL loads Xlib at run time, and so do we: a machine without it has no use for it.
template <typename F>
F* of_xlib(const char* name) {
  void* library = ::dlopen("libX11.so.6", RTLD_NOW | RTLD_NOLOAD);
  if (library == nullptr) return nullptr;
  auto* found = reinterpret_cast<F*>(::dlsym(library, name));
  ::dlclose(library);  // SDL has it open as long as there is a window.
  return found;
}

#endif

}  // namespace

bool display_is_lost() { return lost; }

void survive_display_loss(SDL_Window* window) {
#ifdef SDL_VIDEO_DRIVER_X11
  SDL_SysWMinfo info{};
  SDL_VERSION(&info.version)
  if (SDL_GetWindowWMInfo(window, &info) != SDL_TRUE || info.subsystem != SDL_SYSWM_X11) return;
  auto* on_exit = of_xlib<void(Display*, void (*)(Display*, void*), void*)>("XSetIOErrorExitHandler");
  auto* on_error = of_xlib<int (*(int (*)(Display*)))(Display*)>("XSetIOErrorHandler");
  if (on_exit == nullptr || on_error == nullptr) return;
  windows = std::this_thread::get_id();
  on_exit(info.info.x11.display, &mark_lost, nullptr);
  on_error(&say_nothing);
#else
  (void)window;
#endif
}

}  // namespace choreo::outputs

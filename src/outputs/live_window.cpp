// SPDX-License-Identifier: Apache-2.0
#include "outputs/live_window.hpp"

#include <SDL.h>
#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string_view>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"
#include "outputs/display_loss.hpp"
#include "outputs/live_page.hpp"
#include "similarity/scrolling_triangle.hpp"

namespace choreo::outputs {
namespace {

constexpr int kTriangleWidth = 1200;
constexpr double kSpans[] = {5, 10, 30, 60, 120, 300, 600, 1800, 3600};
constexpr double kFirstSpan = 30;
constexpr auto kFrame = std::chrono::milliseconds(33);

struct Destroy {
  void operator()(SDL_Window* w) const { SDL_DestroyWindow(w); }
  void operator()(SDL_Renderer* r) const { SDL_DestroyRenderer(r); }
  void operator()(SDL_Texture* t) const { SDL_DestroyTexture(t); }
};
template <typename T>
using Owned = std::unique_ptr<T, Destroy>;

[[noreturn]] void fail(std::string_view doing) {
  throw failure(fmt::format("{}: {}", doing, SDL_GetError()), {}, "run without a window: --headless");
}

// Keeps a texture as long as its pictures are of one size.
class Picture {
 public:
  void put(SDL_Renderer* renderer, const cv::Mat& bgr) {
    if (!texture_ || size_ != bgr.size()) {
      size_ = bgr.size();
      texture_.reset(
          SDL_CreateTexture(renderer, SDL_PIXELFORMAT_BGR24, SDL_TEXTUREACCESS_STREAMING, size_.width, size_.height));
      if (!texture_) fail("a picture cannot be shown");
      SDL_SetTextureScaleMode(texture_.get(), SDL_ScaleModeLinear);
    }
    SDL_UpdateTexture(texture_.get(), nullptr, bgr.data, static_cast<int>(bgr.step));
  }
  [[nodiscard]] SDL_Texture* get() const { return texture_.get(); }
  [[nodiscard]] cv::Size size() const { return size_; }
  void forget() { texture_.reset(); }
  void abandon() { (void)texture_.release(); }

 private:
  Owned<SDL_Texture> texture_;
  cv::Size size_;
};

SDL_FRect rect_of(const Box& b) { return {float(b.x), float(b.y), float(b.width), float(b.height)}; }

}  // namespace

bool display_is_there() {
  const auto set = [](const char* name) {
    const auto* value = std::getenv(name);
    return value != nullptr && *value != '\0';
  };
  // SDL_Init succeeds without a display, too: it then draws where nobody looks.
  return set("DISPLAY") || set("WAYLAND_DISPLAY") || set("SDL_VIDEODRIVER");
}

class LiveWindow::Impl {
 public:
  explicit Impl(LiveWindowOptions options) : options_(std::move(options)) {
    for (const double span : kSpans) {
      if (span < options_.history_s)
        triangles_.emplace_back(span, kTriangleWidth, live_gap_colour(), live_blank_colour());
    }
    triangles_.emplace_back(options_.history_s, kTriangleWidth, live_gap_colour(), live_blank_colour());
    while (shown_ + 1 < triangles_.size() && triangles_[shown_].span_s() < kFirstSpan) ++shown_;
    span_s_ = triangles_[shown_].span_s();
    // SDL wants its window opened and fed by one thread.
    thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
    std::unique_lock lock(mutex_);
    opened_or_not_.wait(lock, [this] { return opened_ || problem_; });
    if (problem_) std::rethrow_exception(problem_);
  }

  void show(const cv::Mat& picture, const cv::Mat& mask, double time_s, std::span<const float> z,
            std::span<const float> zstar) {
    const std::scoped_lock lock(mutex_);
    picture_ = picture;
    mask_ = mask;
    for (auto& triangle : triangles_) triangle.add_row(time_s, z, zstar);
    fresh_ = true;
  }

  void tell(std::vector<std::string> lines) {
    const std::scoped_lock lock(mutex_);
    lines_ = std::move(lines);
    fresh_lines_ = true;
  }

 private:
  void work(const std::stop_token& stop) {
    pthread_setname_np(pthread_self(), "window");
    try {
      open();
      {
        const std::scoped_lock lock(mutex_);
        opened_ = true;
      }
      opened_or_not_.notify_all();
      while (!stop.stop_requested()) {
        const auto next = std::chrono::steady_clock::now() + kFrame;
        handle_events();
        if (!display_is_lost()) draw();
        if (display_is_lost()) throw failure(kDisplayGone);
        std::this_thread::sleep_until(next);
      }
    } catch (const std::exception& problem) {
      fall(display_is_lost() ? kDisplayGone : problem.what());
    }
    close();
  }

  // Before the window is open its maker is told; later only the window ends, not the run.
  void fall(const std::string& why) {
    {
      const std::scoped_lock lock(mutex_);
      if (!opened_) {
        problem_ = std::current_exception();
        opened_or_not_.notify_all();
        return;
      }
    }
    if (options_.on_lost) options_.on_lost(why);
  }

  void open() {
    // Whoever runs the program handles Ctrl-C; SDL must not.
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    SDL_SetHint(SDL_HINT_VIDEO_ALLOW_SCREENSAVER, "0");
    if (SDL_InitSubSystem(SDL_INIT_VIDEO) != 0) fail("no window can be opened");
    up_ = true;
    const Uint32 flags = SDL_WINDOW_RESIZABLE | SDL_WINDOW_ALLOW_HIGHDPI |
                         (options_.full_screen ? Uint32{SDL_WINDOW_FULLSCREEN_DESKTOP} : 0U);
    window_.reset(
        SDL_CreateWindow(options_.title.c_str(), SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, 1280, 720, flags));
    if (!window_) fail("no window can be opened");
    survive_display_loss(window_.get());
    SDL_SetWindowMinimumSize(window_.get(), 320, 240);
    renderer_.reset(SDL_CreateRenderer(window_.get(), -1, SDL_RENDERER_PRESENTVSYNC));
    if (!renderer_) renderer_.reset(SDL_CreateRenderer(window_.get(), -1, SDL_RENDERER_SOFTWARE));
    if (!renderer_) fail("nothing can be drawn in a window");
    full_screen_ = options_.full_screen;
    if (full_screen_) SDL_ShowCursor(SDL_DISABLE);
  }

  void close() {
    try {
      if (window_ && !display_is_lost()) SDL_PumpEvents();  // A display that is gone is found out by asking it.
    } catch (const Error&) {
    }
    if (display_is_lost()) {
      // Whatever is given back now would ask the display first: it is left to the end of the process.
      for (auto* p : {&page_, &figures_, &video_, &triangle_}) p->abandon();
      (void)renderer_.release();
      (void)window_.release();
      return;
    }
    for (auto* p : {&page_, &figures_, &video_, &triangle_}) p->forget();
    renderer_.reset();
    window_.reset();
    if (up_) SDL_QuitSubSystem(SDL_INIT_VIDEO);
    SDL_TLSCleanup();  // What SDL keeps for each thread that is not its own.
  }

  void handle_events() {
    SDL_Event event;
    while (!display_is_lost() && SDL_PollEvent(&event) != 0) {
      if (event.type == SDL_WINDOWEVENT && event.window.event == SDL_WINDOWEVENT_CLOSE) close_once();
      // Without the user's closing before it, this is SDL's word for a Wayland display that went away.
      if (event.type == SDL_QUIT && !closed_) throw failure(kDisplayGone);
      if (event.type == SDL_RENDER_DEVICE_RESET || event.type == SDL_RENDER_TARGETS_RESET) page_size_ = {};
      if (event.type != SDL_KEYDOWN || event.key.repeat != 0) continue;
      switch (event.key.keysym.sym) {
        case SDLK_q:
        case SDLK_ESCAPE:
          close_once();
          break;
        case SDLK_f:
          full_screen_ = !full_screen_;
          SDL_SetWindowFullscreen(window_.get(), full_screen_ ? Uint32{SDL_WINDOW_FULLSCREEN_DESKTOP} : 0U);
          SDL_ShowCursor(full_screen_ ? SDL_DISABLE : SDL_ENABLE);
          break;
        case SDLK_l:
          if (options_.on_report) options_.on_report();
          break;
        case SDLK_j:
          if (options_.on_joints) options_.on_joints();
          break;
        case SDLK_PLUS:
        case SDLK_EQUALS:
        case SDLK_KP_PLUS:
          change_span(-1);
          break;
        case SDLK_MINUS:
        case SDLK_KP_MINUS:
          change_span(1);
          break;
        default:
          break;
      }
    }
  }

  void close_once() {
    if (!std::exchange(closed_, true) && options_.on_close) options_.on_close();
  }

  void change_span(int by) {
    const std::scoped_lock lock(mutex_);
    shown_ = std::size_t(std::clamp(int(shown_) + by, 0, int(triangles_.size()) - 1));
    page_size_ = {};
    fresh_ = true;
  }

  void draw() {
    int width = 0;
    int height = 0;
    SDL_GetRendererOutputSize(renderer_.get(), &width, &height);
    if (width < 1 || height < 1) return;
    std::optional<std::vector<std::string>> lines;
    {
      const std::scoped_lock lock(mutex_);
      if (fresh_) {
        // A few megabytes: copied under the lock, sent to the display without it.
        triangle_pixels_ = triangles_[shown_].picture();
        picture_now_ = picture_;
        mask_now_ = mask_;
        span_s_ = triangles_[shown_].span_s();
      }
      if (page_size_ != cv::Size(width, height) || fresh_lines_) lines = lines_;
      fresh_lines_ = false;
      new_frame_ = std::exchange(fresh_, false);
    }
    const cv::Size video = picture_now_.empty() ? options_.video : picture_now_.size();
    if (page_size_ != cv::Size(width, height)) {
      page_size_ = {width, height};
      layout_ = live_layout(width, height, video, options_.leading);
      page_.put(renderer_.get(), draw_live_page(layout_, width, height, span_s_));
      new_frame_ = true;
    }
    if (lines) figures_.put(renderer_.get(), draw_live_figures(layout_, *lines));
    if (new_frame_ && !picture_now_.empty()) {
      video_.put(renderer_.get(), picture_now_);
      triangle_.put(renderer_.get(), triangle_pixels_);
    }
    SDL_RenderClear(renderer_.get());
    SDL_RenderCopy(renderer_.get(), page_.get(), nullptr, nullptr);
    if (figures_.get() != nullptr) {
      const SDL_FRect at{float(layout_.figures.x), float(layout_.figures.y), float(figures_.size().width),
                         float(figures_.size().height)};
      SDL_RenderCopyF(renderer_.get(), figures_.get(), nullptr, &at);
    }
    if (!picture_now_.empty()) {
      const auto at = rect_of(layout_.video);
      SDL_RenderCopyF(renderer_.get(), video_.get(), nullptr, &at);
      draw_outline();
      draw_triangle();
    }
    // Only now is anything drawn. Mesa's software renderer writes past its memory where the display went away since it
    // was last asked: it is asked again.
    SDL_PumpEvents();
    if (!display_is_lost()) SDL_RenderPresent(renderer_.get());
  }

  // The borders between body and wall, line by line.
  void draw_outline() {
    if (mask_now_.empty()) return;
    SDL_SetRenderDrawColor(renderer_.get(), 80, 255, 120, 255);
    const auto& box = layout_.video;
    const double sx = box.width / mask_now_.cols;
    const double sy = box.height / mask_now_.rows;
    const auto body = [&](int x, int y) {
      return x >= 0 && y >= 0 && x < mask_now_.cols && y < mask_now_.rows && mask_now_.at<std::uint8_t>(y, x) != 0;
    };
    const auto line = [&](int x0, int y0, int x1, int y1) {
      SDL_RenderDrawLineF(renderer_.get(), float(box.x + x0 * sx), float(box.y + y0 * sy), float(box.x + x1 * sx),
                          float(box.y + y1 * sy));
    };
    for (int y = 0; y <= mask_now_.rows; ++y) {
      for (int x = 0; x <= mask_now_.cols; ++x) {
        const bool here = body(x, y);
        if (here != body(x - 1, y)) line(x, y, x, y + 1);
        if (here != body(x, y - 1)) line(x, y, x + 1, y);
      }
    }
  }

  // The picture cut to its triangle.
  void draw_triangle() {
    const auto& t = layout_.triangle;
    const SDL_Color white{255, 255, 255, 255};
    const SDL_Vertex corners[] = {{{float(t.x), float(t.y + t.height)}, white, {0, 1}},
                                  {{float(t.x + t.width / 2), float(t.y)}, white, {0.5F, 0}},
                                  {{float(t.x + t.width), float(t.y + t.height)}, white, {1, 1}}};
    SDL_RenderGeometry(renderer_.get(), triangle_.get(), corners, 3, nullptr, 0);
  }

  LiveWindowOptions options_;

  std::mutex mutex_;
  std::condition_variable opened_or_not_;
  bool opened_ = false;
  std::exception_ptr problem_;
  cv::Mat picture_, mask_;
  std::vector<similarity::ScrollingTriangle> triangles_;
  std::size_t shown_ = 0;
  std::vector<std::string> lines_;
  bool fresh_ = false;
  bool fresh_lines_ = false;

  // The window's thread's own.
  bool up_ = false;
  bool closed_ = false;
  bool full_screen_ = false;
  bool new_frame_ = false;
  double span_s_ = 0;
  cv::Size page_size_;
  LiveLayout layout_;
  cv::Mat triangle_pixels_, picture_now_, mask_now_;
  Owned<SDL_Window> window_;
  Owned<SDL_Renderer> renderer_;  // Behind the window: destroyed before it.
  Picture page_, figures_, video_, triangle_;
  std::jthread thread_;  // Last: it ends before what it uses.
};

LiveWindow::LiveWindow(LiveWindowOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {}
LiveWindow::~LiveWindow() = default;
void LiveWindow::show(const cv::Mat& picture, const cv::Mat& mask, double time_s, std::span<const float> z,
                      std::span<const float> zstar) {
  impl_->show(picture, mask, time_s, z, zstar);
}
void LiveWindow::tell(std::vector<std::string> lines) { impl_->tell(std::move(lines)); }

}  // namespace choreo::outputs

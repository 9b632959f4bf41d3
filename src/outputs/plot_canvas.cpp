// SPDX-License-Identifier: Apache-2.0
#include "outputs/plot_canvas.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <new>
#include <vector>

#include <fmt/format.h>
#include <pango/pangocairo.h>

#include "core/error.hpp"

namespace choreo::outputs {
namespace {

constexpr const char* kFamily = "DejaVu Sans";

template <auto kRelease>
struct Releaser {
  template <typename T>
  void operator()(T* handle) const {
    kRelease(handle);
  }
};
using Surface = std::unique_ptr<cairo_surface_t, Releaser<cairo_surface_destroy>>;
using Context = std::unique_ptr<cairo_t, Releaser<cairo_destroy>>;
using Pattern = std::unique_ptr<cairo_pattern_t, Releaser<cairo_pattern_destroy>>;
using FontMap = std::unique_ptr<PangoFontMap, Releaser<g_object_unref>>;
using TextContext = std::unique_ptr<PangoContext, Releaser<g_object_unref>>;
using Layout = std::unique_ptr<PangoLayout, Releaser<g_object_unref>>;

void check(cairo_status_t status, const char* doing) {
  if (status != CAIRO_STATUS_SUCCESS) {
    throw failure(fmt::format("cannot {}: {}", doing, cairo_status_to_string(status)));
  }
}

/// Type that is set the same on every machine: a font map of our own, no hinting, no rounding of widths.
class Typesetter {
 public:
  Typesetter() : map_(pango_cairo_font_map_new()), context_(pango_font_map_create_context(map_.get())) {
    pango_cairo_font_map_set_resolution(reinterpret_cast<PangoCairoFontMap*>(map_.get()), 72.0);
    auto* options = cairo_font_options_create();
    cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
    cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    pango_cairo_context_set_font_options(context_.get(), options);
    cairo_font_options_destroy(options);
    pango_context_set_round_glyph_positions(context_.get(), FALSE);
  }

  [[nodiscard]] Layout layout(std::string_view text, double size, bool bold) const {
    Layout layout(pango_layout_new(context_.get()));
    auto* font = pango_font_description_new();
    pango_font_description_set_family_static(font, kFamily);
    pango_font_description_set_weight(font, bold ? PANGO_WEIGHT_BOLD : PANGO_WEIGHT_NORMAL);
    pango_font_description_set_absolute_size(font, size * PANGO_SCALE);
    pango_layout_set_font_description(layout.get(), font);
    pango_font_description_free(font);
    pango_layout_set_single_paragraph_mode(layout.get(), TRUE);
    pango_layout_set_text(layout.get(), text.data(), static_cast<int>(text.size()));
    return layout;
  }

  [[nodiscard]] static double width(PangoLayout* layout) {
    PangoRectangle box;
    pango_layout_get_extents(layout, nullptr, &box);
    return static_cast<double>(box.width) / PANGO_SCALE;
  }

 private:
  FontMap map_;
  TextContext context_;
};

/// A Cairo picture with a copy of the pixels, alpha multiplied in as Cairo has it.
Surface to_surface(const cv::Mat& picture) {
  const bool alpha = picture.type() == CV_8UC4;
  if (!alpha && picture.type() != CV_8UC3) throw failure("a picture in a plot is neither 8-bit BGR nor BGRA");
  Surface surface(
      cairo_image_surface_create(alpha ? CAIRO_FORMAT_ARGB32 : CAIRO_FORMAT_RGB24, picture.cols, picture.rows));
  check(cairo_surface_status(surface.get()), "hold a picture of the plot");
  auto* data = cairo_image_surface_get_data(surface.get());
  const int stride = cairo_image_surface_get_stride(surface.get());
  for (int y = 0; y < picture.rows; ++y) {
    auto* out = reinterpret_cast<std::uint32_t*>(data + static_cast<std::ptrdiff_t>(y) * stride);
    const auto* in = picture.ptr<std::uint8_t>(y);
    for (int x = 0; x < picture.cols; ++x, in += picture.channels()) {
      const std::uint32_t a = alpha ? in[3] : 255;
      const auto times_alpha = [a](std::uint32_t c) { return (c * a + 127) / 255; };
      out[x] = a << 24 | times_alpha(in[2]) << 16 | times_alpha(in[1]) << 8 | times_alpha(in[0]);
    }
  }
  cairo_surface_mark_dirty(surface.get());
  return surface;
}

std::string to_png(cairo_surface_t* surface) {
  std::string bytes;
  const auto append = [](void* to, const unsigned char* data, unsigned length) -> cairo_status_t {
    try {
      static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(data), length);
    } catch (const std::bad_alloc&) {
      return CAIRO_STATUS_NO_MEMORY;
    }
    return CAIRO_STATUS_SUCCESS;
  };
  check(cairo_surface_write_to_png_stream(surface, append, &bytes), "encode a plot as PNG");
  return bytes;
}

std::string base64(std::string_view bytes) {
  std::string text;
  gchar* encoded = g_base64_encode(reinterpret_cast<const guchar*>(bytes.data()), bytes.size());
  text = encoded;
  g_free(encoded);
  return text;
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string hex(Rgb c) {
  const auto byte = [](double v) { return static_cast<int>(std::lround(255.0 * std::clamp(v, 0.0, 1.0))); };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(c.r), byte(c.g), byte(c.b));
}

/// At most a hundredth of a pixel, without trailing zeros.
std::string px(double v) { return fmt::format("{}", std::round(v * 100.0) / 100.0 + 0.0); }

std::string svg_points(std::span<const Point> points) {
  std::string out;
  for (const auto& p : points) out += fmt::format("{}{},{}", out.empty() ? "" : " ", px(p.x), px(p.y));
  return out;
}

}  // namespace

std::string printable(std::string_view text) {
  gchar* valid = g_utf8_make_valid(text.data(), static_cast<gssize>(text.size()));
  std::string out;
  for (gchar* at = valid; *at != '\0'; at = g_utf8_next_char(at)) {
    const gunichar c = g_utf8_get_char(at);
    // XML 1.0 knows neither control characters nor these two.
    const bool bad = g_unichar_iscntrl(c) || c == 0xFFFE || c == 0xFFFF || c == 0x2028 || c == 0x2029;
    out += bad ? " " : std::string(at, static_cast<std::size_t>(g_utf8_next_char(at) - at));
  }
  g_free(valid);
  return out;
}

struct TextMeter::Impl {
  Typesetter type;
};

TextMeter::TextMeter() : impl_(std::make_unique<Impl>()) {}
TextMeter::~TextMeter() = default;

double TextMeter::width(std::string_view text, double size, bool bold) const {
  return Typesetter::width(impl_->type.layout(text, size, bold).get());
}

std::string TextMeter::shortened(std::string_view text, double size, bool bold, double most_px) const {
  // A letter is at least a tenth of an em wide, or it does not matter: a name may be megabytes long.
  const auto hopeless = [&](std::size_t count) { return static_cast<double>(count) * size * 0.1 > most_px; };
  const auto count = g_utf8_strlen(text.data(), static_cast<gssize>(text.size()));
  if (!hopeless(static_cast<std::size_t>(count)) && width(text, size, bold) <= most_px) return std::string(text);
  std::vector<std::string> letters;
  for (std::size_t k = 0; k < text.size();) {
    const auto length = static_cast<std::size_t>(g_utf8_skip[static_cast<guchar>(text[k])]);
    letters.emplace_back(text.substr(k, length));
    k += length;
  }
  const auto with = [&](std::size_t keep) {
    std::string out;
    for (std::size_t k = 0; k < (keep + 1) / 2; ++k) out += letters[k];
    out += "...";
    for (std::size_t k = letters.size() - keep / 2; k < letters.size(); ++k) out += letters[k];
    return out;
  };
  // The most letters that fit, by halving.
  std::size_t fits = 0, too_many = letters.size();
  while (too_many - fits > 1) {
    const std::size_t keep = (fits + too_many) / 2;
    (!hopeless(keep) && width(with(keep), size, bold) <= most_px ? fits : too_many) = keep;
  }
  return with(fits);
}

struct PixelCanvas::Impl {
  Typesetter type;
  Surface surface;
  Context cairo;

  /// Of the 256 shades there are the nearest, as a picture has it; Cairo would cut off.
  void color(Rgb c) const {
    const auto shade = [](double v) { return std::round(v * 255.0) / 255.0; };
    cairo_set_source_rgb(cairo.get(), shade(c.r), shade(c.g), shade(c.b));
  }
  void path(std::span<const Point> points, bool closed) const {
    cairo_new_path(cairo.get());
    for (const auto& p : points) cairo_line_to(cairo.get(), p.x, p.y);
    if (closed) cairo_close_path(cairo.get());
  }
};

PixelCanvas::PixelCanvas(int width, int height) : impl_(std::make_unique<Impl>()) {
  impl_->surface.reset(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height));
  check(cairo_surface_status(impl_->surface.get()), "make the page of a plot");
  impl_->cairo.reset(cairo_create(impl_->surface.get()));
  check(cairo_status(impl_->cairo.get()), "draw a plot");
}

PixelCanvas::~PixelCanvas() = default;

void PixelCanvas::fill(const Box& box, Rgb color) {
  impl_->color(color);
  cairo_rectangle(impl_->cairo.get(), box.x, box.y, box.width, box.height);
  cairo_fill(impl_->cairo.get());
}

void PixelCanvas::stroke(std::span<const Point> points, bool closed, double width, Rgb color) {
  impl_->color(color);
  impl_->path(points, closed);
  cairo_set_line_width(impl_->cairo.get(), width);
  cairo_stroke(impl_->cairo.get());
}

void PixelCanvas::image(const cv::Mat& picture, const Box& box, Scaling scaling, std::span<const Point> clip) {
  const auto surface = to_surface(picture);
  auto* cairo = impl_->cairo.get();
  cairo_save(cairo);
  if (!clip.empty()) {
    impl_->path(clip, true);
    cairo_clip(cairo);
  }
  cairo_translate(cairo, box.x, box.y);
  cairo_scale(cairo, box.width / picture.cols, box.height / picture.rows);
  const Pattern pattern(cairo_pattern_create_for_surface(surface.get()));
  cairo_pattern_set_filter(pattern.get(), scaling == Scaling::kCrisp ? CAIRO_FILTER_NEAREST : CAIRO_FILTER_GOOD);
  // Without this the rim of an enlarged picture fades into what is behind it.
  cairo_pattern_set_extend(pattern.get(), CAIRO_EXTEND_PAD);
  cairo_set_source(cairo, pattern.get());
  cairo_rectangle(cairo, 0, 0, picture.cols, picture.rows);
  cairo_fill(cairo);
  cairo_restore(cairo);
}

void PixelCanvas::text(Point at, std::string_view text, const TextStyle& style) {
  auto* cairo = impl_->cairo.get();
  const auto layout = impl_->type.layout(text, style.size, style.bold);
  const double width = Typesetter::width(layout.get());
  const double shift = style.anchor == Anchor::kStart ? 0.0 : style.anchor == Anchor::kEnd ? -width : -width / 2.0;
  cairo_save(cairo);
  impl_->color(style.color);
  cairo_translate(cairo, at.x, at.y);
  if (style.upwards) cairo_rotate(cairo, -std::acos(0.0));
  cairo_move_to(cairo, shift, -static_cast<double>(pango_layout_get_baseline(layout.get())) / PANGO_SCALE);
  pango_cairo_show_layout(cairo, layout.get());
  cairo_restore(cairo);
}

cv::Mat PixelCanvas::bgr() const {
  check(cairo_status(impl_->cairo.get()), "draw a plot");
  auto* surface = impl_->surface.get();
  cairo_surface_flush(surface);
  cv::Mat out(cairo_image_surface_get_height(surface), cairo_image_surface_get_width(surface), CV_8UC3);
  const auto* data = cairo_image_surface_get_data(surface);
  const int stride = cairo_image_surface_get_stride(surface);
  for (int y = 0; y < out.rows; ++y) {
    const auto* in = reinterpret_cast<const std::uint32_t*>(data + static_cast<std::ptrdiff_t>(y) * stride);
    auto* line = out.ptr<cv::Vec3b>(y);
    for (int x = 0; x < out.cols; ++x) {
      line[x] = {static_cast<std::uint8_t>(in[x]), static_cast<std::uint8_t>(in[x] >> 8),
                 static_cast<std::uint8_t>(in[x] >> 16)};
    }
  }
  return out;
}

std::string PixelCanvas::png() const {
  check(cairo_status(impl_->cairo.get()), "draw a plot");
  return to_png(impl_->surface.get());
}

SvgCanvas::SvgCanvas(int width, int height)
    : body_(fmt::format("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" "
                        "width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
                        "font-family=\"{2}, Verdana, sans-serif\">\n",
                        width, height, kFamily)) {}

void SvgCanvas::fill(const Box& box, Rgb color) {
  body_ += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>\n", px(box.x), px(box.y),
                       px(box.width), px(box.height), hex(color));
}

void SvgCanvas::stroke(std::span<const Point> points, bool closed, double width, Rgb color) {
  body_ += fmt::format("<poly{} points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"/>\n",
                       closed ? "gon" : "line", svg_points(points), hex(color), px(width));
}

void SvgCanvas::image(const cv::Mat& picture, const Box& box, Scaling scaling, std::span<const Point> clip) {
  std::string attributes;
  if (!clip.empty()) {
    const auto id = fmt::format("clip{}", ++clips_);
    body_ += fmt::format("<clipPath id=\"{}\"><polygon points=\"{}\"/></clipPath>\n", id, svg_points(clip));
    attributes += fmt::format(" clip-path=\"url(#{})\"", id);
  }
  // The first is for old readers (CSS images, level 3, fallback), the second for today's.
  if (scaling == Scaling::kCrisp) {
    attributes += " image-rendering=\"optimizeSpeed\" style=\"image-rendering:pixelated\"";
  }
  const auto surface = to_surface(picture);
  body_ += fmt::format(
      "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\"{} "
      "xlink:href=\"data:image/png;base64,{}\"/>\n",
      px(box.x), px(box.y), px(box.width), px(box.height), attributes, base64(to_png(surface.get())));
}

void SvgCanvas::text(Point at, std::string_view text, const TextStyle& style) {
  static constexpr const char* kAnchors[] = {"start", "middle", "end"};
  std::string attributes;
  if (style.bold) attributes += " font-weight=\"bold\"";
  if (style.upwards) attributes += fmt::format(" transform=\"rotate(-90 {} {})\"", px(at.x), px(at.y));
  body_ += fmt::format("<text x=\"{}\" y=\"{}\" font-size=\"{}\" fill=\"{}\" text-anchor=\"{}\"{}>{}</text>\n",
                       px(at.x), px(at.y), px(style.size), hex(style.color), kAnchors[static_cast<int>(style.anchor)],
                       attributes, escaped(text));
}

std::string SvgCanvas::svg() const { return body_ + "</svg>\n"; }

}  // namespace choreo::outputs

// SPDX-License-Identifier: Apache-2.0
#include "devices/take/plane_packing.hpp"

#include <array>
#include <cstring>

#include "devices/fourcc.hpp"

namespace choreo::devices::take {
namespace {

// Where in a group of four bytes, for two pixels, the two lumas and the two colours stand.
struct Places {
  int y0, u, y1, v;
};

Places places_of(std::uint32_t fourcc) {
  if (fourcc == kUyvy) return {1, 0, 3, 2};
  if (fourcc == kYvyu) return {0, 3, 2, 1};
  return {0, 1, 2, 3};
}

// Where in three bytes blue, green and red stand.
std::array<int, 3> bgr_places(std::uint32_t fourcc) {
  return fourcc == kRgb3 ? std::array{2, 1, 0} : std::array{0, 1, 2};
}

std::uint8_t* line(const AVFrame& frame, int plane, int y) {
  return frame.data[plane] + std::ptrdiff_t{y} * frame.linesize[plane];
}

}  // namespace

AVPixelFormat planes_for(std::uint32_t fourcc, AVPixelFormat bgr) {
  switch (fourcc) {
    case kBgr3:
    case kRgb3:
      return bgr;
    case kYuyv:
    case kUyvy:
    case kYvyu:
      return AV_PIX_FMT_YUV422P;
    case kNv12:
      return AV_PIX_FMT_YUV420P;
    case kGrey:
      return AV_PIX_FMT_GRAY8;
    case kZ16:
    case kKinectDepth:
      return AV_PIX_FMT_GRAY16LE;
    default:
      return AV_PIX_FMT_NONE;
  }
}

void to_planes(const Layout& layout, const std::uint8_t* bytes, AVFrame& frame) {
  const int width = layout.size.width;
  const int height = layout.size.height;
  const auto* end = bytes + layout.stride * std::size_t(height);
  const auto source = [&](int y) { return bytes + layout.stride * std::size_t(y); };
  switch (frame.format) {
    case AV_PIX_FMT_YUV422P: {
      const auto at = places_of(layout.fourcc);
      for (int y = 0; y < height; ++y) {
        const auto* from = source(y);
        auto* luma = line(frame, 0, y);
        auto* u = line(frame, 1, y);
        auto* v = line(frame, 2, y);
        for (int x = 0; x < width / 2; ++x, from += 4) {
          luma[2 * x] = from[at.y0];
          luma[2 * x + 1] = from[at.y1];
          u[x] = from[at.u];
          v[x] = from[at.v];
        }
      }
      return;
    }
    case AV_PIX_FMT_YUV420P:
      for (int y = 0; y < height; ++y) std::memcpy(line(frame, 0, y), source(y), std::size_t(width));
      for (int y = 0; y < height / 2; ++y) {
        const auto* from = end + layout.stride * std::size_t(y);
        auto* u = line(frame, 1, y);
        auto* v = line(frame, 2, y);
        for (int x = 0; x < width / 2; ++x) {
          u[x] = from[2 * x];
          v[x] = from[2 * x + 1];
        }
      }
      return;
    case AV_PIX_FMT_GBRP: {
      const auto at = bgr_places(layout.fourcc);
      for (int y = 0; y < height; ++y) {
        const auto* from = source(y);
        auto* green = line(frame, 0, y);
        auto* blue = line(frame, 1, y);
        auto* red = line(frame, 2, y);
        for (int x = 0; x < width; ++x, from += 3) {
          blue[x] = from[at[0]];
          green[x] = from[at[1]];
          red[x] = from[at[2]];
        }
      }
      return;
    }
    case AV_PIX_FMT_BGR0: {
      const auto at = bgr_places(layout.fourcc);
      for (int y = 0; y < height; ++y) {
        const auto* from = source(y);
        auto* to = line(frame, 0, y);
        for (int x = 0; x < width; ++x, from += 3, to += 4) {
          to[0] = from[at[0]];
          to[1] = from[at[1]];
          to[2] = from[at[2]];
          to[3] = 0;
        }
      }
      return;
    }
    default: {
      const auto width_bytes = dense_layout(layout.fourcc, layout.size).stride;
      for (int y = 0; y < height; ++y) std::memcpy(line(frame, 0, y), source(y), width_bytes);
    }
  }
}

std::vector<std::uint8_t> from_planes(const AVFrame& frame, std::uint32_t fourcc) {
  const int width = frame.width;
  const int height = frame.height;
  const auto layout = dense_layout(fourcc, {width, height});
  std::vector<std::uint8_t> bytes(bytes_of(layout));
  const auto target = [&](int y) { return bytes.data() + layout.stride * std::size_t(y); };
  switch (frame.format) {
    case AV_PIX_FMT_YUV422P: {
      const auto at = places_of(fourcc);
      for (int y = 0; y < height; ++y) {
        auto* to = target(y);
        const auto* luma = line(frame, 0, y);
        const auto* u = line(frame, 1, y);
        const auto* v = line(frame, 2, y);
        for (int x = 0; x < width / 2; ++x, to += 4) {
          to[at.y0] = luma[2 * x];
          to[at.y1] = luma[2 * x + 1];
          to[at.u] = u[x];
          to[at.v] = v[x];
        }
      }
      break;
    }
    case AV_PIX_FMT_YUV420P:
      for (int y = 0; y < height; ++y) std::memcpy(target(y), line(frame, 0, y), std::size_t(width));
      for (int y = 0; y < height / 2; ++y) {
        auto* to = target(height + y);
        const auto* u = line(frame, 1, y);
        const auto* v = line(frame, 2, y);
        for (int x = 0; x < width / 2; ++x) {
          to[2 * x] = u[x];
          to[2 * x + 1] = v[x];
        }
      }
      break;
    case AV_PIX_FMT_GBRP: {
      const auto at = bgr_places(fourcc);
      for (int y = 0; y < height; ++y) {
        auto* to = target(y);
        const auto* green = line(frame, 0, y);
        const auto* blue = line(frame, 1, y);
        const auto* red = line(frame, 2, y);
        for (int x = 0; x < width; ++x, to += 3) {
          to[at[0]] = blue[x];
          to[at[1]] = green[x];
          to[at[2]] = red[x];
        }
      }
      break;
    }
    case AV_PIX_FMT_BGR0: {
      const auto at = bgr_places(fourcc);
      for (int y = 0; y < height; ++y) {
        auto* to = target(y);
        const auto* from = line(frame, 0, y);
        for (int x = 0; x < width; ++x, to += 3, from += 4) {
          to[at[0]] = from[0];
          to[at[1]] = from[1];
          to[at[2]] = from[2];
        }
      }
      break;
    }
    default:
      for (int y = 0; y < height; ++y) std::memcpy(target(y), line(frame, 0, y), layout.stride);
  }
  return bytes;
}

}  // namespace choreo::devices::take

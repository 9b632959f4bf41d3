// SPDX-License-Identifier: Apache-2.0
#include "devices/kinect_dump/kinect_dump.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "devices/fourcc.hpp"
#include "devices/kinect_dump/dump_index.hpp"
#include "devices/media/kinect_depth.hpp"

namespace choreo::devices {
namespace {

using kinect_dump::Index;
using kinect_dump::Picture;

constexpr std::string_view kColourHeader = "P6 640 480 255\n";
constexpr std::string_view kDepthHeader = "P5 640 480 65535\n";
constexpr std::size_t kMostIndexBytes = std::size_t{1} << 28U;  // Of a whole day: 180 MB.
constexpr std::size_t kNoDepth = std::numeric_limits<std::size_t>::max();
constexpr const char* kWhatIsADump =
    "give a folder that holds INDEX.txt and the pictures it names, as fakenect-record writes it";

std::string path_in(const std::string& folder, const std::string& name) {
  return (std::filesystem::path(folder) / name).string();
}

// An open file that ends with its scope.
class File {
 public:
  // Not blocking: a pipe of that name would wait for its writer for ever.
  explicit File(const std::string& path) : fd_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {
    if (fd_ < 0) {
      trouble_ = std::generic_category().message(errno);
    } else if (struct ::stat status{}; ::fstat(fd_, &status) != 0 || !S_ISREG(status.st_mode)) {
      trouble_ = "not a file";
    } else {
      bytes_ = static_cast<std::size_t>(status.st_size);
    }
  }
  ~File() {
    if (fd_ >= 0) ::close(fd_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }
  // @return how many there were, up to as many as fit.
  [[nodiscard]] std::size_t read(std::span<char> into) const {
    std::size_t have = 0;
    while (have < into.size()) {
      const auto got = ::read(fd_, into.data() + have, into.size() - have);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      have += static_cast<std::size_t>(got);
    }
    return have;
  }

 private:
  int fd_;
  std::size_t bytes_ = 0;
  std::string trouble_;
};

// Fills `pixels` from a picture of exactly that many bytes. @return what is wrong with it; empty where nothing is.
std::string read_picture(const std::string& path, std::string_view header, std::span<std::uint8_t> pixels) {
  const File file(path);
  if (!file.trouble().empty()) return file.trouble();
  const auto whole = header.size() + pixels.size();
  if (file.bytes() != whole) return fmt::format("{} bytes instead of {}", file.bytes(), whole);
  std::string begin(header.size(), '\0');
  if (file.read(begin) != begin.size() || begin != header) {
    return fmt::format("does not begin with \"{}\"", header.substr(0, header.size() - 1));
  }
  if (file.read({reinterpret_cast<char*>(pixels.data()), pixels.size()}) != pixels.size()) return "it ends too early";
  return {};
}

std::string read_index(const std::string& folder, const std::string& path) {
  const File file(path);
  if (!file.trouble().empty()) {
    throw usage_error(fmt::format("\"{}\" is no Kinect's dump: INDEX.txt: {}", folder, file.trouble()), {},
                      kWhatIsADump);
  }
  if (file.bytes() > kMostIndexBytes) {
    throw usage_error(fmt::format("\"{}\" has {} bytes: no index is that long", path, file.bytes()), {}, kWhatIsADump);
  }
  std::string text(file.bytes(), '\0');
  text.resize(file.read(text));
  return text;
}

enum class DepthView { kRegistered, kRaw, kOff };

class KinectDump final : public Source {
 public:
  KinectDump(const std::string& text, const std::string& folder, DepthView view, bool keep_raw)
      : folder_(folder), view_(view), keep_raw_(keep_raw) {
    const auto path = path_in(folder, "INDEX.txt");
    index_ = kinect_dump::parse_index(read_index(folder, path), path);
    if (index_.colour.empty()) {
      throw usage_error(fmt::format("\"{}\" names no colour picture", path), {}, kWhatIsADump);
    }
    if (view_ == DepthView::kOff || index_.depth.empty()) {
      for (std::size_t k = 0; k < index_.colour.size(); ++k) frames_.emplace_back(k, kNoDepth);
    } else {
      frames_ = kinect_dump::pairs_by_time(index_);
      if (frames_.empty()) {
        throw usage_error(fmt::format("\"{}\": no colour picture has a depth picture of its time", path), {},
                          "depth=off reads the colour alone");
      }
    }
    waiting_ = next_readable();
    if (!waiting_) {
      throw usage_error(fmt::format("\"{}\" holds no picture that can be read", folder), {},
                        fmt::format("the first is \"{}\": {}", first_unreadable_, first_reason_));
    }
    info_.name = text;
    info_.size = kKinectSize;
    info_.nominal_fps = kKinectFps;
    info_.depth = view_ != DepthView::kOff && !index_.depth.empty();
    info_.registers_depth = view_ == DepthView::kRegistered;
    info_.duration = index_.colour[frames_.back().first].time - index_.colour[frames_.front().first].time +
                     from_seconds(1.0 / kKinectFps);
  }

  [[nodiscard]] const SourceInfo& info() const override { return info_; }

  FramePtr read(std::stop_token stop) override {
    if (stop.stop_requested()) return nullptr;
    return waiting_ ? std::exchange(waiting_, nullptr) : next_readable();
  }

  [[nodiscard]] std::vector<std::string> warnings() const override {
    std::vector<std::string> all;
    const auto tell = [&](std::size_t count, std::string_view one, std::string_view many) {
      if (count > 0) {
        all.push_back(fmt::format("dump \"{}\": {} {} left out", folder_, count, count == 1 ? one : many));
      }
    };
    if (index_.cut_off)
      all.push_back(fmt::format("dump \"{}\": INDEX.txt ends within a line: it was cut off", folder_));
    tell(index_.late, "picture whose time is not after that of the one before was",
         "pictures whose time is not after that of the one before were");
    tell(index_.colour.size() - frames_.size(), "colour picture without a depth picture of its time was",
         "colour pictures without a depth picture of their time were");
    tell(unreadable_, "frame that could not be read was", "frames that could not be read were");
    if (unreadable_ > 0) all.back() += fmt::format(", the first \"{}\": {}", first_unreadable_, first_reason_);
    return all;
  }

 private:
  FramePtr next_readable() {
    while (next_ < frames_.size()) {
      const auto [colour, depth] = frames_[next_++];
      if (auto frame = make_frame(colour, depth)) return frame;
    }
    return nullptr;
  }

  FramePtr make_frame(std::size_t colour, std::size_t depth) {
    auto frame = std::make_shared<Frame>();
    frame->sequence = colour;
    frame->device_time = index_.colour[colour].time;
    cv::Mat rgb(kKinectSize, CV_8UC3);
    if (!good(index_.colour[colour], kColourHeader, {rgb.data, rgb.total() * 3})) return nullptr;
    cv::cvtColor(rgb, frame->bgr, cv::COLOR_RGB2BGR);
    if (depth == kNoDepth) return frame;
    auto words = std::make_shared<RawPicture>();
    words->fourcc = kKinectDepth;
    words->size = kKinectSize;
    words->bytes.resize(rgb.total() * 2);
    if (!good(index_.depth[depth], kDepthHeader, words->bytes)) return nullptr;
    frame->depth = kinect_depth(words->bytes);
    if (view_ == DepthView::kRegistered) frame->depth = kinect_registered(frame->depth);
    if (keep_raw_) frame->raw_depth = std::move(words);
    return frame;
  }

  bool good(const Picture& picture, std::string_view header, std::span<std::uint8_t> pixels) {
    auto reason = read_picture(path_in(folder_, picture.name), header, pixels);
    if (reason.empty()) return true;
    if (unreadable_++ == 0) {
      first_unreadable_ = picture.name;
      first_reason_ = std::move(reason);
    }
    return false;
  }

  std::string folder_;
  DepthView view_;
  bool keep_raw_;
  Index index_;
  std::vector<std::pair<std::size_t, std::size_t>> frames_;  // Places in the index: colour, depth or kNoDepth.
  SourceInfo info_;
  std::size_t next_ = 0;
  FramePtr waiting_;
  std::size_t unreadable_ = 0;
  std::string first_unreadable_;
  std::string first_reason_;
};

bool claims(const std::string& path) {
  const File file(path_in(path, "INDEX.txt"));
  if (!file.trouble().empty()) return false;
  std::string beginning(256, '\0');
  beginning.resize(file.read(beginning));
  return kinect_dump::looks_like_index(beginning);
}

}  // namespace

Driver kinect_dump_driver() {
  Driver driver;
  driver.scheme = "kinect-dump";
  driver.example = "kinect-dump:take/?depth=raw";
  driver.summary = "a folder that fakenect-record made of a Kinect v1";
  driver.open = [](const SourceUri& uri, SettingReader& settings, const OpenOptions& options) {
    static const std::vector<std::string> kViews = {"registered", "raw", "off"};
    const auto view = settings.take_choice("depth", "registered", kViews);
    settings.refuse_the_rest();
    return std::make_unique<KinectDump>(
        uri.text, uri.location,
        view == "off" ? DepthView::kOff : (view == "raw" ? DepthView::kRaw : DepthView::kRegistered), options.keep_raw);
  };
  driver.claims = claims;
  return driver;
}

}  // namespace choreo::devices

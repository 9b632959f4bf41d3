// SPDX-License-Identifier: Apache-2.0
#include "devices/image_folder/image_folder.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "core/text.hpp"
#include "devices/image_folder/numbered_names.hpp"
#include "devices/media/still_picture.hpp"

namespace choreo::devices {
namespace {

constexpr const char* kWhatIsAFolder = "give a folder of numbered png, jpg, bmp, tif, webp, pgm or ppm pictures";

std::vector<std::string> picture_names(const std::string& folder) {
  std::error_code problem;
  std::vector<std::string> names;
  std::filesystem::directory_iterator entry(folder, problem);
  for (; !problem && entry != std::filesystem::directory_iterator(); entry.increment(problem)) {
    std::error_code ignored;  // What cannot be looked at is no picture: a broken link, a pipe.
    const auto name = entry->path().filename().string();
    if (is_picture_name(name) && entry->is_regular_file(ignored)) names.push_back(name);
  }
  if (problem) {
    throw usage_error(fmt::format("folder \"{}\" cannot be read: {}", folder, problem.message()), {}, kWhatIsAFolder);
  }
  return names;
}

struct OrderedNames {
  std::vector<std::string> names;
  bool stills = false;
};

// A sequence where the names count on in one number, a set where they do not and a set may be.
OrderedNames in_order(std::vector<std::string> names, const std::string& folder, std::optional<bool> stills,
                      bool sets_allowed) {
  if (stills == true) return {in_name_order(std::move(names)), true};
  const bool may_be_set = sets_allowed && !stills;
  if (may_be_set && names.size() == 1) return {std::move(names), true};  // One picture alone moves nowhere.
  try {
    return {in_number_order(names, folder), false};
  } catch (const Error& error) {
    if (!may_be_set && stills) throw;
    if (!may_be_set) {
      throw usage_error(error.what(), {},
                        fmt::format("{}; the letters of a set of pictures are read by choreoscope analyze DIR "
                                    "--recognise semaphore",
                                    error.hint()));
    }
  }
  return {in_name_order(std::move(names)), true};
}

bool is_picture_file(const std::string& path) {
  std::error_code problem;
  return is_picture_name(std::filesystem::path(path).filename().string()) &&
         std::filesystem::is_regular_file(path, problem);
}

class ImageFolder final : public Source {
 public:
  ImageFolder(const SourceUri& uri, double fps, std::optional<bool> stills, bool sets_allowed)
      : folder_(uri.location), micro_fps_(std::llround(fps * 1e6)) {
    OrderedNames ordered;
    if (sets_allowed && stills.value_or(true) && is_picture_file(folder_)) {
      const std::filesystem::path file(folder_);
      ordered = {{file.filename().string()}, true};
      folder_ = file.parent_path().string();
    } else {
      ordered = in_order(picture_names(folder_), folder_, stills, sets_allowed);
    }
    names_ = std::move(ordered.names);
    info_.stills = ordered.stills;
    info_.numbered_pictures = !ordered.stills && !stills;
    if (names_.empty()) {
      throw usage_error(fmt::format("folder \"{}\" holds no pictures", folder_), {}, kWhatIsAFolder);
    }
    // Only decoding tells the size.
    find_next();
    if (waiting_.empty()) {
      throw usage_error(names_.size() == 1
                            ? fmt::format("\"{}\": its one picture cannot be read", uri.location)
                            : fmt::format("folder \"{}\": none of its {} pictures can be read", folder_, names_.size()),
                        {}, fmt::format("the first is \"{}\"", names_.front()));
    }
    info_.name = uri.text;
    info_.size = waiting_.size();
    info_.nominal_fps = fps;
    info_.duration = time_of(names_.size());
    info_.repeatable = true;
  }

  const SourceInfo& info() const override { return info_; }

  FramePtr read(std::stop_token stop) override {
    if (stop.stop_requested()) return nullptr;
    if (waiting_.empty()) find_next();
    if (waiting_.empty()) return nullptr;
    const auto index = next_ - 1;
    if (waiting_.size() != info_.size && !info_.stills) {
      const auto size = waiting_.size();
      waiting_.release();
      next_ = names_.size();
      throw failure(fmt::format("\"{}\" is {}x{}, but the pictures before it are {}x{}",
                                (std::filesystem::path(folder_) / names_[index]).string(), size.width, size.height,
                                info_.size.width, info_.size.height),
                    {}, "bring all pictures of the folder to one size");
    }
    auto frame = std::make_shared<Frame>();
    frame->sequence = index;
    frame->device_time = time_of(index);
    frame->bgr = std::move(waiting_);
    frame->name = names_[index];
    waiting_ = cv::Mat();
    return frame;
  }

  std::vector<std::string> warnings() const override {
    if (unreadable_ == 0) return {};
    return {fmt::format("folder \"{}\": {} of {} could not be read and {} left out, the first \"{}\"", folder_,
                        unreadable_, counted(names_.size(), "picture"), unreadable_ == 1 ? "was" : "were",
                        first_unreadable_)};
  }

 private:
  // Index over rate, to the nearest nanosecond, in whole numbers: doubles would drift off by one after hours.
  Nanoseconds time_of(std::size_t index) const {
    const auto micro = static_cast<long long>(index) * 1'000'000;
    const auto rest = micro % micro_fps_;  // Below 10^9, so that nothing overflows.
    return std::chrono::seconds(micro / micro_fps_) + Nanoseconds((rest * 1'000'000'000 + micro_fps_ / 2) / micro_fps_);
  }

  // Puts the next readable picture into `waiting_`, or leaves it empty at the end.
  void find_next() {
    while (next_ < names_.size() && waiting_.empty()) {
      const auto& name = names_[next_++];
      std::ifstream file(std::filesystem::path(folder_) / name, std::ios::binary);
      const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
      waiting_ = decode_picture(bytes);
      if (waiting_.empty() && unreadable_++ == 0) first_unreadable_ = name;
    }
  }

  std::string folder_;
  long long micro_fps_;
  std::vector<std::string> names_;
  SourceInfo info_;
  std::size_t next_ = 0;
  cv::Mat waiting_;
  std::size_t unreadable_ = 0;
  std::string first_unreadable_;
};

}  // namespace

Driver image_folder_driver() {
  Driver driver;
  driver.scheme = "folder";
  driver.example = "pictures/?fps=25";
  driver.summary = "a folder of numbered pictures, or a set of pictures";
  driver.claims_as_set = is_picture_file;
  driver.open = [](const SourceUri& uri, SettingReader& settings, const OpenOptions& options) {
    const double fps = settings.take_number("fps", 30.0, 0.01, 1000.0);
    std::optional<bool> stills;
    if (uri.settings.contains("stills")) stills = settings.take_flag("stills", false);
    settings.refuse_the_rest();
    if (stills == true && !options.sets) {
      throw usage_error(fmt::format("folder \"{}\" as a set of pictures has no order in time", uri.location),
                        "stills=1", "read its letters with analyze --recognise semaphore, or leave stills=1 out");
    }
    return std::make_unique<ImageFolder>(uri, fps, stills, options.sets);
  };
  return driver;
}

}  // namespace choreo::devices

// SPDX-License-Identifier: Apache-2.0
#include "architecture/layers.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <regex>
#include <stdexcept>
#include <string_view>

namespace choreo::architecture {
namespace {

namespace fs = std::filesystem;

struct Layer {
  std::string_view folder;
  int height;
  bool mathematics = false;
};

constexpr std::array kLayers = {
    Layer{"src/cli", 12},
    Layer{"config", 11},
    Layer{"src/outputs", 10},
    Layer{"pipeline", 9},
    Layer{"devices/media", 7},
    Layer{"devices", 6},
    Layer{"src/recognition", 5, true},
    Layer{"src/motion", 5, true},
    Layer{"src/similarity", 4, true},
    Layer{"src/body", 3, true},
    Layer{"src/vision", 2, true},
    Layer{"src/core", 1, true},
};
constexpr std::array kTops = {"src", "devices", "pipeline", "config", "tests", "bench"};
constexpr int kMostLines = 500;
constexpr std::string_view kFirstLine = "// SPDX-License-Identifier: Apache-2.0";

// Where a file stands: its layer, with the driver's folder where it is one. Drivers stand on what they share.
struct Place {
  std::string folder;
  int height;
  bool mathematics;
};

std::optional<Place> place_of(const std::string& file) {
  for (const auto& layer : kLayers) {
    const auto prefix = std::string(layer.folder) + "/";
    if (!file.starts_with(prefix)) continue;
    const auto rest = file.substr(prefix.size());
    if (layer.folder == "devices" && rest.find('/') != std::string::npos) {
      return Place{prefix + rest.substr(0, rest.find('/')), layer.height + 2, false};
    }
    return Place{std::string(layer.folder), layer.height, layer.mathematics};
  }
  return std::nullopt;
}

bool may_be_used_by_devices(const std::string& file) {
  return file.starts_with("src/core/") || file.starts_with("src/body/figure.") ||
         file.starts_with("src/body/semaphore_signs.");
}

// The rule that an include breaks; empty where it breaks none.
std::string broken_rule(const Place& from, const std::string& target) {
  const auto to = place_of(target);
  if (!to) return "nothing includes " + target.substr(0, target.find('/')) + "/";
  if (from.folder == to->folder) return {};
  if (from.folder.starts_with("devices") && target.starts_with("src/") && !may_be_used_by_devices(target)) {
    return "of src, devices use core and body's figure and semaphore signs alone, not " + target;
  }
  if (from.height > to->height) return {};
  if (from.height == to->height) return from.folder + " and " + to->folder + " never include each other";
  return from.folder + " lies below " + to->folder + ": includes go downwards only";
}

// The tree's file that an include names; nothing where it is none of the tree's.
std::optional<std::string> resolved(const fs::path& root, const std::string& name) {
  for (const auto* base : {"src/", ""}) {
    if (fs::exists(root / (base + name))) return base + name;
  }
  return std::nullopt;
}

struct Forbidden {
  const char* pattern;
  const char* name;
};

// In the mathematics. Whole words, so that std::this_thread is found and "threads" in a comment is not.
constexpr std::array kForbidden = {
    Forbidden{R"(#\s*include\s*<(thread|mutex|shared_mutex|condition_variable|future|barrier|latch|semaphore)>)",
              "threads and locks"},
    Forbidden{R"(\bstd::(jthread|thread|mutex|this_thread)\b)", "threads and locks"},
    Forbidden{R"(#\s*include\s*<(fstream|filesystem|cstdio|stdio\.h|fcntl\.h|unistd\.h)>)", "files"},
    Forbidden{R"(_clock::now\b)", "clocks"},
    Forbidden{R"(#\s*include\s*<(sys/socket\.h|netinet/.*|arpa/.*|netdb\.h|boost/(asio|beast).*)>)", "sockets"},
    Forbidden{R"(\bspdlog\b)", "logs"},
    Forbidden{R"(#\s*include\s*<iostream>|\bstd::(cout|cerr|clog)\b|\bfmt::print\b)", "consoles"},
};

class Reader {
 public:
  Reader(const fs::path& root, std::string file, Survey& survey)
      : root_(root), file_(std::move(file)), place_(place_of(file_)), survey_(survey) {
    for (const auto& f : kForbidden) forbidden_.emplace_back(std::regex(f.pattern), f.name);
  }

  void read() {
    ++survey_.files;
    std::ifstream in(root_ / file_, std::ios::binary);
    std::string line;
    bool ascii = true;
    while (std::getline(in, line)) {
      ++number_;
      if (number_ == 1 && line != kFirstLine) complain("does not begin with \"" + std::string(kFirstLine) + "\"");
      if (number_ == kMostLines + 1) complain("has more than 500 lines");
      if (ascii &&
          std::any_of(line.begin(), line.end(), [](unsigned char c) { return c > 126 || (c < 32 && c != '\t'); })) {
        ascii = false;
        complain("is not plain ASCII text");
      }
      check_include(line);
      if (place_ && place_->mathematics) check_mathematics(line);
    }
    if (number_ == 0) complain("is empty");
  }

 private:
  void complain(const std::string& rule) { survey_.violations.push_back({file_, std::max(number_, 1), rule}); }

  void check_include(const std::string& line) {
    if (!place_) return;
    static const std::regex include(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"].*)");
    std::smatch m;
    if (!std::regex_match(line, m, include)) return;
    const bool quoted = m[1] == "\"";
    const std::string name = m[2];
    const auto target = resolved(root_, name);
    if (!target) {
      if (quoted) complain("\"" + name + "\" is no file of the tree: own headers are named from the root or from src");
      return;
    }
    ++survey_.includes;
    if (!quoted) complain("<" + name + "> is our own: write it in quotes");
    if (const auto rule = broken_rule(*place_, *target); !rule.empty()) complain(rule);
  }

  void check_mathematics(const std::string& line) {
    for (const auto& [pattern, name] : forbidden_) {
      if (std::regex_search(line, pattern)) complain(place_->folder + " is mathematics: no " + name + " there");
    }
  }

  const fs::path& root_;
  std::string file_;
  std::optional<Place> place_;
  Survey& survey_;
  std::vector<std::pair<std::regex, std::string>> forbidden_;
  int number_ = 0;
};

}  // namespace

Survey survey(const fs::path& root) {
  Survey result;
  std::vector<std::string> files;
  for (const auto* top : kTops) {
    if (!fs::is_directory(root / top)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const auto ending = entry.path().extension();
      if (entry.is_regular_file() && (ending == ".cpp" || ending == ".hpp")) {
        files.push_back(fs::relative(entry.path(), root).generic_string());
      }
    }
  }
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    // A folder of src that the table does not know would go unchecked.
    if (file.starts_with("src/") && !place_of(file)) {
      result.violations.push_back({file, 1, "stands in no layer: add its folder to the table"});
    }
    Reader(root, file, result).read();
  }
  return result;
}

}  // namespace choreo::architecture

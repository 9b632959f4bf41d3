// SPDX-License-Identifier: Apache-2.0
#include "pipeline/person_models.hpp"

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"
#include "pipeline/model_file.hpp"

namespace choreo::pipeline {
namespace {

namespace fs = std::filesystem;

fs::path folder_of(const PersonModelOptions& options) {
  return options.folder.empty() ? usual_models_folder() : options.folder;
}

std::vector<const char*> needed(const PersonModelOptions& options) {
  return {kPersonModels[options.quick ? 1 : 0].file, kPersonModels[2].file};
}

template <typename Network>
Network load(const fs::path& path) {
  constexpr std::size_t kMost = std::size_t{64} << 20U;  // The largest of MediaPipe's has 28 MB.
  const auto bytes = bytes_of_model(path.string(), kMost, "a network", kPersonModelsRemedy);
  try {
    return Network({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  } catch (const Error& error) {
    if (error.fault() != Fault::kUsage) throw;
    throw usage_error(fmt::format("\"{}\": {}", path.string(), error.what()), {}, kPersonModelsRemedy);
  }
}

}  // namespace

std::string usual_models_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && *cache == '/') return (fs::path(cache) / "choreoscope/models").string();
  const char* home = std::getenv("HOME");
  return (fs::path(home == nullptr ? "/" : home) / ".cache/choreoscope/models").string();
}

std::string missing_person_models(const PersonModelOptions& options) {
  std::vector<std::string> missing;
  for (const auto* file : needed(options)) {
    std::error_code problem;
    const auto path = folder_of(options) / file;
    if (!fs::is_regular_file(path, problem)) missing.push_back(path.string());
  }
  return join(missing);
}

std::string trouble_with_person_model(std::size_t model, const std::string& path) {
  try {
    if (model == 2) {
      (void)load<vision::PersonDetector>(path);
    } else {
      (void)load<vision::PersonNetwork>(path);
    }
    return {};
  } catch (const Error& error) {
    return error.what();
  }
}

vision::PersonSearch load_person_search(const PersonModelOptions& options) {
  std::error_code problem;
  if (!fs::is_directory(folder_of(options), problem)) {
    throw usage_error(fmt::format("there is no folder \"{}\"", folder_of(options).string()),
                      options.folder.empty() ? "" : "person.models", kPersonModelsRemedy);
  }
  const auto files = needed(options);
  auto network = load<vision::PersonNetwork>(folder_of(options) / files[0]);
  return {std::move(network), load<vision::PersonDetector>(folder_of(options) / files[1]), options.choice};
}

}  // namespace choreo::pipeline

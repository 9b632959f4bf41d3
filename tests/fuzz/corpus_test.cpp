// SPDX-License-Identifier: Apache-2.0
// Runs every file of the corpus, and every beginning of it, through what the fuzzers run: crashes once found stay
// found.
#include <filesystem>

#include <gtest/gtest.h>

#include "fuzz/entries.hpp"
#include "support/places.hpp"
#include "support/temp_folder.hpp"

namespace choreo::fuzz {
namespace {

class Corpus : public ::testing::TestWithParam<Entry> {
 protected:
  // From memory that ends where the text does, as the fuzzers give it: behind a std::string's end lies a NUL, and a
  // short one lies within itself, so that reading too far would not be noticed.
  static void run(const std::string& text) {
    const std::vector<char> exact(text.begin(), text.end());
    GetParam().run({exact.data(), exact.size()});
  }

  static std::vector<std::pair<std::string, std::string>> files() {
    std::vector<std::pair<std::string, std::string>> all;
    for (const auto& file :
         std::filesystem::directory_iterator(test::project_file("tests/corpus/") + GetParam().name)) {
      const auto bytes = test::read_bytes(file.path().string());
      all.emplace_back(file.path().filename().string(), std::string(bytes.begin(), bytes.end()));
    }
    EXPECT_GE(all.size(), 5U) << "a corpus to begin with";
    return all;
  }
};

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus, ::testing::ValuesIn(entries()),
                         [](const auto& each) { return each.param.name; });

TEST_P(Corpus, EveryFileKeepsThePromises) {
  for (const auto& [name, text] : files()) EXPECT_NO_THROW(run(text)) << name;
}

TEST_P(Corpus, EveryBeginningOfAFileKeepsThePromises) {
  for (const auto& [name, text] : files()) {
    for (std::size_t n = 0; n < std::min<std::size_t>(text.size(), 200); ++n) {
      EXPECT_NO_THROW(run(text.substr(0, n))) << name << ", the first " << n << " bytes";
    }
  }
}

TEST_P(Corpus, EveryFileWithOneByteChangedKeepsThePromises) {
  for (const auto& [name, text] : files()) {
    for (std::size_t n = 0; n < std::min<std::size_t>(text.size(), 200); ++n) {
      auto changed = text;
      changed[n] = static_cast<char>(changed[n] ^ (1 << (n % 8)));
      EXPECT_NO_THROW(run(changed)) << name << ", byte " << n;
    }
  }
}

}  // namespace
}  // namespace choreo::fuzz

// SPDX-License-Identifier: Apache-2.0
// The test of the test: in made-up trees with one violation each, that one is found and nothing else.
#include "architecture/layers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temp_folder.hpp"

namespace choreo::architecture {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const std::string kSpdx = "// SPDX-License-Identifier: Apache-2.0\n";

class Layers : public ::testing::Test {
 protected:
  // One file in every layer, all in order.
  Layers() {
    write("src/core/error.hpp", "");
    write("src/core/text.hpp", "#include <string>\n#include \"core/error.hpp\"\n");
    write("src/vision/mask.hpp", "#include \"core/error.hpp\"\n");
    write("src/body/state.hpp", "#include \"vision/mask.hpp\"\n");
    write("src/body/figure.hpp", "");
    write("src/body/semaphore_signs.hpp", "");
    write("src/similarity/z.hpp", "#include \"body/state.hpp\"\n");
    write("src/motion/motif.hpp", "#include \"similarity/z.hpp\"\n");
    write("src/recognition/name.hpp", "#include \"body/figure.hpp\"\n");
    write("devices/source.hpp", "#include \"core/error.hpp\"\n#include \"body/figure.hpp\"\n");
    write("devices/film/film.hpp", "#include \"devices/source.hpp\"\n#include \"body/semaphore_signs.hpp\"\n");
    write("devices/camera/camera.hpp", "#include \"devices/source.hpp\"\n");
    write("pipeline/runner.hpp", "#include \"devices/source.hpp\"\n#include \"similarity/z.hpp\"\n#include <thread>\n");
    write("src/outputs/csv.hpp", "#include \"pipeline/runner.hpp\"\n#include <fstream>\n");
    write("config/config.hpp", "#include \"outputs/csv.hpp\"\n");
    write("src/cli/main.cpp", "#include \"config/config.hpp\"\n#include \"devices/film/film.hpp\"\n");
    write("tests/core/text_test.cpp", "#include \"core/text.hpp\"\n#include \"support/any.hpp\"\n#include <thread>\n");
  }
  void write(const std::string& name, const std::string& text) {
    const auto path = fs::path(folder_ / name);
    fs::create_directories(path.parent_path());
    test::write_bytes(path.string(), kSpdx + text);
  }
  void write_bare(const std::string& name, const std::string& text) { test::write_bytes(folder_ / name, text); }

  // Exactly one violation, there, with these words.
  void expect_one(const std::string& file, int line, const std::string& words) {
    const auto found = survey(folder_.path()).violations;
    ASSERT_THAT(found, SizeIs(1)) << file;
    EXPECT_EQ(found[0].file, file);
    EXPECT_EQ(found[0].line, line);
    EXPECT_THAT(found[0].rule, HasSubstr(words));
  }

  test::TempFolder folder_;
};

TEST_F(Layers, ATreeInOrderHasNoViolation) {
  const auto found = survey(folder_.path());
  EXPECT_THAT(found.violations, IsEmpty());
  EXPECT_EQ(found.files, 17);
  EXPECT_EQ(found.includes, 17) << "of the tests' none is counted";
}

TEST_F(Layers, AnIncludeThatBreaksARuleIsFoundWithItsPlaceAndTheRule) {
  struct Case {
    std::string file;
    std::string include;
    std::string words;
  };
  for (const auto& c : {
           Case{"src/core/a.hpp", "vision/mask.hpp", "src/core lies below src/vision"},
           Case{"src/vision/a.hpp", "body/state.hpp", "src/vision lies below src/body"},
           Case{"src/body/a.cpp", "similarity/z.hpp", "src/body lies below src/similarity"},
           Case{"src/similarity/a.cpp", "motion/motif.hpp", "src/similarity lies below src/motion"},
           Case{"src/motion/a.cpp", "recognition/name.hpp", "src/motion and src/recognition never include each other"},
           Case{"src/recognition/a.cpp", "devices/source.hpp", "src/recognition lies below devices"},
           Case{"src/recognition/a.cpp", "devices/film/film.hpp", "src/recognition lies below devices/film"},
           Case{"devices/a.cpp", "devices/film/film.hpp", "devices lies below devices/film"},
           Case{"devices/a.cpp", "pipeline/runner.hpp", "devices lies below pipeline"},
           Case{"devices/a.cpp", "vision/mask.hpp", "devices use core and body's figure"},
           Case{"devices/a.cpp", "body/state.hpp", "devices use core and body's figure"},
           Case{"devices/film/a.cpp", "similarity/z.hpp", "devices use core and body's figure"},
           Case{"devices/film/a.cpp", "devices/camera/camera.hpp", "devices/film and devices/camera never include"},
           Case{"pipeline/stages/a.cpp", "outputs/csv.hpp", "pipeline lies below src/outputs"},
           Case{"src/outputs/a.cpp", "config/config.hpp", "src/outputs lies below config"},
           Case{"config/a.cpp", "cli/main.cpp", "config lies below src/cli"},
           Case{"src/cli/a.cpp", "tests/core/text_test.cpp", "nothing includes tests/"},
           Case{"src/cli/a.cpp", "commands.hpp", "is no file of the tree"},
       }) {
    SCOPED_TRACE(c.file + " with " + c.include);
    write(c.file, "#include <vector>\n\n  #  include \"" + c.include + "\"  // why\n");
    expect_one(c.file, 4, c.words);
    fs::remove(folder_ / c.file);
  }
}

TEST_F(Layers, AnOwnHeaderInAngleBracketsIsFound) {
  write("src/core/a.hpp", "#include <core/text.hpp>\n");
  expect_one("src/core/a.hpp", 2, "write it in quotes");
}

TEST_F(Layers, TheMathematicsHasNoThreadFileClockSocketLogOrConsole) {
  for (const auto& [line, words] : {std::pair{"#include <thread>", "threads"},
                                    {"#include <mutex>", "threads"},
                                    {"std::jthread t;", "threads"},
                                    {"#include <fstream>", "files"},
                                    {"auto t = std::chrono::steady_clock::now();", "clocks"},
                                    {"#include <sys/socket.h>", "sockets"},
                                    {"#include <boost/asio.hpp>", "sockets"},
                                    {"#include <spdlog/spdlog.h>", "logs"},
                                    {"  std::cout << 1;", "consoles"},
                                    {"fmt::print(\"x\");", "consoles"}}) {
    for (const std::string folder : {"core", "vision", "body", "similarity", "motion", "recognition"}) {
      const auto file = "src/" + folder + "/a.cpp";
      write(file, std::string("\n") + line + "\n");
      expect_one(file, 3, words);
      fs::remove(folder_ / file);
    }
    write("pipeline/a.cpp", std::string(line) + "\n");
    EXPECT_THAT(survey(folder_.path()).violations, IsEmpty()) << line << " may stand in the pipeline";
  }
}

TEST_F(Layers, WhatOnlySoundsForbiddenIsAllowed) {
  write("src/core/a.hpp",
        "// One thread or many threads; a mutex, a file, the clock.\n#include <stop_token>\nint threads;\n");
  EXPECT_THAT(survey(folder_.path()).violations, IsEmpty());
}

TEST_F(Layers, AFolderOfSrcThatStandsInNoLayerIsFound) {
  write("src/helpers/a.hpp", "");
  expect_one("src/helpers/a.hpp", 1, "stands in no layer");
}

TEST_F(Layers, EveryFileBeginsWithTheSpdxLine) {
  write_bare("tests/core/a.cpp", "#include <string>\n");
  expect_one("tests/core/a.cpp", 1, "does not begin with");
  write_bare("tests/core/a.cpp", "");
  expect_one("tests/core/a.cpp", 1, "is empty");
}

TEST_F(Layers, NoFileHasMoreThanFiveHundredLines) {
  std::string lines;
  for (int i = 0; i < 499; ++i) lines += "\n";
  write("pipeline/a.cpp", lines);
  EXPECT_THAT(survey(folder_.path()).violations, IsEmpty());
  write("pipeline/a.cpp", lines + "\n");
  expect_one("pipeline/a.cpp", 501, "more than 500 lines");
}

TEST_F(Layers, SourcesAreAscii) {
  write("config/a.cpp", "int a;\n// caf\xc3\xa9 caf\xc3\xa9\n// \xc3\xa9\n");
  expect_one("config/a.cpp", 3, "ASCII");
  write("config/a.cpp", "int a;\r\n");
  expect_one("config/a.cpp", 2, "ASCII");
}

}  // namespace
}  // namespace choreo::architecture

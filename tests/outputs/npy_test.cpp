// SPDX-License-Identifier: Apache-2.0
// NumPy's files: the header byte by byte, the numbers as a reader of its own finds them, and full disks.
#include "outputs/npy.hpp"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/frames.hpp"
#include "support/small_files.hpp"
#include "support/temp_folder.hpp"

namespace choreo::outputs {
namespace {

using test::error_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// What any reader of the format does, by its description (numpy.lib.format, version 1.0).
struct Array {
  std::string descr;
  std::vector<std::size_t> shape;
  test::Bytes data;

  template <typename T>
  [[nodiscard]] std::vector<T> values() const {
    std::vector<T> out(data.size() / sizeof(T));
    std::memcpy(out.data(), data.data(), out.size() * sizeof(T));
    return out;
  }
};

Array read_npy(const std::string& path) {
  const auto bytes = test::read_bytes(path);
  const std::string text(bytes.begin(), bytes.end());
  if (text.substr(0, 8) != std::string("\x93NUMPY\x01\x00", 8)) throw std::runtime_error("no .npy file");
  const auto length = std::size_t{bytes.at(8)} + 256U * std::size_t{bytes.at(9)};
  if ((10 + length) % 64 != 0) throw std::runtime_error("the data is not aligned");
  const auto header = text.substr(10, length);
  std::smatch m;
  const std::regex form(R"(\{'descr': '([^']+)', 'fortran_order': False, 'shape': \(([0-9, ]*)\), \} *\n)");
  if (!std::regex_match(header, m, form)) throw std::runtime_error("header: " + header);
  Array array;
  array.descr = m[1];
  const auto shape = m[2].str();
  const std::regex number("[0-9]+");
  for (std::sregex_iterator n(shape.begin(), shape.end(), number); n != std::sregex_iterator(); ++n) {
    array.shape.push_back(std::stoull(n->str()));
  }
  if (array.shape.size() == 1 && shape.back() != ',') throw std::runtime_error("(3) is a number, (3,) a tuple");
  array.data.assign(bytes.begin() + static_cast<std::ptrdiff_t>(10 + length), bytes.end());
  return array;
}

class Npy : public ::testing::Test {
 protected:
  test::TempFolder folder_;
};

TEST(NpyHeader, IsWhatNumpyItselfWouldRead) {
  const std::size_t shape[] = {3, 4};
  std::string expected("\x93NUMPY\x01\x00\x76\x00", 10);  // 118 bytes follow, so that the data begins at 128.
  expected += "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }";
  expected += std::string(128 - expected.size() - 1, ' ') + "\n";
  EXPECT_EQ(npy_header("<f4", shape), expected);
}

TEST(NpyHeader, OneDimensionIsATupleAndNoneToo) {
  const std::size_t one[] = {7};
  EXPECT_THAT(npy_header("<f8", one), HasSubstr("'shape': (7,), }"));
  EXPECT_THAT(npy_header("<f8", {}), HasSubstr("'shape': (), }"));
  const std::size_t three[] = {2, 3, 4};
  EXPECT_THAT(npy_header("|u1", three), HasSubstr("'shape': (2, 3, 4), }"));
}

TEST(NpyHeader, ItsLengthIsAMultipleOf64WhateverTheShape) {
  std::vector<std::size_t> shape;
  for (int dimensions = 0; dimensions < 40; ++dimensions) {
    for (const std::size_t least : {1u, 64u, 128u, 256u}) {
      const auto header = npy_header("<f4", shape, least);
      EXPECT_EQ(header.size() % 64, 0u);
      EXPECT_GE(header.size(), least);
      EXPECT_EQ(header.back(), '\n');
      const auto said = static_cast<unsigned char>(header[8]) + 256U * static_cast<unsigned char>(header[9]);
      EXPECT_EQ(said, header.size() - 10);
    }
    shape.push_back(std::numeric_limits<std::size_t>::max());
  }
}

TEST_F(Npy, AVectorOfDoublesComesBackToTheLastBit) {
  const std::vector<double> values = {0.0,         -0.0, 1.0 / 3.0, 1e-320, std::numeric_limits<double>::infinity(),
                                      86399.999999};
  write_npy(folder_ / "times.npy", values);
  const auto array = read_npy(folder_ / "times.npy");
  EXPECT_EQ(array.descr, "<f8");
  EXPECT_THAT(array.shape, ElementsAre(6));
  const auto read = array.values<double>();
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(read[i]), std::bit_cast<std::uint64_t>(values[i])) << i;
  }
  write_npy(folder_ / "empty.npy", {});
  EXPECT_THAT(read_npy(folder_ / "empty.npy").shape, ElementsAre(0));
}

TEST_F(Npy, TheBytesAreLittleEndian) {
  write_npy(folder_ / "one.npy", std::vector<double>{1.0});
  EXPECT_THAT(read_npy(folder_ / "one.npy").data, ElementsAre(0, 0, 0, 0, 0, 0, 0xf0, 0x3f));
}

TEST_F(Npy, AMatrixWrittenInBandsIsWholeAndSymmetric) {
  // The number at (i, j) is 10 times the larger plus the smaller; bands of 2, 1 and 20 rows.
  const std::size_t n = 23;
  const auto value = [](std::size_t i, std::size_t j) { return float(100 * std::max(i, j) + std::min(i, j)); };
  {
    NpyMatrix matrix(folder_ / "z.npy", n, n);
    for (const auto& [first, end] : {std::pair{0, 2}, {2, 3}, {3, 23}}) {
      const auto rows = std::size_t(end - first);
      std::vector<float> band;
      for (std::size_t i = std::size_t(first); i < std::size_t(end); ++i) {
        for (std::size_t j = 0; j < std::size_t(end); ++j) band.push_back(value(i, j));
      }
      matrix.write_symmetric(std::size_t(first), {band.data(), rows, std::size_t(end)});
    }
  }
  const auto array = read_npy(folder_ / "z.npy");
  EXPECT_EQ(array.descr, "<f4");
  EXPECT_THAT(array.shape, ElementsAre(n, n));
  const auto values = array.values<float>();
  ASSERT_EQ(values.size(), n * n);
  for (std::size_t k = 0; k < n * n; ++k) ASSERT_EQ(values[k], value(k / n, k % n)) << k / n << ", " << k % n;
}

TEST_F(Npy, NaNsAreWrittenAsTheyAreAndWhatIsNotWrittenIsZero) {
  {
    NpyMatrix matrix(folder_ / "z.npy", 2, 2);
    const float nan = std::nanf("");
    matrix.write_symmetric(0, {&nan, 1, 1});
  }
  const auto values = read_npy(folder_ / "z.npy").values<float>();
  EXPECT_TRUE(std::isnan(values[0]));
  EXPECT_THAT((std::vector<float>{values[1], values[2], values[3]}), ElementsAre(0.0F, 0.0F, 0.0F));
}

TEST_F(Npy, AMatrixReplacesWhatWasThereAndMayBeEmpty) {
  test::write_bytes(folder_ / "z.npy", std::string(100'000, 'x'));
  { const NpyMatrix matrix(folder_ / "z.npy", 1, 1); }
  EXPECT_THAT(read_npy(folder_ / "z.npy").values<float>(), ElementsAre(0.0F)) << "nothing of the old file";
  { const NpyMatrix matrix(folder_ / "none.npy", 0, 0); }
  EXPECT_THAT(read_npy(folder_ / "none.npy").shape, ElementsAre(0, 0));
}

TEST_F(Npy, AMatrixWithoutRoomOnTheDiskIsAFailureAtOnceWithItsSize) {
  const test::SmallFiles full(100'000);
  const auto error = error_of([&] { const NpyMatrix matrix(folder_ / "z.npy", 1000, 1000); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kFailure);
  EXPECT_THAT(error->what(), HasSubstr("z.npy\" needs 4.0 MB"));
  EXPECT_THAT(error->hint(), HasSubstr("--every"));
}

TEST_F(Npy, AMatrixWhoseSizeNoNumberHoldsIsAFailure) {
  for (const std::size_t n : {std::size_t{1} << 31, (std::size_t{1} << 31) + 1, std::size_t{1} << 32}) {
    const auto error = error_of([&] { const NpyMatrix matrix(folder_ / "z.npy", n, n); });
    ASSERT_TRUE(error) << n;
    EXPECT_EQ(error->fault(), Fault::kFailure);
  }
}

TEST_F(Npy, EverySecondPictureIsKeptInItsPlace) {
  for (const int count : {0, 1, 2, 7, 8}) {
    NpyPictures pictures(folder_ / "masks.npy", {3, 2});
    const auto picture = [](int i) {
      cv::Mat mask = cv::Mat::zeros(2, 3, CV_8UC1);
      for (int k = 0; k < 6; ++k) mask.at<std::uint8_t>(k / 3, k % 3) = (i >> k & 1) != 0 ? 255 : 0;
      return mask;
    };
    for (int i = 0; i < count; ++i) pictures.add(picture(i));
    pictures.keep_every_second();
    pictures.add(picture(63));
    pictures.close();
    const auto array = read_npy(folder_ / "masks.npy");
    const auto kept = std::size_t(count + 1) / 2;
    EXPECT_THAT(array.shape, ElementsAre(kept + 1, 2, 3));
    ASSERT_EQ(array.data.size(), 6 * (kept + 1));
    for (std::size_t i = 0; i <= kept; ++i) {
      for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(array.data[6 * i + k], i == kept ? 1 : (2 * i) >> k & 1U) << i;
    }
  }
}

TEST_F(Npy, PicturesAreZeroOrOneAndTheirNumberComesAtTheEnd) {
  cv::Mat large(4, 6, CV_8UC1, cv::Scalar(0));
  large.at<std::uint8_t>(1, 2) = 255;
  large.at<std::uint8_t>(2, 3) = 1;
  const cv::Mat inner = large(cv::Rect(1, 1, 3, 2));  // Its rows do not follow one another in memory.
  {
    NpyPictures pictures(folder_ / "masks.npy", {3, 2});
    pictures.add(inner);
    pictures.add(cv::Mat(2, 3, CV_8UC1, cv::Scalar(7)));
    pictures.close();
  }
  const auto array = read_npy(folder_ / "masks.npy");
  EXPECT_EQ(array.descr, "|u1");
  EXPECT_THAT(array.shape, ElementsAre(2, 2, 3)) << "N x H x W";
  EXPECT_THAT(array.data, ElementsAre(0, 1, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1));
}

TEST_F(Npy, NoPictureIsAnArrayOfNone) {
  NpyPictures pictures(folder_ / "masks.npy", {3, 2});
  pictures.close();
  EXPECT_THAT(read_npy(folder_ / "masks.npy").shape, ElementsAre(0, 2, 3));
}

TEST_F(Npy, AFullDiskIsAFailureWhereverItFillsUp) {
  const test::SmallFiles full(50'000);
  const cv::Mat picture(100, 100, CV_8UC1, cv::Scalar(255));
  const auto pictures = error_of([&] {
    NpyPictures file(folder_ / "masks.npy", {100, 100});
    for (int i = 0; i < 10; ++i) file.add(picture);
    file.close();
  });
  ASSERT_TRUE(pictures);
  EXPECT_EQ(pictures->fault(), Fault::kFailure);
  EXPECT_THAT(pictures->what(), HasSubstr("masks.npy\" cannot be written: "));
  const auto times = error_of([&] { write_npy(folder_ / "times.npy", std::vector<double>(10'000)); });
  ASSERT_TRUE(times);
  EXPECT_EQ(times->fault(), Fault::kFailure);
}

TEST(NpyDevice, AFullDeviceIsSeenAtTheLatestWhenClosing) {
  const auto error = error_of([] {
    NpyPictures file("/dev/full", {2, 2});
    file.add(cv::Mat::zeros(2, 2, CV_8UC1));
    file.close();
  });
  ASSERT_TRUE(error);
  EXPECT_THAT(error->what(), HasSubstr("No space left on device"));
  EXPECT_TRUE(error_of([] { write_npy("/dev/full", std::vector<double>{1.0}); }));
}

TEST_F(Npy, AFolderThatIsNotThereIsAFailure) {
  EXPECT_TRUE(error_of([&] { const NpyMatrix matrix(folder_ / "no/z.npy", 1, 1); }));
  EXPECT_TRUE(error_of([&] { const NpyPictures pictures(folder_ / "no/m.npy", {1, 1}); }));
  EXPECT_TRUE(error_of([&] { write_npy(folder_ / "no/t.npy", {}); }));
}

}  // namespace
}  // namespace choreo::outputs

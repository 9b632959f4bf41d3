// SPDX-License-Identifier: Apache-2.0
// Sources that are none: exit status 2, one line that says what and where, and nothing touched.
#include <sys/stat.h>

#include <gmock/gmock.h>

#include "end_to_end/refusal_fixture.hpp"
#include "support/make_video.hpp"

namespace choreo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using SourceRefusal = RefusalTest;

// One second of silence: a header of 44 bytes and samples.
Bytes silent_wav() {
  const auto word = [](Bytes& to, std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) to.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  };
  const auto text = [](Bytes& to, const std::string& letters) { to.insert(to.end(), letters.begin(), letters.end()); };
  Bytes wav;
  text(wav, "RIFF");
  word(wav, 36 + 16000, 4);
  text(wav, "WAVEfmt ");
  word(wav, 16, 4);
  word(wav, 1, 2);     // PCM
  word(wav, 1, 2);     // channel
  word(wav, 8000, 4);  // samples a second
  word(wav, 16000, 4);
  word(wav, 2, 2);
  word(wav, 16, 2);
  text(wav, "data");
  word(wav, 16000, 4);
  wav.resize(wav.size() + 16000);
  return wav;
}

TEST_F(SourceRefusal, AMissingFileIsNamed) {
  EXPECT_THAT(refused(folder_ / "no such clip.mp4"),
              AllOf(HasSubstr("no such clip.mp4\""), HasSubstr("does not exist")));
}

TEST_F(SourceRefusal, AnEmptyFile) {
  write_bytes(folder_ / "nothing.mp4", std::string());
  EXPECT_THAT(refused(folder_ / "nothing.mp4"), AllOf(HasSubstr("nothing.mp4\""), HasSubstr("is empty")));
}

TEST_F(SourceRefusal, AFolderWithoutPictures) {
  write_bytes(folder_ / "notes.txt", std::string("none here"));
  EXPECT_THAT(refused(folder_.path()), HasSubstr("holds no pictures"));
  EXPECT_THAT(hint(), HasSubstr("numbered"));
}

TEST_F(SourceRefusal, AFolderWhosePicturesAreAllDamaged) {
  std::filesystem::create_directory(folder_ / "pictures");
  write_bytes(folder_ / "pictures/0001.png", std::string("not a picture at all"));
  write_bytes(folder_ / "pictures/0002.jpg", std::string("\xff\xd8\xff\xe0 cut off"));
  EXPECT_THAT(refused(folder_ / "pictures"), HasSubstr("none of its 2 pictures can be read"));
}

TEST_F(SourceRefusal, ATextFile) {
  std::string text;
  for (int i = 0; i < 200; ++i) text += "Dear diary, today we rehearsed the second act.\n";
  write_bytes(folder_ / "diary.txt", text);
  write_bytes(folder_ / "diary.mp4", text);
  EXPECT_THAT(refused(folder_ / "diary.txt"), HasSubstr("diary.txt\""));
  EXPECT_THAT(refused(folder_ / "diary.mp4"), HasSubstr("diary.mp4\""));
}

TEST_F(SourceRefusal, AnMp4WithoutItsIndexIsSaidToBeCutOff) {
  VideoRecipe recipe;
  recipe.encoder = "mpeg4";
  recipe.pixel_format = AV_PIX_FMT_YUV420P;
  recipe.time_base = {1, 25};
  recipe.times.clear();
  for (int i = 0; i < 50; ++i) recipe.times.push_back(i);
  recipe.width = 64;
  recipe.height = 48;
  make_video(folder_ / "whole.mp4", recipe);
  auto bytes = read_bytes(folder_ / "whole.mp4");
  const std::string moov = "moov";
  const auto index = std::search(bytes.begin(), bytes.end(), moov.begin(), moov.end());
  ASSERT_NE(index, bytes.end());
  bytes.erase(index - 4, bytes.end());
  write_bytes(folder_ / "cut.mp4", bytes);
  EXPECT_THAT(refused(folder_ / "cut.mp4"), HasSubstr("cut.mp4\""));
  EXPECT_THAT(hint(), HasSubstr("the recording was cut off"));
}

TEST_F(SourceRefusal, SoundAlone) {
  write_bytes(folder_ / "song.wav", silent_wav());
  EXPECT_THAT(refused(folder_ / "song.wav"), HasSubstr("has no video"));
}

TEST_F(SourceRefusal, AVideoWithoutFrames) {
  VideoRecipe recipe;
  recipe.times.clear();
  make_video(folder_ / "blank.mkv", recipe);
  EXPECT_THAT(refused(folder_ / "blank.mkv"), HasSubstr("blank.mkv\""));
}

TEST_F(SourceRefusal, APlateOfAnotherSizeNamesBothSizes) {
  write_png("plate.png", {65, 48});
  EXPECT_THAT(refused(kQuick, {"--background", folder_ / "plate.png"}),
              AllOf(HasSubstr("plate.png\""), HasSubstr("65 x 48"), HasSubstr("64 x 48")));
}

TEST_F(SourceRefusal, APlateThatMayNeverEnd) {
  const auto pipe = folder_ / "pipe.png";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(refused(kQuick, {"--background", pipe}), HasSubstr("pipe.png\""));
  EXPECT_THAT(refused(kQuick, {"--background", "/dev/zero"}), HasSubstr("/dev/zero"));
}

TEST_F(SourceRefusal, APlateThatIsNoPicture) {
  write_bytes(folder_ / "plate.png", std::string("not a picture"));
  EXPECT_THAT(refused(kQuick, {"--background", folder_ / "plate.png"}), HasSubstr("plate.png\""));
  EXPECT_THAT(refused(kQuick, {"--background", folder_ / "missing.png"}), HasSubstr("missing.png\""));
  EXPECT_THAT(refused(kQuick, {"--background", folder_.path()}), HasSubstr(folder_.path()));
  // Cut in the middle, as by a full card: half a room is no room.
  write_png("whole.png", {64, 48});
  auto bytes = read_bytes(folder_ / "whole.png");
  bytes.resize(bytes.size() / 2);
  write_bytes(folder_ / "half.png", bytes);
  EXPECT_THAT(refused(kQuick, {"--background", folder_ / "half.png"}), HasSubstr("half.png\""));
}

TEST_F(SourceRefusal, AnUnknownSchemeListsTheKnownOnes) {
  EXPECT_THAT(refused("kinect://0"), HasSubstr("unknown scheme \"kinect\""));
  EXPECT_THAT(hint(), AllOf(HasSubstr("file"), HasSubstr("folder"), HasSubstr("synthetic")));
}

TEST_F(SourceRefusal, AnUnknownScriptIsAnsweredWithTheNearest) {
  EXPECT_THAT(refused("synthetic://jumpingjacks"), HasSubstr("jumpingjacks"));
  EXPECT_EQ(hint(), "did you mean \"jumping-jacks\"?");
}

TEST_F(SourceRefusal, SettingsOfASourceThatAreUnknownOrOutOfRange) {
  EXPECT_THAT(refused("synthetic://walking?nois=3"), HasSubstr("unknown setting \"nois\""));
  EXPECT_EQ(hint(), "did you mean \"noise\"?");
  EXPECT_THAT(refused("synthetic://walking?fps=0"), HasSubstr("fps is \"0\""));
  EXPECT_THAT(hint(), HasSubstr("from 1 to 240"));
  EXPECT_THAT(refused("synthetic://walking?size=640"), HasSubstr("size is \"640\""));
  EXPECT_THAT(refused("synthetic://walking?rotate=45"), HasSubstr("rotate is \"45\""));
  EXPECT_THAT(hint(), HasSubstr("0, 90, 180, 270"));
}

TEST_F(SourceRefusal, AFileNameWithLineBreaksStaysOneLine) {
  EXPECT_THAT(refused(folder_ / "two\nlines\x1b[31m.mp4"), HasSubstr("does not exist"));
}

}  // namespace
}  // namespace choreo::test

// SPDX-License-Identifier: Apache-2.0
#include "config/signal_fields.hpp"

#include <string>
#include <utility>

#include "config/field_kinds.hpp"

namespace choreo::config {
namespace {

bool anything(const std::string&) { return true; }

// A choice of two that is a flag or an enumerator in the options.
template <typename Value>
Field choice(std::string key, Value& (*at)(Options&), std::string first, Value first_value, std::string second,
             Value second_value, std::string help) {
  const auto range = "\"" + first + "\" or \"" + second + "\"";
  return {std::move(key),
          range,
          std::move(help),
          true,
          [=](Options& o, const toml::node& node) {
            const auto word = text_of(node, one_of({first, second}));
            if (word) at(o) = *word == first ? first_value : second_value;
            return word.has_value();
          },
          [=](const Options& o) { return toml_string(at(const_cast<Options&>(o)) == first_value ? first : second); }};
}

// Names of tones.
Field names(std::string key, std::vector<std::string>& (*at)(Options&), std::string help) {
  constexpr std::size_t kMost = 8;
  return {std::move(key),
          "a list of 1 to 8 names",
          std::move(help),
          false,
          [=](Options& o, const toml::node& node) {
            const auto* array = node.as_array();
            if (array == nullptr || array->empty() || array->size() > kMost) return false;
            std::vector<std::string> all;
            for (const auto& item : *array) {
              auto name = text_of(item, [](const std::string& s) { return !s.empty(); });
              if (!name) return false;
              all.push_back(*std::move(name));
            }
            at(o) = std::move(all);
            return true;
          },
          [=](const Options& o) {
            std::vector<std::string> all;
            for (const auto& name : at(const_cast<Options&>(o))) all.push_back(toml_string(name));
            return fmt::format("[{}]", fmt::join(all, ", "));
          }};
}

void add_person(std::vector<Field>& fields) {
  fields.push_back(text(
      "person.models", [](Options& o) -> std::string& { return o.person.models; }, anything,
      "the path of a folder; empty: ~/.cache/choreoscope/models", "Where the files of the person network are."));
  fields.push_back(text(
      "person.network", [](Options& o) -> std::string& { return o.person.network; }, one_of({"full", "lite"}),
      "\"full\" or \"lite\"", "The sure network or the quick one."));
  fields.push_back(text(
      "person.choose", [](Options& o) -> std::string& { return o.person.choose; },
      one_of({"largest", "left", "middle", "right"}), "\"largest\", \"left\", \"middle\" or \"right\"",
      "Who is followed, of several who are there at the beginning."));
  fields.push_back(text(
      "person.others", [](Options& o) -> std::string& { return o.person.others; }, one_of({"left-out", "bodies"}),
      "\"left-out\" or \"bodies\"",
      "Whether others whom the network sees are bodies in the mask, too, or are kept out of it."));
  fields.push_back(number(
      "person.smooth_hz", [](Options& o) -> double& { return o.person.smooth_hz; }, {0, 100},
      "from 0, which filters nothing, to 100 Hz",
      "Cutoff of the 1 euro filter that steadies joints at rest; 1 is usual, less is steadier and later."));
  fields.push_back(number(
      "person.smooth_hz_per_mps", [](Options& o) -> double& { return o.person.smooth_hz_per_mps; }, {0, 1000},
      "from 0 to 1000 Hz", "How much higher the cutoff is for each metre a second that a joint moves."));
  fields.push_back(number(
      "person.looks_per_s", [](Options& o) -> double& { return o.person.looks_per_s; }, {0.1, 1000},
      "from 0.1 to 1000 looks a second", "How often the network looks; no frame is looked at twice."));
  fields.push_back(number(
      "person.delay_s", [](Options& o) -> double& { return o.person.delay_s; }, {0.01, 2}, "from 0.01 to 2 s",
      "Live, so long after the frame that is looked at its person takes effect; the look has this time."));
}

void add_face(std::vector<Field>& fields) {
  fields.push_back(choice<vision::FaceChoice>(
      "face.choose", [](Options& o) -> vision::FaceChoice& { return o.face.track.choose; }, "tracked",
      vision::FaceChoice::kTracked, "largest", vision::FaceChoice::kLargest,
      "Of several faces, the one that was there first, or the largest."));
  fields.push_back(number(
      "face.least_share", [](Options& o) -> double& { return o.face.search.least_share; }, {0.01, 0.5},
      "from 0.01 to 0.5 of the picture's height", "The narrowest face that is searched for, cheek to cheek."));
  fields.push_back(number(
      "face.most_share", [](Options& o) -> double& { return o.face.search.most_share; }, {0.01, 1, true},
      "above 0.01 and at most 1 of the picture's height, above face.least_share", "The widest."));
  fields.push_back(integer(
      "face.persistence", [](Options& o) -> int& { return o.face.track.persistence; }, 1, 100, "from 1 to 100 times",
      "How often a face is seen before it counts."));
  fields.push_back(number(
      "face.coast_s", [](Options& o) -> double& { return o.face.track.coast_s; }, {0, 60}, "from 0 to 60 s",
      "How long a face is kept that is not seen."));
  fields.push_back(number(
      "face.hidden_s", [](Options& o) -> double& { return o.face.track.hidden_s; }, {0, 600}, "from 0 to 600 s",
      "The same where the body is still in its place: an arm before the face."));
  fields.push_back(integer(
      "face.delay_frames", [](Options& o) -> int& { return o.face.delay_frames; }, 1, 60, "from 1 to 60 frames",
      "So long after the frame that is searched its face takes effect; the search has this time."));
  fields.push_back(integer(
      "face.near_frames", [](Options& o) -> int& { return o.face.search.near_frames; }, 1, 1000,
      "from 1 to 1000 frames", "Between two looks at a face that is followed."));
  fields.push_back(integer(
      "face.whole_frames", [](Options& o) -> int& { return o.face.search.whole_frames; }, 1, 100'000,
      "from 1 to 100000 frames", "In which the whole picture is searched for a band of sizes beside it."));
  fields.push_back(integer(
      "face.lost_frames", [](Options& o) -> int& { return o.face.search.lost_frames; }, 1, 1000,
      "from 1 to 1000 frames", "Between two steps while nobody's face is known."));
  fields.push_back(integer(
      "face.rows", [](Options& o) -> int& { return o.face.rows; }, 60, 4320, "from 60 to 4320 rows",
      "Faces are searched in pictures of at most so many rows."));
  fields.push_back(integer(
      "face.neighbours", [](Options& o) -> int& { return o.haar.neighbours; }, 1, 100, "from 1 to 100",
      "Windows of the Haar cascade that must agree."));
  fields.push_back(number(
      "face.scale_step", [](Options& o) -> double& { return o.haar.scale_step; }, {1.01, 2}, "from 1.01 to 2",
      "Ratio of the sizes that the Haar cascade tries."));
  fields.push_back(text(
      "face.cascades", [](Options& o) -> std::string& { return o.cascades; }, anything,
      "the path of a folder, or \"\" for the system's", "Where OpenCV's Haar cascades are."));
  fields.push_back(text(
      "face.model", [](Options& o) -> std::string& { return o.face_model; }, anything,
      "the path of a YuNet model in ONNX, or \"\" for none", "A face detector to take instead of the Haar cascades."));
}

void add_tones(std::vector<Field>& fields) {
  fields.push_back(choice<bool>(
      "tones.skin", [](Options& o) -> bool& { return o.tones.learn_skin; }, "learned", true, "file", false,
      "Learn the skin's tone from the face, or take that of tones.file."));
  fields.push_back(text(
      "tones.file", [](Options& o) -> std::string& { return o.tones.file; }, anything,
      "the path of a file of choreoscope tones train, or \"\" for none", "Further tones: gloves, sleeves, flags."));
  fields.push_back(names(
      "tones.arms", [](Options& o) -> std::vector<std::string>& { return o.tones.arms; },
      "The tones that the arms show: skin, or what hides it."));
  fields.push_back(choice<vision::ToneKind>(
      "tones.model", [](Options& o) -> vision::ToneKind& { return o.tones.model; }, "gaussian",
      vision::ToneKind::kGaussian, "histogram", vision::ToneKind::kHistogram, "How what is learned is modelled."));
  fields.push_back(number(
      "tones.threshold", [](Options& o) -> double& { return o.tones.threshold; }, {0.01, 0.99}, "from 0.01 to 0.99",
      "The least probability of the arms' tones at which a pixel is arm."));
  fields.push_back(number(
      "tones.skin_prior", [](Options& o) -> double& { return o.tones.skin_prior; }, {0.001, 1000}, "from 0.001 to 1000",
      "Prior of learned skin; only ratios of priors matter."));
  fields.push_back(number(
      "tones.outliers", [](Options& o) -> double& { return o.tones.outliers; }, {0.001, 1000}, "from 0.001 to 1000",
      "Prior of all that is no tone."));
  fields.push_back(number(
      "tones.noise", [](Options& o) -> double& { return o.tones.noise; }, {0, 50}, "from 0 to 50 grey levels",
      "Standard deviation of the sensor in a channel; makes dark pixels doubtful."));
  fields.push_back(number(
      "tones.learn_s", [](Options& o) -> double& { return o.tones.learn_s; }, {0, 60}, "from 0 to 60 s",
      "The first so many seconds of face count alike."));
  fields.push_back(number(
      "tones.adapt_s", [](Options& o) -> double& { return o.tones.adapt_s; }, {0, 3600},
      "0 (never) or from 0.5 to 3600 s", "Afterwards the time constant with which the skin follows the light."));
  fields.push_back(number(
      "tones.rebuild_s", [](Options& o) -> double& { return o.tones.rebuild_s; }, {0, 60}, "from 0 to 60 s",
      "A learned tone changes at most so often."));
  fields.push_back(flag(
      "tones.learn_clothes", [](Options& o) -> bool& { return o.tones.learn_clothes; },
      "Learn what is worn below the face, so that a shirt like skin is no arm."));
}

void add_arms(std::vector<Field>& fields) {
  const auto arm = [&](const char* key, double vision::ArmOptions::*member, Range range, const char* in_words,
                       const char* help) {
    fields.push_back(number(
        key, [member](Options& o) -> double& { return o.arms.*member; }, range, in_words, help));
  };
  using A = vision::ArmOptions;
  arm("arms.reach", &A::reach, {1, 10}, "from 1 to 10 face widths", "From the shoulder to the fingertip.");
  arm("arms.shoulder_aside", &A::shoulder_aside, {0, 5}, "from 0 to 5 face widths",
      "A shoulder from the face's middle, sideways.");
  arm("arms.shoulder_below", &A::shoulder_below, {0, 5}, "from 0 to 5 face widths",
      "A shoulder from the face's centre, down.");
  arm("arms.typical_arm", &A::typical_arm, {0.1, 10}, "from 0.1 to 10 face widths squared",
      "Area of a bare forearm, until two arms were seen.");
  arm("arms.least_arm", &A::least_arm, {0.02, 5}, "from 0.02 to 5 face widths squared", "Smaller regions are no arms.");
  arm("arms.largest_arm", &A::largest_arm, {0.02, 30}, "at least arms.least_arm, to 30 face widths squared",
      "Larger ones neither.");
  arm("arms.least_piece", &A::least_piece, {0, 5}, "from 0 to arms.least_arm", "Smaller regions are noise.");
  arm("arms.piece_gap", &A::piece_gap, {0, 3}, "from 0 to 3 face widths",
      "Pieces of one arm, split by a sleeve or a strap, lie no farther apart.");
  arm("arms.anneal", &A::anneal, {0, 0.3}, "from 0 to 0.3 face widths", "Gaps up to twice this are closed.");
  arm("arms.memory_s", &A::memory_s, {0, 10}, "from 0 to 10 s",
      "So long the arms of the frames before help to choose.");
}

void add_particles(std::vector<Field>& fields) {
  using B = body::ParticleBounds;
  const auto bound = [&](const char* key, double B::*member, const char* unit, const char* help) {
    fields.push_back(number(
        key, [member](Options& o) -> double& { return o.bounds.*member; }, {B::kLeast, B::kMost},
        fmt::format("from {} to {} face widths{}", B::kLeast, B::kMost, unit), help));
  };
  bound("particles.alpha_max", &B::alpha_max, "", "The most that half the distance between the arms can be.");
  bound("particles.c_max", &B::c_max, " squared", "The most that an arm's covariance can be long.");
  bound("particles.eta_max", &B::eta_max, "", "The most that the arms' middle can be from the face.");
}

void add_semaphore(std::vector<Field>& fields) {
  using S = recognition::SemaphoreOptions;
  const auto value = [&](const char* key, double S::*member, Range range, const char* in_words, const char* help) {
    fields.push_back(number(
        key, [member](Options& o) -> double& { return o.semaphore.*member; }, range, in_words, help));
  };
  fields.push_back(flag(
      "semaphore.mirrored", [](Options& o) -> bool& { return o.semaphore.mirrored; },
      "The picture is a mirror image, as a selfie camera shows it."));
  value("semaphore.least_similarity", &S::least_similarity, {0.5, 0.999}, "from 0.5 to 0.999",
        "Z from which a posture may be a sign.");
  value("semaphore.margin", &S::margin, {0, 0.5}, "from 0 to 0.5", "By how much Z exceeds that of every other sign.");
  value("semaphore.hysteresis", &S::hysteresis, {0, 0.5}, "from 0 to 0.5",
        "How far below semaphore.least_similarity a sign that is held may fall.");
  value("semaphore.hold_s", &S::hold_s, {0.05, 5}, "from 0.05 to 5 s", "For how long a sign is held still.");
  value("semaphore.still_widths_s", &S::still_widths_s, {0.05, 50}, "from 0.05 to 50 face widths a second",
        "Where arms are known by their tone: the speed of an arm's middle up to which it is still.");
  value("semaphore.still_degrees_s", &S::still_degrees_s, {0.1, 500}, "from 0.1 to 500 degrees a second",
        "Where the person network sees the arms: how fast arms may turn and yet be still.");
  value("semaphore.bridge_s", &S::bridge_s, {0, 5}, "from 0 to 5 s", "So long without arms a sign goes on.");
  value("semaphore.word_gap", &S::word_gap, {0.05, 20}, "from 0.05 to 20 letters",
        "A REST of so many letters' length is a space.");
}

}  // namespace

std::vector<Field> signal_fields() {
  std::vector<Field> fields;
  add_person(fields);
  add_face(fields);
  add_tones(fields);
  add_arms(fields);
  add_particles(fields);
  add_semaphore(fields);
  return fields;
}

}  // namespace choreo::config

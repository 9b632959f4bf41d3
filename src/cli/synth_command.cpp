// SPDX-License-Identifier: Apache-2.0
// choreoscope synth: films the synthetic performer, with the truth about every frame.
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cli/commands.hpp"
#include "core/error.hpp"
#include "devices/synthetic/synthetic_source.hpp"
#include "outputs/output_set.hpp"
#include "outputs/video_writer.hpp"

namespace choreo::cli {
namespace {

namespace fs = std::filesystem;

struct SynthOptions {
  std::string script;
  std::string out;
};

constexpr auto kSynthManual = R"(
SCRIPT is a name with settings behind it, as in synthetic://SCRIPT:
  choreoscope synth 'jumping-jacks?size=640x480&fps=30&seed=1&noise=3' -o jacks.mkv
writes jacks.mkv (FFV1, without loss), jacks.masks.mkv (the true silhouette) and
jacks.truth.json (of every frame the joint angles, the box of the face in pixels
where it is to be seen, and the sign that semaphore holds). With -o clip.mp4
the picture is H.264; the masks stay without loss.

Settings, with their ranges and defaults:
  size=WxH     pixels, 16x16 to 3840x2160, default 640x480
  fps=N        frames a second, 1 to 240, default 30
  seed=N       of looks, style and noise, default 1; the same seed, the same bytes
  duration=T   seconds of performance, to 36000, default the script's own
  empty=T      seconds of empty room before it, 0 to 60, default 1
  tail=T       and after it, 0 to 60, default 0
  noise=N      of the sensor, grey levels (standard deviation), 0 to 30, default 3
  drift=N      of the light, grey levels a minute, -60 to 60, default 0
  flicker=N    of the light, grey levels, 0 to 30, default 0
  shake=N      of the camera, pixels, 0 to 10, default 0
  build= skin= clothes=   default auto: by the seed
  sleeves=     long, half (default) or none: how much of the arms is covered
  flags=1      a flag in each hand; default 0
  room=        plain (default), cluttered, or wooden: furniture in skin's colours
  poster=1     a painted face on the wall; default 0
  light=       neutral (default), warm, dim or cool, on everything
  exposure=N   factor on everything, 0.5 to 1.5, default 1
  distance=N   factor on how far the performer stands, 0.6 to 2.5, default 1
  place=N      of the performer to the right, picture widths, -0.35 to 0.35, default 0
  pan=R:D:Z    a camera that stands elsewhere: the picture moved right and down
               by -64 to 64 pixels and enlarged 0.9 to 1.1 times, default 0:0:1
  text= rate=  what semaphore says, and letters a minute, 4 to 60, default 12;
               in it # ! ^ ~ are NUMERALS, CANCEL, ATTENTION and ERROR)";

// clip.mkv -> clip + ".masks.mkv" and the like.
fs::path beside(const fs::path& clip, const std::string& ending) {
  auto path = clip;
  return path.replace_extension(ending);
}

nlohmann::ordered_json truth_of(const devices::synthetic::Performance& performance, int index) {
  nlohmann::ordered_json frame;
  frame["frame"] = index + 1;
  frame["time_s"] = to_seconds(performance.time);
  frame["body"] = performance.present;
  auto& joints = frame["joints"] = nlohmann::ordered_json::object();
  for (const auto& [name, value] : performance.angles) joints[name] = value;
  const auto& face = performance.face;
  if (!face.empty()) frame["face"] = {face.x, face.y, face.width, face.height};
  if (!performance.sign.empty()) frame["sign"] = performance.sign;
  return frame;
}

int synth(const SynthOptions& options, Session& session) {
  const auto uri = devices::parse_source_uri("synthetic://" + options.script, [](const std::string&) { return false; });
  const auto request = devices::performer_request(uri);
  if (request.settings.depth) {
    throw usage_error("a clip of synth holds no depth", "depth=1",
                      "give synthetic://" + options.script + " itself as the SOURCE");
  }
  const devices::synthetic::Performer performer(request.script, request.settings);
  const auto& settings = performer.settings();

  const fs::path clip_path = options.out;
  outputs::OutputSet folder(clip_path.has_parent_path() ? clip_path.parent_path() : fs::path("."));
  outputs::VideoOptions clip_options;
  clip_options.codec = outputs::video_codec_for(options.out);
  clip_options.rate = {static_cast<int>(settings.fps * 1000 + 0.5), 1000};
  outputs::VideoOptions mask_options;
  mask_options.grey = true;
  mask_options.rate = clip_options.rate;
  clip_options.container =
      clip_path.extension() == ".mp4" ? outputs::VideoContainer::kMp4 : outputs::VideoContainer::kMatroska;
  mask_options.container = outputs::VideoContainer::kMatroska;
  const auto masks_path = beside(clip_path, ".masks.mkv");
  const auto truth_path = beside(clip_path, ".truth.json");
  outputs::VideoWriter clip(folder.add(clip_path.filename().string()).string(), settings.size, clip_options);
  outputs::VideoWriter masks(folder.add(masks_path.filename().string()).string(), settings.size, mask_options);
  const auto truth_file = folder.add(truth_path.filename().string());

  nlohmann::ordered_json truth;
  truth["made_by"] = fmt::format("choreoscope synth '{}'", options.script);
  truth["script"] = request.script;
  truth["summary"] = performer.script().facts().summary;
  truth["size"] = {settings.size.width, settings.size.height};
  truth["fps"] = settings.fps;
  truth["units"] = "root in body heights, joints in degrees";
  auto& frames = truth["frames"] = nlohmann::ordered_json::array();

  const auto stop = session.interrupt.orderly();
  for (int i = 0; i < performer.frame_count(); ++i) {
    // Half a clip is no clip: its truth would be of another length than its script says.
    if (stop.stop_requested()) throw Interrupted{};
    const auto performance = performer.perform(i);
    clip.write(performance.bgr, performance.time);
    masks.write(performance.mask, performance.time);
    frames.push_back(truth_of(performance, i));
    session.console.progress("filming " + request.script, double(i) / double(performer.frame_count()));
  }
  session.console.finish_progress();
  outputs::write_file(truth_file, truth.dump(1) + "\n");
  clip.close();
  masks.close();
  folder.commit();
  fmt::print("{}\n{}\n{}\n", clip_path.string(), masks_path.string(), truth_path.string());
  return kDone;
}

}  // namespace

void declare_synth(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<SynthOptions>();
  auto* command = app.add_subcommand("synth", "film the synthetic performer, with the truth about every frame");
  std::string scripts;
  for (const auto& facts : devices::synthetic::all_scripts()) {
    scripts += fmt::format("\n  {:<22}{}", facts.name, facts.summary);
  }
  command->add_option("SCRIPT", options->script, "what is performed, with settings: walking?seed=2")->required();
  command->add_option("-o,--out", options->out, "the clip to write, .mkv or .mp4")->required()->type_name("CLIP");
  command->footer(std::string(kSynthManual) + "\n\nScripts:" + scripts);
  command->callback([options, &chosen] { chosen = [options](Session& session) { return synth(*options, session); }; });
}

}  // namespace choreo::cli

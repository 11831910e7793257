// `replay` as a program: pictures that are the same on every run, one JSON document, and what it refuses.
// Mirrors app/commands/replay.cpp.
#include "app/frames/recording_writer.h"

#include <sys/stat.h>

#include "app/scene/scene.h"
#include "cli.h"
#include "render/march/marcher_cpu.h"

namespace warpscope {
namespace {

class Replay : public CommandLine {
 protected:
  /// A second: one frame, the camera turning.
  void record(const std::string& name, int segments = 4, const std::string& text = "") {
    SceneOverrides overrides;
    overrides.proceduralDims = {16, 16, 16};
    const Scene scene = openScene("shells", overrides);
    RecordingWriter writer(folder_.file(name), scene, text);
    const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
    for (int i = 0; i <= 10; ++i) {
      View view = scene.views.front();
      view.angleDeg += 2.0 * i;
      writer.addView(0.1 * i, view);
      MarchSettings settings = scene.march;
      settings.sample.segments = segments;
      if (i == 2) writer.addFrame(0.2, std::make_shared<SampleFrame>(marcher->march(makeCamera(scene, view, 32, 32), settings)));
    }
  }
};

TEST_F(Replay, PicturesAreNumberedAndTheSameOnEveryRun) {
  record("a.warpscope");
  const nlohmann::json report = document({"replay", "a.warpscope", "--out", "one", "--size", "24x16", "--fps", "5", "--techniques", "hold,spheres", "--json"});
  EXPECT_EQ(report["pictures"], 6);
  EXPECT_EQ(report["frames"], 1);
  EXPECT_EQ(report["techniques"], (nlohmann::json{"hold", "spheres"}));
  EXPECT_TRUE(report["video"].is_null());
  succeed({"replay", "a.warpscope", "--out", "two", "--size", "24x16", "--fps", "5", "--techniques", "hold,spheres"});
  for (const char* name : {"000001.png", "000003.png", "000006.png"}) {
    ASSERT_TRUE(std::filesystem::exists(folder_.file(std::string("one/") + name)));
    EXPECT_EQ(picture(std::string("one/") + name), picture(std::string("two/") + name)) << name;
  }
  EXPECT_NE(picture("one/000003.png"), picture("one/000006.png"));
  EXPECT_FALSE(std::filesystem::exists(folder_.file("one/000007.png")));
  // Into the same folder: what else is there stays, and one is told of what could be taken for more of this run.
  folder_.write("one/mine.png", "my own");
  const Image<Rgba8> sixth = picture("one/000006.png");
  const ProgramResult shorter = run({"replay", "a.warpscope", "--out", "one", "--size", "24x16", "--fps", "2", "--techniques", "hold"});
  EXPECT_EQ(shorter.code, kSuccess) << shorter.err;
  EXPECT_THAT(shorter.err, testing::HasSubstr("000004.png to 000006.png were there before, and are not of this recording"));
  EXPECT_EQ(picture("one/000006.png"), sixth);
  EXPECT_EQ(folder_.read("one/mine.png"), "my own");
}

TEST_F(Replay, WithoutTheProgramForFilmsPicturesAreThereAllTheSame) {
  record("a.warpscope");
  const ProgramResult result = run({"replay", "a.warpscope", "--out", "one", "--size", "24x16", "--fps", "2", "--techniques", "hold", "--video", "mp4"}, {"PATH=" + folder_.file("nowhere")});
  EXPECT_EQ(result.code, kFailure);
  EXPECT_THAT(result.err, testing::HasSubstr("needs the program ffmpeg, which is not installed. The numbered pictures are in one"));
  EXPECT_TRUE(std::filesystem::exists(folder_.file("one/000003.png")));
}

TEST_F(Replay, WhatPanelsShowedIsShownWhereThatCanBe) {
  const auto sessionOf = [](const std::string& scene, const std::string& content) {
    return R"({"warpscopeSession": 1, "origin": {"scene": ")" + scene + R"(", "volumeSize": [16, 16, 16], "seed": 1}, "view": {}, "march": {}, "panels": [{"technique": "hold", "content": ")" + content + "\"}]}";
  };
  record("flip.warpscope", 4, sessionOf("shells", "flip"));
  record("gone.warpscope", 4, sessionOf("gone.json", "flip"));
  record("unknown.warpscope", 4, sessionOf("shell", "flip"));
  record("picture.warpscope", 4, sessionOf("shells", "picture"));
  const auto replayed = [&](const std::string& name) { return Arguments{"replay", name + ".warpscope", "--out", name, "--size", "24x24", "--fps", "1", "--no-labels"}; };
  succeed(replayed("flip"));
  succeed(replayed("picture"));
  EXPECT_NE(picture("flip/000002.png"), picture("picture/000002.png"));
  for (const std::string name : {"gone", "unknown"}) {
    const ProgramResult result = run(replayed(name));
    EXPECT_EQ(result.code, kSuccess);
    EXPECT_THAT(result.err, testing::HasSubstr("warning: pictures in place of what was on show: "));
    EXPECT_EQ(picture(name + "/000002.png"), picture("picture/000002.png"));
  }
}

TEST_F(Replay, WhatIsWrongIsRefused) {
  record("a.warpscope");
  expectRefused({"replay", "a.warpscope"}, kUsage, {"--out"});
  expectRefused({"replay", "missing", "--out", "o"}, kFailure, {"there is no such file"});
  expectRefused({"replay", "a.warpscope", "--out", "o", "--fps", "0"}, kUsage, {"--fps must be between"});
  expectRefused({"replay", "a.warpscope", "--out", "o", "--video", "avi"}, kUsage, {"mp4 or gif"});
  expectRefused({"replay", "a.warpscope", "--out", "o", "--techniques", "sphere"}, kUsage, {"spheres"});
  expectRefused({"replay", "a.warpscope", "--out", "o", "--techniques", "hold", "--show", "flipp"}, kUsage, {"flip"});
  expectRefused({"replay", "a.warpscope", "--out", "o", "--techniques", "hold", "--show", "depth,opacity"}, kUsage, {"--show: one for all"});
  expectRefused({"replay", "a.warpscope", "--out", "o", "--techniques", "hold", "--show", "opacity", "--range", "0"}, kUsage, {"--range must be between"});
  expectRefused({"replay", "a.warpscope", "--out", "o", "--techniques", "hold", "--range", "1"}, kUsage, {"choose one with --show"});
  expectRefused({"replay", "a.warpscope", "--out", "o", "--techniques", "hold", "--show", "flip"}, kFailure, {"does not say of which scene it is"});
  expectRefused({"replay", "a.warpscope", "--out", "o", "--techniques", "hold", "--show", "segments"}, kFailure, {"Segments: hold draws none"});
  succeed({"replay", "a.warpscope", "--out", "shown", "--techniques", "hold", "--show", "opacity", "--range", "0.5", "--fps", "1", "--size", "24x16"});
  expectRefused({"replay", "a.warpscope", "--out", "o", "--techniques", "reference"}, kFailure, {"does not say of which scene it is"});
  expectRefused({"replay", "a.warpscope", "--out", "o", "--techniques", "hold", "--errors"}, kFailure, {"does not say of which scene it is"});
  record("without.warpscope", 0);
  {
    RecordingWriter writer(folder_.file("bare.warpscope"), openScene("block", {}), "");
    writer.addView(0.0, {});
  }
  expectRefused({"replay", "bare.warpscope", "--out", "o", "--techniques", "hold"}, kFailure, {"holds no frames"});
  ASSERT_EQ(mkfifo(folder_.file("pipe").c_str(), 0600), 0);
  expectRefused({"replay", "pipe", "--out", "o"}, kFailure, {"is no regular file"});
  for (const Arguments& command : {Arguments{"shot", "a.warpscope", "-o", "a.png"}, Arguments{"plan", "a.warpscope"}}) expectRefused(command, kFailure, {"is a recording, which view and replay show"});
  for (const char* option : {"--fov", "--step"}) expectRefused({"view", "a.warpscope", option, "3"}, kUsage, {"a recording says that itself", option});
  expectRefused({"view", "a.warpscope", "--record", "a.warpscope"}, kUsage, {"is read here"});
  expectRefused({"replay", "without.warpscope", "--out", "o", "--techniques", "hold,segments"}, kFailure, {"segments can show nothing of its frames", "--segments"});
  EXPECT_FALSE(std::filesystem::exists(folder_.file("o")));
}

}  // namespace
}  // namespace warpscope

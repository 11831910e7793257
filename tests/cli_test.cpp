// The command line's contract, through the built program: exit codes, JSON, files, and that they are there whole or not at all.
// docs: the contract is in README; refusals of wrong input are in cli_refusal_test.cpp.
#include <thread>
#include <sstream>

#include "app/picture/content.h"
#include "app/scene/scene.h"
#include "render/march/march_settings.h"
#include "render/warp/warp.h"
#include "tests/cli.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

size_t opaqueOrNot(const Image<Rgba8>& image) {
  return static_cast<size_t>(std::count_if(image.begin(), image.end(), [](Rgba8 pixel) { return pixel >> 24 != 0; }));
}

// --- info, help, version

TEST_F(CommandLine, InfoListsWhatThereIs) {
  const json info = document({"info", "--json"});
  for (const char* key : {"version", "backends", "openGl", "cuda", "techniques", "heuristics", "radiusPolicies", "scenes", "tortureScenes", "volumeFormats"})
    EXPECT_TRUE(info.contains(key)) << key;
  EXPECT_EQ(info["techniques"].size(), warpRegistry().size());
  EXPECT_EQ(info["heuristics"].size(), kHeuristics.size());
  EXPECT_EQ(info["scenes"].size(), builtinScenes().size());
  EXPECT_EQ(info["tortureScenes"].size(), tortureScenes().size());
  EXPECT_EQ(info["volumeFormats"][0], ".raw");
  EXPECT_THAT(info["backends"], testing::Contains("cpu"));
  EXPECT_EQ(info["cuda"].contains("unavailable"), info["cuda"]["devices"].empty());

  const ProgramResult text = succeed({"info"});
  std::string techniques = "techniques:";
  for (const WarpDescriptor& technique : warpRegistry()) techniques += " " + std::string(technique.name);
  EXPECT_THAT(text.out, testing::HasSubstr(techniques + "\n"));
  EXPECT_THAT(text.out, testing::Not(testing::HasSubstr(" \n")));
  EXPECT_THAT(text.out, testing::Not(testing::HasSubstr("driver version is insufficient")));
  EXPECT_EQ(text.err, "");
}

TEST_F(CommandLine, HelpAndVersionSucceed) {
  EXPECT_THAT(succeed({"--version"}).out, testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+\n"));
  const std::string help = succeed({"--help"}).out;
  for (const char* command : {"serve", "shot", "compare", "bench", "export", "info"}) {
    EXPECT_THAT(help, testing::HasSubstr(command));
    const ProgramResult result = succeed({command, "--help"});
    EXPECT_THAT(result.out, testing::HasSubstr("--json"));
    EXPECT_EQ(result.err, "");
  }
  EXPECT_TRUE(folder_.listing().empty());

  // Broken into lines as the terminal takes them.
  std::istringstream words(succeed({"shot", "--help"}).out);
  std::string shot;
  for (std::string word; words >> word;) shot += word + " ";
  for (const char* text : {"-360 to 360", "0.001 to 170; default: the scene's", "in edges of the smallest voxel, 0.001 to 1000; default: the scene's",
                           "Factor on the radius, 0.001 to 1000; default: the scene's", "random in the built-in volumes vessels and shells"})
    EXPECT_THAT(shot, testing::HasSubstr(text));
}

// --- shot

TEST_F(CommandLine, ShotWithEveryTechniqueAndPlatform) {
  for (const WarpDescriptor& technique : warpRegistry())
    for (const std::string platform : {"egl", "osmesa", "auto"}) {
      if (!technique.usesOpenGl && platform != "auto") continue;
      const std::string name = std::string(technique.name) + "-" + platform + ".png";
      const json report = document(quick({"shot", "block", "--technique", std::string(technique.name), "--view-angle", "20", "--gl", platform,
                                          "-o", name, "--json"}, "61x43"));
      EXPECT_EQ(report["out"], name);
      EXPECT_EQ(report["technique"], technique.name);
      EXPECT_EQ(report["viewAngleDeg"], 20.0);
      EXPECT_EQ(report["samples"].get<size_t>() > 0, technique.usesFrame);
      const Image<Rgba8> image = picture(name);
      EXPECT_EQ(image.width(), 61u);
      EXPECT_EQ(image.height(), 43u);
      EXPECT_GT(opaqueOrNot(image), 300u) << name;
    }
  size_t ofOpenGl = 0;
  for (const WarpDescriptor& technique : warpRegistry()) {
    if (!technique.usesOpenGl) continue;
    ++ofOpenGl;
    const std::string name(technique.name);
    EXPECT_EQ(picture(name + "-egl.png"), picture(name + "-osmesa.png")) << name;
  }
  EXPECT_EQ(folder_.listing().size(), warpRegistry().size() + 2 * ofOpenGl) << "OpenGL's on three platforms, all others on one";
}

TEST_F(CommandLine, ShotTakesEveryOption) {
  const std::vector<Arguments> options{
      {"--via", "auto"}, {"--via", "embree"}, {"--via", "lbvh"}, {"--via", "footprints"}, {"--radius-scale", "1.5"}, {"--step", "0.25"}, {"--fov", "75.5"}, {"--backend", "cpu"},
      {"--backend", "auto"}, {"--seed", "7"}, {"--uncovered", "ff00ff"}, {"--view-angle", "-360"}, {"--point-size", "16"}, {"--hits", "1"}, {"--hits", "16"},
      {"--fill", "pull-push"}, {"--filled", "00ff00"}, {"--keep", "8"}, {"--picture-plane", "infinity"}, {"--mesh-cut", "0.5"},
      {"--verbose"}};
  for (const Arguments& option : options) {
    Arguments arguments = quick({"shot", "shells", "-o", "a.png", "--quiet"}, "1x1");
    arguments.insert(arguments.end(), option.begin(), option.end());
    const ProgramResult result = succeed(arguments);
    EXPECT_EQ(result.out + result.err, "");
    EXPECT_EQ(picture("a.png").size(), 1u);
  }
  for (const auto& heuristic : kHeuristics)
    succeed(quick({"shot", "shells", "-o", "a.png", "--heuristic", std::string(heuristic.name)}, "3x2"));
  for (const auto& policy : kRadiusPolicies)
    succeed(quick({"shot", "shells", "-o", "a.png", "--radius", std::string(policy.name)}, "2x3"));
  EXPECT_EQ(folder_.listing(), std::vector<std::string>{"a.png"});
}

// --- bench

TEST_F(CommandLine, BenchMeasuresEveryTechniqueThatDrawsFrames) {
  const json report = document(quick({"bench", "block", "--backend", "cpu", "--runs", "3", "--json"}, "96x64"));
  for (const char* key : {"device", "backend", "samples", "marchMs", "compactMs", "copyMs", "serverMs", "encodeMs", "bytes", "buildMs", "views",
                          "techniques", "scene", "width", "height", "step", "heuristic", "radius", "runs", "version", "backends"})
    EXPECT_TRUE(report.contains(key)) << key;
  EXPECT_EQ(report["backend"], "cpu");
  EXPECT_EQ(report["rawBytes"], 12 * report["samples"].get<size_t>());
  EXPECT_LT(report["bytes"], report["rawBytes"]);
  EXPECT_GT(report["encodeMs"].get<double>(), 0.0);
  EXPECT_GT(report["decodeMs"].get<double>(), 0.0);
  EXPECT_GT(report["marchMs"].get<double>(), 0.0);
  EXPECT_GE(report["serverMs"].get<double>(), report["marchMs"].get<double>());
  ASSERT_EQ(report["backends"].size(), 1u);
  size_t drawing = 0;
  for (const WarpDescriptor& technique : warpRegistry()) drawing += technique.usesFrame;
  ASSERT_EQ(report["techniques"].size(), drawing);
  for (const json& technique : report["techniques"]) {
    ASSERT_EQ(technique["views"].size(), 5u);
    EXPECT_GE(technique["firstPictureMs"].get<double>(), technique["buildMs"].get<double>());
    EXPECT_EQ(technique.contains("marchMs"), technique["technique"] == "segments" || technique["technique"] == "proxy") << technique["technique"];
    if (technique["technique"] == "segments") {
      EXPECT_GT(technique["marchMs"].get<double>(), 0.0);
      EXPECT_GT(technique["bytes"], report["bytes"]);
    }
    for (const json& view : technique["views"]) {
      EXPECT_GT(view["drawMs"].get<double>(), 0.0);
      EXPECT_NEAR(view["fps"].get<double>() * view["drawMs"].get<double>(), 1000.0, 1e-6);
    }
    if (technique["technique"] == "spheres") EXPECT_EQ(technique["views"], report["views"]);
  }
  EXPECT_TRUE(folder_.listing().empty());
}

TEST_F(CommandLine, BenchOfChosenTechniquesAsText) {
  const ProgramResult result = succeed(quick({"bench", "block", "--backend", "cpu", "--runs", "1", "--technique", "splats"}, "64x64"));
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, testing::HasSubstr("splats"));
  EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("spheres")));
}

TEST_F(CommandLine, BenchBesideAnEarlierRun) {
  const std::vector<std::string> bench = quick({"bench", "block", "--backend", "cpu", "--runs", "3", "--technique", "splats", "--json"}, "64x64");
  std::ofstream(folder_.path() / "then.json") << succeed(bench).out;
  std::vector<std::string> again = bench;
  again.insert(again.end(), {"--against", (folder_.path() / "then.json").string()});
  const json report = document(again);
  ASSERT_GT(report["against"]["figures"].size(), 10u);
  for (const json& figure : report["against"]["figures"])
    if (figure["what"] == "bytes") EXPECT_EQ(figure["verdict"], "the same") << figure;
  EXPECT_TRUE(report["against"]["onlyBefore"].empty());
  EXPECT_TRUE(report["against"]["onlyNow"].empty());
  EXPECT_TRUE(report["against"]["differences"].empty());
  std::erase(again, "--json");
  EXPECT_THAT(succeed(again).err, testing::AllOf(testing::HasSubstr("against "), testing::HasSubstr("cpu: splats, 25°\n  drawMs ")));

  std::vector<std::string> smaller = again;
  std::ranges::replace(smaller, "64x64", "32x64");
  const ProgramResult refused = run(smaller);
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, testing::HasSubstr("then.json: width was 64 then and is 32 now"));
}

TEST_F(CommandLine, BenchMeasuresEffectsAloneTogetherAndLeftOut) {
  const json report = document(quick({"bench", "block", "--backend", "cpu", "--runs", "3", "--effects", "--shading", "0.5", "--json"}, "96x64"));
  ASSERT_EQ(report["backends"].size(), 1u);
  const json& cpu = report["backends"][0];
  EXPECT_EQ(cpu["backend"], "cpu");
  EXPECT_GT(cpu["noneMs"].get<double>(), 0.0);
  EXPECT_GT(cpu["allMs"].get<double>(), 0.0);
  std::vector<std::string> names;
  for (const json& effect : cpu["effects"]) {
    names.push_back(effect["effect"]);
    EXPECT_EQ(effect["isExample"], names.back() != "shading");
    for (const char* key : {"marchMs", "leftOutMs"}) EXPECT_GT(effect[key].get<double>(), 0.0) << key;
    for (const char* key : {"marchSpreadMs", "addsMs", "addsSpreadMs", "leftOutSpreadMs", "savesMs", "savesSpreadMs"}) EXPECT_TRUE(effect.contains(key)) << key;
  }
  EXPECT_THAT(names, testing::IsSupersetOf({"shading", "clip-planes", "clip-box", "slab"}));

  EXPECT_THAT(succeed(quick({"bench", "block", "--backend", "cpu", "--runs", "1", "--effects"}, "64x64")).err, testing::HasSubstr("all but shading"));
  const ProgramResult refused = run(quick({"bench", "block", "--effects", "--technique", "splats"}, "64x64"));
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, testing::HasSubstr("--effects measures marches: it takes no --technique"));
}

TEST_F(CommandLine, UncoveredPixelsTakeTheColourThatIsAskedFor) {
  succeed(quick({"shot", "block", "--view-angle", "40", "-o", "plain.png"}));
  succeed(quick({"shot", "block", "--view-angle", "40", "-o", "marked.png", "--uncovered", "#12ab34"}));
  const Image<Rgba8> plain = picture("plain.png"), marked = picture("marked.png");
  size_t uncovered = 0;
  for (size_t i = 0; i < plain.size(); ++i) {
    uncovered += marked[i] == 0xff34ab12u;
    EXPECT_EQ(marked[i] == 0xff34ab12u ? 0u : marked[i], plain[i]);
  }
  EXPECT_GT(uncovered, 100u);
}

TEST_F(CommandLine, ShotShowsWhatIsAskedFor) {
  const auto shown = [&](const std::string& content, const Arguments& more = {}) {
    Arguments arguments = quick({"shot", "block", "--technique", "spheres", "--view-angle", "20", "--show", content, "-o", content + ".png", "--json"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return document(arguments);
  };
  std::vector<std::string> pictures;
  for (const ContentDescriptor& content : pictureContents()) {
    if (content.value == PictureContent::segments) continue;  // below
    const nlohmann::json report = shown(std::string(content.name));
    EXPECT_EQ(report["show"]["content"], content.name);
    EXPECT_EQ(report["show"].contains("high"), !content.unit.empty()) << content.name;
    const Image<Rgba8> picture = readPng(folder_.path() / (std::string(content.name) + ".png"));
    pictures.emplace_back(reinterpret_cast<const char*>(picture.data()), picture.size() * sizeof(Rgba8));
    for (size_t other = 0; other + 1 < pictures.size(); ++other) EXPECT_NE(pictures[other], pictures.back()) << content.name << " and " << other;
  }
  EXPECT_EQ(shown("flip", {"--range", "0.25"})["show"]["high"], 0.25);
  EXPECT_GT(shown("depth")["show"]["low"], 0.0);
  expectRefused(quick({"shot", "block", "--technique", "spheres", "--show", "segments", "-o", "no.png"}), kFailure, {"draws no segments"});
  const auto shownOfSegments = [&](const std::string& content) {
    return document(quick({"shot", "block", "--technique", "segments", "--view-angle", "20", "--show", content, "-o", "s.png", "--json"}));
  };
  EXPECT_GE(shownOfSegments("segments")["show"]["high"], 1.0);
  EXPECT_GT(shownOfSegments("depth")["show"]["low"], 0.0);
}

TEST_F(CommandLine, TheSameCommandGivesTheSameBytes) {
  for (const WarpDescriptor& technique : warpRegistry()) {
    std::string first;
    for (const char* threads : {"LP_NUM_THREADS=0", "LP_NUM_THREADS=1", "LP_NUM_THREADS=4"}) {
      succeed(quick({"shot", "vessels", "--technique", std::string(technique.name), "--view-angle", "10", "-o", "a.png"}, "97x101"), {threads});
      const std::string bytes = folder_.read("a.png");
      if (first.empty()) first = bytes;
      EXPECT_TRUE(bytes == first) << technique.name << ", " << threads;
    }
  }
}

TEST_F(CommandLine, ShotReplacesWhatIsThereAndFollowsLinks) {
  folder_.write("old.png", "old");
  fs::create_symlink("old.png", folder_.path() / "link.png");
  succeed(quick({"shot", "-o", "link.png"}));
  EXPECT_TRUE(fs::is_symlink(folder_.path() / "link.png"));
  EXPECT_EQ(picture("old.png").width(), 40u);
  // Something that is no file is written to, never replaced.
  fs::create_symlink("/dev/null", folder_.path() / "nowhere");
  succeed(quick({"shot", "-o", "nowhere"}));
  EXPECT_TRUE(fs::is_symlink(folder_.path() / "nowhere"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

/// The example of assets/scenes/README.md, as it stands there.
TEST_F(CommandLine, TheSceneThatTheDocumentationShowsIsOne) {
  std::ifstream file(fs::path(WARPSCOPE_SCENES_FOLDER) / "README.md");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::string opening = "```json\n";
  const size_t begin = text.find(opening), end = text.find("```", begin + opening.size());
  ASSERT_NE(end, std::string::npos);
  folder_.write("engine.json", text.substr(begin + opening.size(), end - begin - opening.size()));
  folder_.write("engine_256x256x128_uint8.raw", "");
  fs::resize_file(folder_.path() / "engine_256x256x128_uint8.raw", 256 * 256 * 128);
  succeed({"shot", "engine.json", "-o", "a.png", "--size", "16x12"});
}

// --- what is said about the work

TEST_F(CommandLine, VerboseSaysWhatIsDoneAndQuietNothing) {
  const Arguments shot = quick({"shot", "block", "--technique", "points", "-o", "a.png"});
  const auto with = [&](const Arguments& more) {
    Arguments arguments = shot;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return succeed(arguments);
  };
  const ProgramResult plain = with({}), verbose = with({"--verbose"}), json = with({"--verbose", "--json"});
  EXPECT_EQ(plain.err, "wrote a.png\n");
  EXPECT_EQ(plain.out + verbose.out, "");
  for (const char* detail : {"volume block: 24x22x20 voxels of uint8, values ", "opened in ", "backend: cpu", "OpenGL: ", "marched ", " samples of 40x30 pixels in ",
                             "compacted in ", "wrote a.png"})
    EXPECT_THAT(verbose.err, testing::HasSubstr(detail));
  EXPECT_THAT(json.err, testing::HasSubstr("marched "));
  EXPECT_TRUE(json::accept(json.out)) << json.out;
  EXPECT_EQ(with({"--quiet"}).err + with({"--quiet", "--verbose"}).err, "");
  EXPECT_THAT(succeed({"info", "--verbose"}).err, testing::HasSubstr("EGL"));
}

TEST_F(CommandLine, ShotWritesWhatTheNameSays) {
  const auto beginOf = [&](const std::string& file) {
    succeed({"shot", "-o", file, "--size", "24x16", "--volume-size", "16x16x16"});
    return folder_.read(file).substr(0, 4);
  };
  const std::string png = "\x89PNG", jpeg = "\xff\xd8\xff\xe0";
  for (const char* file : {"a.png", "b.PNG", "without"}) EXPECT_EQ(beginOf(file), png) << file;
  for (const char* file : {"a.jpg", "b.jpeg", "c.JPG"}) EXPECT_EQ(beginOf(file), jpeg) << file;
  const std::string whole = folder_.read("a.jpg");
  EXPECT_EQ(whole.substr(whole.size() - 2), "\xff\xd9") << "to its end";
}

/// Voxels of 1 x 1 x 100: no radius that is the same for all samples fits.
TEST_F(CommandLine, VoxelsThatAreFarLongerThanWideAreWarnedAbout) {
  const auto errOf = [&](const std::string& depth, const char* radius) {
    folder_.write("long.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nspacings: 1 1 " + depth + "\nencoding: raw\n\n" + std::string(512, '\x7f'));
    return succeed({"shot", "long.nrrd", "--radius", radius, "-o", "a.png", "--size", "9x9"}).err;
  };
  const std::string said = "warning: the voxels' edges are 1 x 1 x 100: ";
  EXPECT_THAT(errOf("100", "voxel"), testing::HasSubstr(said + "spheres of half a voxel's diagonal are far larger than its short edges; --radius pixel"));
  EXPECT_THAT(errOf("100", "constant"), testing::HasSubstr(said + "spheres of half the shortest edge leave gaps along the long ones; --radius pixel"));
  EXPECT_THAT(errOf("100", "opacity"), testing::HasSubstr(said + "opaque samples' spheres, of half a voxel's diagonal"));
  EXPECT_THAT(errOf("100", "pixel"), testing::Not(testing::HasSubstr("voxels' edges")));
  EXPECT_THAT(errOf("2", "voxel"), testing::Not(testing::HasSubstr("voxels' edges"))) << "twice as long is not far longer";
}

/// A picture of nothing is a picture, but hardly what was wanted.
TEST_F(CommandLine, VolumesOfWhichNothingIsVisibleAreWarnedAbout) {
  const auto function = [&](const std::string& points) { folder_.write("tf.json", "{\"points\": [" + points + "]}"); };
  const auto point = [](const std::string& value, const std::string& alpha) {
    return "{\"value\": " + value + ", \"color\": [1, 1, 1], \"alpha\": " + alpha + "}";
  };
  std::vector<float> ramp(64);
  for (size_t i = 0; i < ramp.size(); ++i) ramp[i] = static_cast<float>(i);
  const std::vector<float> nothing(64, std::nanf(""));
  const auto bytes = [](const std::vector<float>& values) { return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)); };
  folder_.write("ramp_4x4x4_float32.raw", bytes(ramp));
  folder_.write("nan_4x4x4_float32.raw", bytes(nothing));
  const auto errOf = [&](const std::string& volume, const Arguments& more) {
    Arguments arguments{"shot", volume, "-o", "a.png", "--size", "9x9"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return succeed(arguments).err;
  };
  const std::string said = "warning: nothing of the volume ramp_4x4x4_float32.raw is visible with this transfer function\nwrote a.png\n";
  for (const std::string& points : {point("0", "0"), point("-2", "1") + "," + point("-1", "0"), point("63.5", "0") + "," + point("64", "1")}) {
    function(points);
    EXPECT_EQ(errOf("ramp_4x4x4_float32.raw", {"--tf", "tf.json"}), said) << points;
  }
  for (const std::string& points : {point("0", "0.1"), point("30", "0") + "," + point("30.5", "1") + "," + point("31", "0"), point("62", "0") + "," + point("64", "1")}) {
    function(points);
    EXPECT_EQ(errOf("ramp_4x4x4_float32.raw", {"--tf", "tf.json"}), "wrote a.png\n") << points;
  }
  EXPECT_EQ(errOf("nan_4x4x4_float32.raw", {}), "warning: nothing of the volume nan_4x4x4_float32.raw is visible with this transfer function: "
                                                "none of its values is finite\nwrote a.png\n");
  EXPECT_EQ(errOf("nan_4x4x4_float32.raw", {"--quiet"}), "");
}

TEST_F(CommandLine, ARawVolumeLargerThanTheMemoryItMayTakeIsShown) {
  const auto limit = 220 + 30 * static_cast<int>(std::thread::hardware_concurrency());
  if (limit > 600) GTEST_SKIP() << "so many threads read more at once than the volume of this test has";
  const std::string name = "tall_2048x2048x100_uint16.raw";
  {
    std::ofstream file(folder_.file(name), std::ios::binary);
    std::vector<uint16_t> slice(2048 * 2048);
    for (int z = 0; z < 100; ++z) {
      for (size_t i = 0; i < slice.size(); ++i) slice[i] = static_cast<uint16_t>((i % 2048) * 9 + (i / 2048 % 300) * 40 + static_cast<size_t>(z) * 100);
      file.write(reinterpret_cast<const char*>(slice.data()), static_cast<std::streamsize>(slice.size() * sizeof slice[0]));
    }
  }
  const auto shot = [&](const std::string& picture, const std::string& memory) { return Arguments{"shot", name, "--size", "256x256", "-o", picture, "--memory", memory}; };
  // Whatever is asked of the volume; its file has just been written, so that the system may map much of it at once.
  const auto within = [&](const std::string& picture, const Arguments& way) {
    Arguments arguments = shot(picture, std::to_string(limit));
    arguments.insert(arguments.end(), way.begin(), way.end());
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.code, kSuccess) << result.err;
    EXPECT_LT(result.peakKiB, limit * 1024) << "of 800 MiB of voxels";
  };
  within("a.png", {});
  const ProgramResult alone = run(shot("b.png", "1e6"));
  EXPECT_EQ(picture("a.png"), picture("b.png"));
  EXPECT_GT(alone.peakKiB, 700 * 1024) << "or all of this would fit anyway";
  within("c.png", {"--mode", "isosurface", "--isovalues", "9000"});
  within("d.png", {"--shading", "1", "--shadows", "1", "--light-grid", "64"});
  expectRefused({"shot", name, "--size", "256x256", "--ray", "128,128", "--memory", std::to_string(limit)}, kFailure, {name, "a ray is looked at as a whole", "--memory is to be at least 3200 "});
  expectRefused(shot("e.png", "128"), kFailure, {name, "the limit of 128 MiB of memory cannot be kept to: with what is looked at at once it takes "});
  expectRefused(shot("e.png", "127"), kUsage, {"--memory must be between 128 and"});
  expectRefused({"shot", name, "--device-memory", "0", "-o", "e.png"}, kUsage, {"--device-memory must be between 64 and"});
  // The same voxels under a header, which are read by rows; those of a format whose rows are not certain have to fit.
  folder_.write("tall.nhdr", "NRRD0004\ntype: ushort\ndimension: 3\nsizes: 2048 2048 100\nendian: little\nencoding: raw\ndata file: " + name + "\n");
  folder_.write("tall.vtk",
                "# vtk DataFile Version 3.0\ntall\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2048 2048 100\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 419430400\n"
                "SCALARS values unsigned_short 1\nLOOKUP_TABLE default\n");
  std::filesystem::resize_file(folder_.file("tall.vtk"), std::filesystem::file_size(folder_.file("tall.vtk")) + std::filesystem::file_size(folder_.file(name)));
  const Arguments rows{"shot", "tall.nhdr", "--size", "256x256", "-o", "f.png", "--memory", std::to_string(limit)};
  const ProgramResult byRows = run(rows);
  EXPECT_EQ(byRows.code, kSuccess) << byRows.err;
  EXPECT_LT(byRows.peakKiB, limit * 1024);
  EXPECT_EQ(picture("f.png"), picture("a.png"));
  expectRefused({"shot", "tall.vtk", "--memory", std::to_string(limit), "-o", "g.png"}, kFailure, {"tall.vtk: it needs 800 MiB of memory, and of the " + std::to_string(limit) + " MiB that it may have"});
}

TEST_F(CommandLine, ABuiltInVolumeLargerThanTheMemoryItMayTakeIsMadeSlabBySlab) {
  const auto shot = [](const std::string& picture, const std::string& memory) {
    return Arguments{"shot", "marschner-lobb", "--volume-size", "300x300x3600", "--size", "200x200", "--technique", "segments", "-o", picture, "--memory", memory};
  };
  constexpr int kLimit = 300;
  const ProgramResult limited = run(shot("a.png", std::to_string(kLimit))), alone = run(shot("b.png", "1e6"));
  EXPECT_EQ(limited.code, kSuccess) << limited.err;
  EXPECT_LT(limited.peakKiB, kLimit * 1024);
  EXPECT_GT(alone.peakKiB, kLimit * 1024) << "or all of this would fit anyway";
  EXPECT_EQ(picture("a.png"), picture("b.png"));
}

}  // namespace
}  // namespace warpscope

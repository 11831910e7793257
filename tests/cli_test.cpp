// The command line's contract, through the built program: exit codes, JSON, files, and that they are there whole or not at all.
// docs: the contract is in README; refusals of wrong input are in cli_refusal_test.cpp.
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <sstream>

#include "app/picture.h"
#include "app/scene.h"
#include "render/march/march_settings.h"
#include "render/warp/warp.h"
#include "tests/cli.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

Image<Rgba8> picture(const TestFolder& folder, const std::string& name) { return readPng(folder.file(name)); }

size_t opaqueOrNot(const Image<Rgba8>& image) {
  return static_cast<size_t>(std::count_if(image.begin(), image.end(), [](Rgba8 pixel) { return pixel >> 24 != 0; }));
}

// --- info, help, version

TEST_F(CommandLine, InfoListsWhatThereIs) {
  const json info = document({"info", "--json"});
  for (const char* key : {"version", "backends", "openGl", "cuda", "techniques", "heuristics", "radiusPolicies", "scenes", "volumeFormats"})
    EXPECT_TRUE(info.contains(key)) << key;
  EXPECT_EQ(info["techniques"].size(), warpRegistry().size());
  EXPECT_EQ(info["heuristics"].size(), kHeuristics.size());
  EXPECT_EQ(info["scenes"].size(), builtinScenes().size());
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
  for (const char* text : {"-360 to 360", "1 to 170; default: the scene's", "in voxels, 0.001 to 1000; default: the scene's",
                           "Factor on the radius, 0.001 to 1000; default: the scene's", "random in the built-in volumes vessels and shells"})
    EXPECT_THAT(shot, testing::HasSubstr(text));
}

// --- shot

TEST_F(CommandLine, ShotWithEveryTechniqueAndPlatform) {
  for (const WarpDescriptor& technique : warpRegistry())
    for (const std::string platform : {"egl", "osmesa", "auto"}) {
      if (technique.name != "points" && platform != "auto") continue;  // the others need no OpenGL
      const std::string name = std::string(technique.name) + "-" + platform + ".png";
      const json report = document(quick({"shot", "block", "--technique", std::string(technique.name), "--view-angle", "20", "--gl", platform,
                                          "-o", name, "--json"}, "61x43"));
      EXPECT_EQ(report["out"], name);
      EXPECT_EQ(report["technique"], technique.name);
      EXPECT_EQ(report["viewAngleDeg"], 20.0);
      EXPECT_EQ(report["samples"].get<size_t>() > 0, technique.usesFrame);
      const Image<Rgba8> image = picture(folder_, name);
      EXPECT_EQ(image.width(), 61u);
      EXPECT_EQ(image.height(), 43u);
      EXPECT_GT(opaqueOrNot(image), 300u) << name;
    }
  EXPECT_EQ(picture(folder_, "points-egl.png"), picture(folder_, "points-osmesa.png"));
  EXPECT_EQ(folder_.listing().size(), warpRegistry().size() + 2) << "points on three platforms, all others on one";
}

TEST_F(CommandLine, ShotTakesEveryOption) {
  const std::vector<Arguments> options{
      {"--bvh", "auto"}, {"--bvh", "embree"}, {"--bvh", "lbvh"}, {"--radius-scale", "1.5"}, {"--step", "0.25"}, {"--fov", "75.5"}, {"--backend", "cpu"},
      {"--backend", "auto"}, {"--seed", "7"}, {"--uncovered", "ff00ff"}, {"--view-angle", "-360"}, {"--point-size", "16"}, {"--hits", "1"}, {"--hits", "16"},
      {"--verbose"}};
  for (const Arguments& option : options) {
    Arguments arguments = quick({"shot", "shells", "-o", "a.png", "--quiet"}, "1x1");
    arguments.insert(arguments.end(), option.begin(), option.end());
    const ProgramResult result = succeed(arguments);
    EXPECT_EQ(result.out + result.err, "");
    EXPECT_EQ(picture(folder_, "a.png").size(), 1u);
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

TEST_F(CommandLine, UncoveredPixelsTakeTheColourThatIsAskedFor) {
  succeed(quick({"shot", "block", "--view-angle", "40", "-o", "plain.png"}));
  succeed(quick({"shot", "block", "--view-angle", "40", "-o", "marked.png", "--uncovered", "#12ab34"}));
  const Image<Rgba8> plain = picture(folder_, "plain.png"), marked = picture(folder_, "marked.png");
  size_t uncovered = 0;
  for (size_t i = 0; i < plain.size(); ++i) {
    uncovered += marked[i] == 0xff34ab12u;
    EXPECT_EQ(marked[i] == 0xff34ab12u ? 0u : marked[i], plain[i]);
  }
  EXPECT_GT(uncovered, 100u);
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
  EXPECT_EQ(picture(folder_, "old.png").width(), 40u);
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
  for (const char* detail : {"volume block: 24x22x20 voxels of uint8, values ", "opened in ", "backend: cpu", "OpenGL: ", "marched ", " samples in ",
                             "compacted in ", "wrote a.png"})
    EXPECT_THAT(verbose.err, testing::HasSubstr(detail));
  EXPECT_THAT(json.err, testing::HasSubstr("marched "));
  EXPECT_TRUE(json::accept(json.out)) << json.out;
  EXPECT_EQ(with({"--quiet"}).err + with({"--quiet", "--verbose"}).err, "");
  EXPECT_THAT(succeed({"info", "--verbose"}).err, testing::HasSubstr("EGL"));
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

// --- compare

TEST_F(CommandLine, CompareWritesPicturesMontageAndMetrics) {
  const json report = document(quick({"compare", "block", "--out", "deep/out", "--json", "--heuristic", "median", "--radius", "pixel"}));
  EXPECT_EQ(json::parse(folder_.read("deep/out/metrics.json")), report);

  const size_t views = openScene("block").views.size();
  std::vector<std::string> expected{"deep", "deep/out", "deep/out/metrics.json", "deep/out/montage.png"};
  for (size_t view = 0; view < views; ++view)
    for (const WarpDescriptor& technique : warpRegistry()) {
      const std::string name = "deep/out/view" + std::to_string(view) + "-" + std::string(technique.name) + ".png";
      expected.push_back(name);
      EXPECT_EQ(picture(folder_, name).width(), 40u) << name;
    }
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(folder_.listing(), expected);
  const Image<Rgba8> montage = picture(folder_, "deep/out/montage.png");
  EXPECT_GT(montage.width(), 40 * views);
  EXPECT_GT(montage.height(), 30 * warpRegistry().size());

  ASSERT_EQ(report["rows"].size(), views * warpRegistry().size());
  std::set<std::pair<std::string, size_t>> seen;
  for (const json& row : report["rows"]) {
    for (const char* key : {"technique", "heuristic", "radius", "view", "angleDeg", "psnrDb", "ssim", "flip", "holeFraction", "drawMs",
                            "buildMs", "samples", "bytes"})
      EXPECT_TRUE(row.contains(key)) << key;
    const auto& technique = findWarp(row["technique"].get<std::string>());
    const auto view = row["view"].get<size_t>();
    EXPECT_TRUE(seen.emplace(technique.name, view).second);
    EXPECT_EQ(row["angleDeg"] == 0.0, view == 0);
    EXPECT_GE(row["holeFraction"].get<double>(), 0.0);
    EXPECT_LE(row["holeFraction"].get<double>(), 1.0);
    EXPECT_GE(row["drawMs"].get<double>(), 0.0);
    EXPECT_GE(row["buildMs"].get<double>(), 0.0);
    if (technique.usesFrame) {
      EXPECT_EQ(row["heuristic"], "median");
      EXPECT_EQ(row["radius"], "pixel");
      EXPECT_GT(row["samples"].get<size_t>(), 0u);
      EXPECT_GT(row["bytes"].get<size_t>(), 0u);
      EXPECT_TRUE(row["psnrDb"].is_number());
    } else {
      // Identical to itself: infinite, which JSON writes as null.
      EXPECT_TRUE(row["psnrDb"].is_null());
      EXPECT_EQ(row["holeFraction"], 0.0);
    }
  }
}

TEST_F(CommandLine, CompareShowsATableAsWideForEveryTechnique) {
  const std::string table = succeed(quick({"compare", "block", "--out", "out"})).err;
  std::istringstream lines(table);
  std::string line;
  const auto width = [](const std::string& text) { return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }); };
  ASSERT_TRUE(std::getline(lines, line));
  const auto columns = width(line);
  EXPECT_THAT(line, testing::HasSubstr("1.25× as far"));
  for (const WarpDescriptor& technique : warpRegistry()) {
    ASSERT_TRUE(std::getline(lines, line));
    EXPECT_THAT(line, testing::StartsWith(std::string(technique.name) + " "));
    EXPECT_EQ(width(line), columns) << line;
    EXPECT_EQ(line.find("identical") != std::string::npos, !technique.usesFrame) << line;
  }
  EXPECT_THAT(table, testing::Not(testing::HasSubstr("inf")));
}

TEST_F(CommandLine, CompareIntoAnExistingFolderKeepsWhatElseIsThere) {
  fs::create_directory(folder_.path() / "out");
  folder_.write("out/mine.txt", "mine");
  folder_.write("out/montage.png", "old");
  const ProgramResult result = succeed(quick({"compare", "--out", "out/", "--quiet"}, "1x1"));
  EXPECT_EQ(result.out + result.err, "");
  EXPECT_EQ(folder_.read("out/mine.txt"), "mine");
  EXPECT_GT(picture(folder_, "out/montage.png").width(), 4u);
  for (const std::string& name : folder_.listing()) EXPECT_THAT(name, testing::Not(testing::HasSubstr("partial")));
}

/// Only its beginning: the default size takes a while, and what compare does is tested above.
TEST_F(CommandLine, WithoutACommandAndADisplayTheDefaultSceneIsCompared) {
  Program program({}, folder_.path(), {"DISPLAY=", "WAYLAND_DISPLAY="});
  while (!fs::exists(folder_.path() / "out") && !program.hasEnded()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  program.signal(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.code, kFailure);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, testing::HasSubstr("no display"));
  EXPECT_THAT(result.err, testing::HasSubstr("./out"));
  EXPECT_THAT(result.err, testing::HasSubstr("stopped"));
  EXPECT_TRUE(folder_.listing().empty());
}

// --- export

TEST_F(CommandLine, ExportedSamplesLieInTheWorldsBounds) {
  // 20x10x5 voxels of 3 x 1 x 2 at (1e6, -50, 7), axes permuted and mirrored: world = origin + direction * (spacing * index).
  const std::string header =
      "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 20 10 5\n"
      "space directions: (0,3,0) (-1,0,0) (0,0,2)\nspace origin: (1000000,-50,7)\nencoding: raw\n\n";
  std::string voxels(20 * 10 * 5, '\0');
  for (int z = 0; z < 5; ++z)
    for (int y = 0; y < 10; ++y)
      for (int x = 0; x < 20; ++x) voxels[static_cast<size_t>((z * 10 + y) * 20 + x)] = static_cast<char>(x >= 15 ? 200 : 0);
  folder_.write("v.nrrd", header + voxels);
  const json report = document({"export", "v.nrrd", "--ply", "a.ply", "--json", "--size", "50x41"});
  const auto samples = report["samples"].get<size_t>();
  ASSERT_GT(samples, 50u);

  const std::string bytes = folder_.read("a.ply");
  const std::string end = "end_header\n";
  const size_t body = bytes.find(end) + end.size();
  const std::string head = bytes.substr(0, body);
  EXPECT_THAT(head, testing::StartsWith("ply\nformat binary_little_endian 1.0\n"));
  EXPECT_THAT(head, testing::HasSubstr("element vertex " + std::to_string(samples) + "\n"));
  size_t at = 0;
  for (const char* name : {"x", "y", "z", "radius", "red", "green", "blue", "alpha"}) {
    const size_t found = head.find(std::string(" ") + name + "\n", at);
    ASSERT_NE(found, std::string::npos) << name;
    at = found;
  }
  constexpr size_t kVertexBytes = 4 * 8 + 4;
  ASSERT_EQ(bytes.size(), body + samples * kVertexBytes);
  double nearest = 1e300;
  for (size_t i = 0; i < samples; ++i) {
    double position[4];
    std::memcpy(position, bytes.data() + body + i * kVertexBytes, sizeof position);
    // Voxel x 0..19 runs along world y from -50 in steps of 3, voxel y along -x, voxel z along z; voxels reach half an edge further.
    EXPECT_GT(position[0], 1e6 - 9.5 - 1e-3);
    EXPECT_LT(position[0], 1e6 + 0.5 + 1e-3);
    EXPECT_LT(position[1], -50.0 + 19.5 * 3 + 1e-3);
    EXPECT_GT(position[2], 7.0 - 1.0 - 1e-3);
    EXPECT_LT(position[2], 7.0 + 4.5 * 2 + 1e-3);
    EXPECT_GT(position[3], 0.0);
    nearest = std::min(nearest, position[1]);
  }
  // Only voxels from x = 15 on are visible: nothing lies before half a voxel below the one before that.
  EXPECT_GT(nearest, -50.0 + 14.0 * 3 - 1e-3);
  EXPECT_LT(nearest, -50.0 + 15.5 * 3);
}

// --- output that cannot be written, interrupts

TEST_F(CommandLine, AFullDeviceIsAFailure) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  fs::create_symlink("/dev/full", folder_.path() / "full.png");
  expectRefused(quick({"shot", "-o", "full.png"}), kFailure, {"full.png", "No space left"});
}

/// The reader of the pipe has gone before anything is printed.
TEST_F(CommandLine, PipesThatNobodyReadsAreAFailureThatLeavesNothing) {
  for (const std::string stream : {"", "2>&1"}) {
    const bool isOut = stream.empty();
    const std::string printing = isOut ? " --json 2>err" : " 2>&1";
    runShell("{ sleep 0.3; \"$W\" compare block --out out --volume-size 24x22x20 --size 40x30" + printing + "; echo $? >code; } | true", folder_.path());
    EXPECT_EQ(folder_.read("code"), isOut ? "1\n" : "0\n");
    if (isOut) EXPECT_THAT(folder_.read("err"), testing::StartsWith("warpscope: standard output cannot be written to"));
    // The pictures are there all the same.
    EXPECT_TRUE(json::accept(folder_.read("out/metrics.json")));
    for (const std::string& name : folder_.listing()) EXPECT_THAT(name, testing::Not(testing::HasSubstr("partial")));
    fs::remove_all(folder_.path() / "out");
  }
  succeed(quick({"shot", "-o", "plain.png"}));
  runShell("\"$W\" shot --volume-size 24x22x20 --size 40x30 -o /dev/stdout | cat >piped.png", folder_.path());
  EXPECT_EQ(folder_.read("piped.png"), folder_.read("plain.png"));
}

TEST_F(CommandLine, FilesThatMayNotGrowAreAFailureThatLeavesNothing) {
  for (const std::string command : {"shot -o a.png", "export --ply a.ply", "compare --out out"}) {
    const ProgramResult result = runShell("ulimit -f 8; exec \"$W\" " + command + " block --volume-size 24x22x20 --size 300x300", folder_.path());
    EXPECT_EQ(result.code, kFailure) << command;
    EXPECT_THAT(result.err, testing::StartsWith("warpscope: ")) << command;
    EXPECT_THAT(result.err, testing::HasSubstr("cannot be written: File too large")) << command;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_TRUE(folder_.listing().empty()) << testing::PrintToString(folder_.listing());
  }
}

/// A volume that takes many seconds to compute.
TEST_F(CommandLine, InterruptingTheOpeningOfAVolumeEndsItAtOnce) {
  for (const Arguments& command : {Arguments{"shot", "-o", "a.png"}, {"export", "--ply", "a.ply"}, {"compare", "--out", "out"}}) {
    SCOPED_TRACE(command[0]);
    Arguments arguments = command;
    arguments.insert(arguments.end(), {"vessels", "--volume-size", "800x800x800", "--verbose"});
    Program program(arguments, folder_.path());
    while (program.errSoFar().find("backend: ") == std::string::npos && !program.hasEnded()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const auto start = std::chrono::steady_clock::now();
    program.signal(SIGINT);
    const ProgramResult result = program.wait();
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
    EXPECT_EQ(result.code, kFailure);
    EXPECT_THAT(result.err, testing::EndsWith("warpscope: stopped; nothing was written\n"));
    EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("volume ")));
    EXPECT_TRUE(folder_.listing().empty());
  }
}

/// After the march, while the picture or the cloud is made: work of a second or more at this size.
TEST_F(CommandLine, InterruptingWhatComesAfterTheMarchLeavesNothing) {
  const std::pair<Arguments, std::string> commands[] = {
      {{"shot", "block", "--technique", "hold", "-o", "a.png"}, "drew "},
      {{"export", "block", "--ply", "a.ply", "--heuristic", "entrance"}, "marched "},
  };
  for (const auto& [command, event] : commands) {
    SCOPED_TRACE(command[0]);
    Arguments arguments = quick(command, "4096x4096");
    arguments.push_back("--verbose");
    Program program(arguments, folder_.path());
    while (program.errSoFar().find(event) == std::string::npos && !program.hasEnded()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ASSERT_FALSE(program.hasEnded()) << "too quick to be interrupted";
    program.signal(SIGINT);
    const ProgramResult result = program.wait();
    EXPECT_EQ(result.code, kFailure);
    EXPECT_THAT(result.err, testing::HasSubstr("warpscope: stopped"));
    EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("wrote")));
    EXPECT_TRUE(folder_.listing().empty()) << testing::PrintToString(folder_.listing());
  }
}

TEST_F(CommandLine, WhatIsStartedToOutliveItsTerminalDoes) {
  const ProgramResult result = runShell("trap '' HUP; \"$W\" compare block --out out --volume-size 24x22x20 --size 200x200 --quiet & sleep 0.2; kill -HUP $!; wait $!",
                                        folder_.path());
  EXPECT_EQ(result.code, kSuccess) << result.err;
  EXPECT_TRUE(fs::exists(folder_.path() / "out/metrics.json"));
}

TEST_F(CommandLine, InterruptingCompareLeavesNothing) {
  const auto picturesSoFar = [&] {
    const std::vector<std::string> names = folder_.listing();
    return std::count_if(names.begin(), names.end(), [](const std::string& name) { return name.ends_with(".png"); });
  };
  for (const int number : {SIGINT, SIGTERM, SIGHUP})
    for (const int pictures : {0, 1, 6}) {  // of four techniques or more in five views
      SCOPED_TRACE(std::to_string(number) + " after " + std::to_string(pictures) + " pictures");
      Program program({"compare", "block", "--out", "out/deep", "--size", "1501x1499"}, folder_.path());
      while ((!fs::exists(folder_.path() / "out/deep") || picturesSoFar() < pictures) && !program.hasEnded())
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      ASSERT_FALSE(program.hasEnded()) << "it ended before it was interrupted";
      const auto start = std::chrono::steady_clock::now();
      // The impatient press the keys again.
      for (const int pauseMs : {0, 1, 7, 30}) {
        program.signal(number);
        std::this_thread::sleep_for(std::chrono::milliseconds(pauseMs));
      }
      const ProgramResult result = program.wait();
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      EXPECT_LT(seconds, 2.0);
      EXPECT_EQ(result.code, kFailure);
      EXPECT_THAT(result.err, testing::StartsWith("warpscope: stopped"));
      EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
      EXPECT_TRUE(folder_.listing().empty()) << testing::PrintToString(folder_.listing());
    }
}

}  // namespace
}  // namespace warpscope

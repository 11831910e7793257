// `compare` and `export` through the built program: pictures, montage, metrics, tables, and samples as points.
// The contract is in README.
#include <algorithm>
#include <cstring>
#include <set>
#include <sstream>

#include "app/picture/heat_map.h"
#include "app/picture/picture.h"
#include "app/scene/scene.h"
#include "render/warp/warp.h"
#include "tests/cli.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// --- compare

TEST_F(CommandLine, CompareDrawsTheSameMontageEachTime) {
  for (const char* out : {"first", "second"}) document(quick({"compare", "block", "--out", out, "--json"}));
  EXPECT_EQ(folder_.read("first/montage.png"), folder_.read("second/montage.png"));
}

TEST_F(CommandLine, CompareWritesPicturesMontageAndMetrics) {
  const json report = document(quick({"compare", "block", "--out", "deep/out", "--json", "--heuristic", "median", "--radius", "pixel", "--proxy", "5"}));
  EXPECT_EQ(json::parse(folder_.read("deep/out/metrics.json")), report);

  const size_t views = openScene("block").views.size();
  std::vector<std::string> expected{"deep", "deep/out", "deep/out/metrics.json", "deep/out/montage.png"};
  for (size_t view = 0; view < views; ++view)
    for (const WarpDescriptor& technique : warpRegistry()) {
      const std::string name = "deep/out/view" + std::to_string(view) + "-" + std::string(technique.name) + ".png";
      expected.push_back(name);
      EXPECT_EQ(picture(name).width(), 40u) << name;
    }
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(folder_.listing(), expected);
  const Image<Rgba8> montage = picture("deep/out/montage.png");
  EXPECT_GT(montage.width(), 40 * views);
  EXPECT_GT(montage.height(), 30 * warpRegistry().size());

  ASSERT_EQ(report["rows"].size(), views * warpRegistry().size());
  std::set<std::pair<std::string, size_t>> seen;
  for (const json& row : report["rows"]) {
    for (const char* key : {"technique", "heuristic", "radius", "view", "angleDeg", "psnrDb", "ssim", "flip", "holeFraction", "filledFraction", "drawMs",
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
      EXPECT_GT(row["bytes"].get<size_t>() + row["proxyBytes"].get<size_t>(), 0u);
      EXPECT_TRUE(row["psnrDb"].is_number());
    } else {
      // Identical to itself: infinite, which JSON writes as null.
      EXPECT_TRUE(row["psnrDb"].is_null());
      EXPECT_EQ(row["holeFraction"], 0.0);
    }
  }
}

TEST_F(CommandLine, CompareShowsATableAsWideForEveryTechnique) {
  const std::string table = succeed(quick({"compare", "block", "--out", "out", "--proxy", "5"})).err;
  std::istringstream lines(table);
  std::string line;
  const auto width = [](const std::string& text) { return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }); };
  ASSERT_TRUE(std::getline(lines, line));
  const auto columns = width(line);
  EXPECT_THAT(line, testing::HasSubstr("farther (1.25×)"));
  for (const WarpDescriptor& technique : warpRegistry()) {
    ASSERT_TRUE(std::getline(lines, line));
    EXPECT_THAT(line, testing::StartsWith(std::string(technique.name) + " "));
    EXPECT_EQ(width(line), columns) << line;
    EXPECT_EQ(line.find("identical") != std::string::npos, !technique.usesFrame) << line;
  }
  EXPECT_THAT(table, testing::Not(testing::HasSubstr("inf")));
}

TEST_F(CommandLine, CompareTakesSomeTechniquesAlone) {
  const ProgramResult result = succeed(quick({"compare", "block", "--out", "out", "--techniques", "segments,points"}));
  const json report = json::parse(folder_.read("out/metrics.json"));
  std::set<std::string> seen;
  for (const json& row : report["rows"]) seen.insert(row["technique"]);
  EXPECT_EQ(seen, (std::set<std::string>{"reference", "points", "segments"}));
  EXPECT_EQ(folder_.listing().size(), 3 + 3 * openScene("block").views.size()) << "a folder, its montage, its metrics, and three pictures a view";
  EXPECT_TRUE(report["spheresAgainstPoints"].empty());
  EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("spheres")));
  expectRefused(quick({"compare", "block", "--out", "no", "--techniques", "segmnts"}), kUsage, {"segments"});
  expectRefused(quick({"compare", "block", "--out", "no", "--techniques", "segments", "--segments", "0"}), kUsage, {"--techniques segments: there are no segments"});
}

TEST_F(CommandLine, FramesTakeNoMoreBytesThanTheyMay) {
  const auto bytesOf = [](const json& report) {
    size_t most = 0;
    for (const json& row : report["rows"]) most = std::max(most, row["bytes"].get<size_t>());
    return most;
  };
  const std::vector<std::string> command{"compare", "shells", "--volume-size", "48x48x48", "--size", "256x256", "--json", "--techniques", "segments", "--segments", "4"};
  const auto with = [&](std::vector<std::string> more) {
    std::vector<std::string> line = command;
    line.insert(line.end(), more.begin(), more.end());
    return line;
  };
  const json whole = document(with({"--out", "whole"})), small = document(with({"--out", "small", "--frame-kib", "100"}));
  EXPECT_EQ(whole["server"]["width"], 256);
  EXPECT_GT(bytesOf(whole), 200u * 1024) << "else the budget below is none";
  EXPECT_LT(small["server"]["width"], 256);
  EXPECT_EQ(small["server"]["width"], small["server"]["height"]);
  EXPECT_LE(bytesOf(small), 100u * 1024);
  EXPECT_GE(bytesOf(small), 70u * 1024);
  EXPECT_EQ(picture("small/view0-segments.png").width(), 256u) << "the pictures are as large as ever";
  // Of what none of those that are compared draws, nothing is sent.
  const json spheres = document({"compare", "shells", "--volume-size", "48x48x48", "--size", "256x256", "--json", "--techniques", "spheres", "--frame-kib", "30", "--out", "spheres"});
  EXPECT_GT(bytesOf(spheres), 20u * 1024);
  EXPECT_LE(bytesOf(spheres), 30u * 1024);
  expectRefused(with({"--out", "none", "--frame-kib", "1"}), kFailure, {"64x64 pixels, the smallest that is tried, takes"});
}

TEST_F(CommandLine, TechniquesWhoseFramesLackWhatTheyDrawAreLeftOutWithAReason) {
  const ProgramResult result = succeed(quick({"compare", "block", "--out", "out", "--segments", "0"}));
  EXPECT_THAT(result.err, testing::HasSubstr("segments is left out: there are no segments (--segments 0)"));
  EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("\nsegments ")));
  const json report = json::parse(folder_.read("out/metrics.json"));
  const size_t views = openScene("block").views.size();
  EXPECT_EQ(report["rows"].size(), views * (warpRegistry().size() - 1));
  for (const json& row : report["rows"]) EXPECT_NE(row["technique"], "segments");
  ASSERT_EQ(report["leftOut"].size(), 1u);
  EXPECT_EQ(report["leftOut"][0]["technique"], "segments");
  EXPECT_FALSE(fs::exists(folder_.path() / "out/view0-segments.png"));
  // Of segments without a copy there is something to be seen, of the copy there is not.
  const json bare = document(quick({"compare", "block", "--out", "bare", "--json", "--proxy", "0"}));
  ASSERT_EQ(bare["leftOut"].size(), 1u);
  EXPECT_EQ(bare["leftOut"][0]["reason"], "there is no copy of the volume (--proxy 0)");
}

TEST_F(CommandLine, ATechniqueThatIsNamedGetsWhatItDrawsUnlessThereIsToBeNone) {
  folder_.write("bare.json", R"({"name": "bare", "volume": {"procedural": "block", "size": [16, 16, 16]}, "march": {"segments": 0, "proxy": 0}})");
  for (const char* technique : {"segments", "proxy"}) {
    succeed(quick({"shot", "bare.json", "--technique", technique, "-o", "a.png"}));
    const Image<Rgba8> shown = picture("a.png");
    EXPECT_TRUE(std::ranges::any_of(shown, [](Rgba8 pixel) { return pixel >> 24 != 0; })) << technique;
    expectRefused(quick({"shot", "bare.json", "--technique", technique, std::string("--") + technique, "0", "-o", "b.png"}), kUsage, {"must be more than 0"});
    expectRefused(quick({"sweep", "bare.json", "--techniques", technique, std::string("--") + technique, "0", "--out", "swept"}), kUsage, {"--techniques", "there"});
    const json swept = document(quick({"sweep", "bare.json", "--techniques", technique, "--angles", "0", "--links", "none", "--draws", "1", "--out", "swept", "--json"}));
    EXPECT_TRUE(std::ranges::any_of(swept["rows"], [&](const json& row) { return row["technique"] == technique; }));
  }
}

TEST_F(CommandLine, CompareIntoAnExistingFolderKeepsWhatElseIsThere) {
  fs::create_directory(folder_.path() / "out");
  folder_.write("out/mine.txt", "mine");
  folder_.write("out/montage.png", "old");
  const ProgramResult result = succeed(quick({"compare", "--out", "out/", "--quiet"}, "1x1"));
  EXPECT_EQ(result.out + result.err, "");
  EXPECT_EQ(folder_.read("out/mine.txt"), "mine");
  EXPECT_GT(picture("out/montage.png").width(), 4u);
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
  ASSERT_TRUE(report["leftOut"].is_number_unsigned());

  const std::string bytes = folder_.read("a.ply");
  const std::string end = "end_header\n";
  const size_t body = bytes.find(end) + end.size();
  const std::string head = bytes.substr(0, body);
  EXPECT_THAT(head, testing::StartsWith("ply\nformat binary_little_endian 1.0\n"));
  EXPECT_THAT(head, testing::HasSubstr("\ncomment axes: the axes that the volume's file states, z upwards\n"));
  EXPECT_THAT(head, testing::HasSubstr("\ncomment units: x y z and radius are in the volume file's unit of length"));
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
    EXPECT_NE(bytes[body + (i + 1) * kVertexBytes - 1], '\0') << "opacity 0";
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

TEST_F(CommandLine, ExportedSamplesSayHowUncertainTheirDepthIs) {
  const Arguments block{"export", "block", "--volume-size", "24x20x20", "--size", "50x41", "--step", "0.5", "--json"};
  const auto with = [&](Arguments more) {
    more.insert(more.begin(), block.begin(), block.end());
    return document(more);
  };
  const json report = with({"--ply", "a.ply", "--spread-map", "a.png"});
  const std::string bytes = folder_.read("a.ply");
  const std::string end = "end_header\n";
  const size_t body = bytes.find(end) + end.size();
  EXPECT_THAT(bytes.substr(0, body), testing::HasSubstr("property double radius\nproperty double spread\nproperty uchar red\n"));
  EXPECT_THAT(bytes.substr(0, body), testing::HasSubstr("comment units: x y z radius and spread are in"));
  constexpr size_t kVertexBytes = 5 * 8 + 4;
  const auto samples = report["samples"].get<size_t>();
  ASSERT_EQ(bytes.size(), body + samples * kVertexBytes);
  double most = 0.0, sum = 0.0;
  for (size_t i = 0; i < samples; ++i) {
    double spread;
    std::memcpy(&spread, bytes.data() + body + i * kVertexBytes + 4 * 8, sizeof spread);
    EXPECT_GE(spread, 0.0);
    most = std::max(most, spread);
    sum += spread;
  }
  EXPECT_GT(most, 0.5);
  EXPECT_NEAR(report["mostSpread"].get<double>(), most, 1e-6);
  if (report["leftOut"] == 0) EXPECT_NEAR(report["meanSpread"].get<double>(), sum / static_cast<double>(samples), 1e-4);
  const Image<Rgba8> map = readPng(folder_.path() / "a.png");
  EXPECT_EQ(map.width(), 50u);
  EXPECT_EQ(map.height(), 41u);
  EXPECT_TRUE(std::ranges::count(map, heatColor(1.0f)) > 0) << "the greatest spread is the brightest";

  // The map alone implies them; they change nothing else.
  with({"--spread-map", "b.png"});
  EXPECT_EQ(folder_.read("b.png"), folder_.read("a.png"));
  with({"--ply", "plain.ply"});
  with({"--ply", "asked.ply", "--spread", "true"});
  EXPECT_EQ(folder_.read("asked.ply"), bytes);
  EXPECT_LT(folder_.read("plain.ply").size(), bytes.size());
}

}  // namespace
}  // namespace warpscope

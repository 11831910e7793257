// `sweep` and `shot --technique auto` through the built program: files, plans, refusals, interrupts that lose nothing.
// The contract is in README.
#include <csignal>
#include <map>
#include <set>
#include <thread>

#include "app/experiment/sweep_plan.h"
#include "tests/cli.h"

namespace warpscope {
namespace {

using nlohmann::json;

class SweepCommand : public CommandLine {
 protected:
  /// A sweep of seconds; `other`: options that are to be different.
  static Arguments small(const std::map<std::string, std::string>& other = {}) {
    std::map<std::string, std::string> options{{"--techniques", "reference,hold,splats"}, {"--heuristics", "median"}, {"--radii", "voxel"},
                                               {"--point-sizes", "2"}, {"--server-sides", "40"}, {"--angles", "0,10"},
                                               {"--links", "none;delay=50"}, {"--instants", "2"}, {"--draws", "2"}};
    for (const auto& [option, value] : other) options[option] = value;
    Arguments arguments = quick({"sweep", "block", "--out", "out"});
    for (const auto& [option, value] : options) arguments.insert(arguments.end(), {option, value});
    return arguments;
  }
};

TEST_F(SweepCommand, WritesItsFilesAndAnswers) {
  const ProgramResult result = succeed(small());
  EXPECT_EQ(folder_.listing(), (std::vector<std::string>{"out", "out/report.html", "out/sweep.csv", "out/sweep.json"}));
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, testing::HasSubstr("Within 33 ms a frame use "));
  EXPECT_THAT(result.err, testing::HasSubstr("The paper's method (spheres, gradient, voxel)"));

  const json sweep = json::parse(folder_.read("out/sweep.json"));
  // reference, hold, splats, and the two baselines; two angles and two links.
  EXPECT_EQ(sweep["rows"].size(), 5u * 4);
  EXPECT_EQ(sweep["floors"].size(), 2u);
  for (const char* key : {"scene", "plan", "machine", "version", "width", "height", "volumeSeed", "findings"}) EXPECT_TRUE(sweep.contains(key)) << key;
  std::set<std::string> links;
  for (const json& row : sweep["rows"])
    if (!row["link"].is_null()) links.insert(row["link"].get<std::string>());
  EXPECT_EQ(links, (std::set<std::string>{"delay=50", "none"}));

  const std::string csv = folder_.read("out/sweep.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 5 * 4);
}

TEST_F(SweepCommand, TakesItsPlanFromAFileAndJsonGoesToStdout) {
  folder_.write("plan.json", R"({"techniques": ["hold"], "angles": [5], "links": [], "draws": 1})");
  const json sweep = document(quick({"sweep", "block", "--out", "out", "--json", "--plan", "plan.json", "--server-sides", "20"}));
  EXPECT_EQ(sweep["rows"].size(), 3u);
  EXPECT_EQ(sweep["plan"]["serverSides"], json({20}));
  EXPECT_EQ(sweep["plan"]["draws"], 1);
  EXPECT_EQ(json::parse(folder_.read("out/sweep.json")), sweep);
}

TEST_F(SweepCommand, BoundsAreThereWhereTheyAreAskedFor) {
  folder_.write("plan.json", R"({"techniques": ["spheres"], "angles": [0, 25], "links": [], "draws": 1})");
  const json sweep = document(quick({"sweep", "block", "--out", "out", "--json", "--oracle", "--plan", "plan.json"}));
  ASSERT_EQ(sweep["bounds"].size(), 4u);
  const auto boundOf = [&](std::string_view name, double angleDeg) {
    for (const json& bound : sweep["bounds"])
      if (bound["bound"] == name && bound["angleDeg"] == angleDeg) return bound;
    return json();
  };
  EXPECT_LT(boundOf("perfect-warp", 0.0)["flip"].get<double>(), boundOf("perfect-warp", 25.0)["flip"].get<double>());
  EXPECT_LT(boundOf("perfect-warp", 25.0)["flip"].get<double>(), boundOf("best-dot", 25.0)["flip"].get<double>());
  const std::string report = folder_.read("out/report.html");
  EXPECT_NE(report.find("one dot a ray, wherever it helps"), std::string::npos);
  EXPECT_NE(report.find("all that the frame saw, right"), std::string::npos);
  const json without = document(quick({"sweep", "block", "--out", "plain", "--json", "--plan", "plan.json"}));
  EXPECT_FALSE(without.contains("bounds"));
}

TEST_F(SweepCommand, OneOfAKindIsAnAxisOfOne) {
  const json sweep = document(quick({"sweep", "block", "--out", "out", "--json", "--heuristic", "exit", "--radius", "pixel", "--point-size", "4", "--techniques",
                                     "points,splats", "--links", "none", "--angles", "3", "--draws", "1"}));
  EXPECT_EQ(sweep["plan"]["heuristics"], json({"exit"}));
  EXPECT_EQ(sweep["plan"]["radii"], json({"pixel"}));
  EXPECT_EQ(sweep["plan"]["pointSizes"], json({4}));
}

TEST_F(SweepCommand, WhatIsGivenCountsAlsoWhereItIsWhatACommandTakesAnyway) {
  const json sweep = document(quick({"sweep", "block", "--out", "out", "--json", "--heuristic", "gradient", "--radius", "voxel", "--radius-scale", "1", "--hits", "4",
                                     "--techniques", "multihit", "--links", "none", "--angles", "3", "--draws", "1"}));
  EXPECT_EQ(sweep["plan"]["heuristics"], json({"gradient"}));
  EXPECT_EQ(sweep["plan"]["radii"], json({"voxel"}));
  EXPECT_EQ(sweep["plan"]["hits"], json({4}));
}

/// An unfinished sweep goes on only with what it began with: the same options and the same bytes.
TEST_F(SweepCommand, AnUnfinishedSweepOfAnythingElseIsRefused) {
  const std::string name = "v_12x12x12_uint8.raw", dark(6 * 12 * 12, '\0'), bright(6 * 12 * 12, '\xc0');
  folder_.write(name, dark + bright);
  const auto withOptions = [&](const Arguments& other) {
    Arguments arguments{"sweep", name, "--size", "40x30", "--out", "out", "--techniques", "hold", "--angles", "0,10", "--links", "none",
                        "--server-sides", "40", "--draws", "1000"};
    arguments.insert(arguments.end(), other.begin(), other.end());
    return arguments;
  };
  const std::string journal = "out/sweep-unfinished.jsonl";
  Program program(withOptions({}), folder_.path());
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (folder_.read(journal).empty() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  program.signal(SIGINT);
  program.wait();
  const std::string before = folder_.read(journal);
  ASSERT_FALSE(before.empty());
  for (const Arguments& other : {Arguments{"--gl", "osmesa"}, Arguments{"--fov", "31"}, Arguments{"--step", "0.9"}, Arguments{"--via", "embree"}})
    expectRefused(withOptions(other), kFailure, {"unfinished sweep of other settings"});
  folder_.write(name, bright + dark);
  expectRefused(withOptions({}), kFailure, {"unfinished sweep of other settings"});
  EXPECT_EQ(folder_.read(journal), before);
}

TEST_F(SweepCommand, RefusesWhatCannotBe) {
  expectRefused({"sweep", "block"}, kUsage, {"--out"});
  expectRefused(quick({"sweep", "block", "--out", "out", "--techniques", "sphere"}), kUsage, {"--techniques", "did you mean 'spheres'"});
  expectRefused(quick({"sweep", "block", "--out", "out", "--angles", "0,ten"}), kUsage, {"--angles", "'ten' is no number"});
  expectRefused(quick({"sweep", "block", "--out", "out", "--links", "rate=fast"}), kUsage, {"--links", "rate"});
  expectRefused(quick({"sweep", "block", "--out", "out", "--plan", "absent.json"}), kFailure, {"absent.json"});
  folder_.write("plan.json", "{\n \"angels\": [1]}");
  expectRefused(quick({"sweep", "block", "--out", "out", "--plan", "plan.json"}), kFailure, {"plan.json:2", "did you mean 'angles'"});
  folder_.write("file", "");
  expectRefused(quick({"sweep", "block", "--out", "file"}), kFailure, {"file"});
}

TEST_F(SweepCommand, AnInterruptLosesNothingAndTheSameCommandGoesOn) {
  const Arguments arguments = small({{"--draws", "400"}});
  const std::string journal = "out/sweep-unfinished.jsonl";
  const auto linesDone = [&] {
    const std::string text = folder_.read(journal);
    return std::count(text.begin(), text.end(), '\n');
  };
  for (const int number : {SIGINT, SIGTERM}) {
    Program program(arguments, folder_.path());
    const auto before = linesDone();
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (linesDone() < before + 2 && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ASSERT_FALSE(program.hasEnded()) << "it ended before it was interrupted";
    program.signal(number);
    const ProgramResult result = program.wait();
    EXPECT_EQ(result.code, kFailure);
    EXPECT_THAT(result.err, testing::HasSubstr("warpscope: stopped; what is done is kept in out, and the same command goes on from there"));
    EXPECT_EQ(folder_.listing(), (std::vector<std::string>{"out", journal}));
  }
  const auto done = linesDone() - 1;
  EXPECT_GE(done, 2);
  expectRefused(small({{"--draws", "3"}}), kFailure, {"unfinished sweep of other settings"});

  const ProgramResult result = succeed(arguments);
  EXPECT_THAT(result.err, testing::HasSubstr("going on with a sweep of which " + std::to_string(done) + " parts are done"));
  EXPECT_EQ(folder_.listing(), (std::vector<std::string>{"out", "out/report.html", "out/sweep.csv", "out/sweep.json"}));
  EXPECT_EQ(json::parse(folder_.read("out/sweep.json"))["rows"].size(), 5u * 4);
}

TEST_F(SweepCommand, AutoTakesWhatWasMeasured) {
  succeed(small({{"--links", "none"}}));
  const json sweep = json::parse(folder_.read("out/sweep.json"));
  const json shot = document(quick({"shot", "block", "--technique", "auto", "--front", "out/sweep.json", "--view-angle", "10", "--budget-ms", "10000", "-o", "a.png",
                                    "--json"}));
  double least = 1.0;
  for (const json& row : sweep["rows"])
    if (row["technique"] != "reference" && row["link"].is_null() && row["angleDeg"] == 10.0) least = std::min(least, row["flip"].get<double>());
  EXPECT_EQ(shot["auto"]["flip"], least);
  EXPECT_EQ(shot["technique"], shot["auto"]["configuration"]["technique"]);
  EXPECT_THAT(shot["auto"]["reason"].get<std::string>(), testing::HasSubstr("least error"));
  // The picture is that of what was chosen.
  Arguments same = quick({"shot", "block", "--technique", shot["technique"].get<std::string>(), "--view-angle", "10", "-o", "b.png"});
  for (const char* key : {"heuristic", "radius"})
    if (const json& value = shot["auto"]["configuration"][key]; !value.is_null()) same.insert(same.end(), {std::string("--") + key, value.get<std::string>()});
  succeed(same);
  EXPECT_EQ(folder_.read("a.png"), folder_.read("b.png"));
}

TEST_F(SweepCommand, AutoKeepsToTheSizeThatWasAskedForAndSaysWhereAnotherWasMeasured) {
  succeed(small({{"--links", "none"}}));
  const Arguments arguments{"shot", "block", "--volume-size", "24x22x20", "--size", "100x80", "--technique", "auto", "--front", "out/sweep.json", "--view-angle", "10", "-o", "a.png", "--json"};
  const ProgramResult result = succeed(arguments);
  EXPECT_EQ(json::parse(result.out)["server"]["width"], 100);
  EXPECT_EQ(picture("a.png").width(), 100u);
  EXPECT_THAT(result.err, testing::HasSubstr("and this one has 100: its times and errors are others"));
}

TEST_F(SweepCommand, AutoMeasuresWhereNothingWasMeasuredAndKeepsWhatWasAskedFor) {
  const json shot = document(quick({"shot", "block", "--technique", "auto", "--heuristic", "exit", "--view-angle", "5", "-o", "a.png", "--json"}));
  EXPECT_EQ(shot["heuristic"], "exit");
  EXPECT_FALSE(shot["auto"]["reason"].get<std::string>().empty());
  const ProgramResult result = succeed(quick({"shot", "block", "--technique", "auto", "--budget-ms", "0.01", "-o", "a.png"}));
  EXPECT_THAT(result.err, testing::HasSubstr("auto: "));
  EXPECT_THAT(result.err, testing::HasSubstr("none of which keeps to 0.01 ms"));
}

TEST_F(SweepCommand, AutoKeepsToTheBytesOfAFrame) {
  const auto shot = [](const std::string& kib) {
    return Arguments{"shot", "shells", "--volume-size", "40x40x40", "--size", "192x144", "--technique", "auto", "--budget-ms", "10000", "--view-angle", "10", "--frame-kib", kib, "--proxy", "0", "-o", "a.png", "--json"};
  };
  const json wide = document(shot("4000")), narrow = document(shot("12"));
  EXPECT_GT(wide["bytes"], 12 * 1024) << "else the budget below is none";
  EXPECT_LE(narrow["bytes"], 12 * 1024);
  EXPECT_LE(narrow["server"]["width"], narrow["auto"]["configuration"]["serverSide"]);
  EXPECT_GE(narrow["auto"]["flip"], wide["auto"]["flip"]);
  EXPECT_NE(narrow["technique"], "proxy");
  EXPECT_THAT(narrow["auto"]["reason"].get<std::string>(), testing::HasSubstr("of frames of no more than 12 KiB"));
  EXPECT_EQ(picture("a.png").width(), 192u);
}

TEST_F(SweepCommand, AutoRefusesWhatCannotBe) {
  expectRefused(quick({"shot", "block", "--budget-ms", "5", "-o", "a.png"}), kUsage, {"--technique auto"});
  expectRefused(quick({"shot", "block", "--technique", "auto", "--budget-ms", "0", "-o", "a.png"}), kUsage, {"--budget-ms"});
  expectRefused(quick({"shot", "block", "--technique", "auto", "--front", "absent.json", "-o", "a.png"}), kFailure, {"absent.json"});
  expectRefused({"shot", "--connect", "warp://127.0.0.1:1", "--technique", "auto", "-o", "a.png"}, kUsage, {"--front"});
}

}  // namespace
}  // namespace warpscope

// `stability`, and `--arithmetic` of other commands, through the built program: files, JSON, refusals.
// The contract is in README of app/.
#include "app/scene/scene.h"
#include "tests/cli.h"

namespace warpscope {
namespace {

using nlohmann::json;

TEST_F(CommandLine, StabilityWritesAPageATableAndPictures) {
  const ProgramResult result = succeed({"stability", "--backend", "cpu", "--case", "label-steps", "--case", "flat-pictures", "--runs", "1", "--out", "out"});
  EXPECT_EQ(folder_.listing(), (std::vector<std::string>{"out", "out/label-steps-cpu-exact.png", "out/label-steps-cpu-stable.png", "out/label-steps-cpu-textbook.png",
                                                         "out/stability.html", "out/stability.json"}));
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, testing::HasSubstr("label-steps"));
  const json report = json::parse(folder_.read("out/stability.json"));
  ASSERT_EQ(report["cases"].size(), 2u);
  for (const json& row : report["cases"]) {
    for (const char* key : {"case", "subject", "scene", "backend", "width", "height", "stable", "textbook", "bound", "isStable", "costNs"})
      EXPECT_TRUE(row.contains(key)) << key;
    EXPECT_EQ(row["backend"], "cpu");
    EXPECT_TRUE(row["isStable"].get<bool>());
    EXPECT_GT(row["textbook"]["worst"], row["stable"]["worst"]);
  }
  const std::string page = folder_.read("out/stability.html");
  EXPECT_THAT(page, testing::StartsWith("<!DOCTYPE html>"));
  EXPECT_THAT(page, testing::HasSubstr("</html>"));
}

TEST_F(CommandLine, StabilityPrintsItsDocument) {
  const json report = document({"stability", "--backend", "cpu", "--case", "thin-slab", "--runs", "1", "--json", "--out", "out"});
  EXPECT_EQ(report["cases"][0]["case"], "thin-slab");
  EXPECT_EQ(json::parse(folder_.read("out/stability.json")), report);
}

TEST_F(CommandLine, StabilityRefusesWhatItDoesNotKnow) {
  expectRefused({"stability"}, kUsage, {"--out"});
  expectRefused({"stability", "--out", "out", "--case", "thin-slap"}, kUsage, {"thin-slap", "'thin-slab'"});
  expectRefused({"stability", "--out", "out", "--runs", "0"}, kUsage, {"--runs"});
  expectRefused({"stability", "--out", "out", "--backend", "cpus"}, kUsage, {"cpus"});
}

TEST_F(CommandLine, EveryTortureSceneIsDrawnByBothArithmetics) {
  for (const BuiltinScene& scene : tortureScenes()) {
    if (scene.name == "torture/haze" || scene.name == "torture/long-way") continue;  // which take long: stability_command_test.cpp
    for (const char* arithmetic : {"stable", "textbook"})
      for (const char* technique : {"reference", "spheres"})
        succeed({"shot", scene.name, "--backend", "cpu", "--technique", technique, "--arithmetic", arithmetic, "--size", "24x16", "--out", "shot.png"});
  }
}

TEST_F(CommandLine, ArithmeticIsRefusedWhereThereIsNone) {
  expectRefused({"shot", "block", "--arithmetic", "exact", "--out", "a.png"}, kUsage, {"arithmetic 'exact'", "stable textbook"});
  expectRefused({"shot", "block", "--backend", "cpu", "--technique", "spheres", "--arithmetic", "textbook", "--via", "embree", "--size", "24x16", "--out", "a.png"}, kUsage,
                {"textbook", "lbvh"});
  expectRefused({"shot", "torture/oulier", "--out", "a.png"}, kUsage, {"torture/outlier"});
  expectRefused({"shot", "torture/outlier", "--volume-size", "8x8x8", "--out", "a.png"}, kUsage, {"--volume-size"});
}

}  // namespace
}  // namespace warpscope

// Choosing by what was measured: the least error within the budget at this angle, the fastest if nothing keeps to it, and why.
// Mirrors app/experiment/auto_choice.h.
#include "app/experiment/auto_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/experiment/sweep.h"
#include "app/experiment/sweep_file.h"
#include "tests/headless.h"
#include "tests/sweep_rows.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

std::vector<SweepRow> someRows() {
  return {sweepRow("hold", 0, 0.0, 1), sweepRow("hold", 10, 0.2, 1),   sweepRow("points", 0, 0.02, 5),  sweepRow("points", 10, 0.08, 5),
          sweepRow("spheres", 0, 0.01, 20), sweepRow("spheres", 10, 0.04, 30), sweepRow("reference", 0, 0.0, 0.1), sweepRow("reference", 10, 0.0, 0.1)};
}

std::string_view chosen(const AutoChoice& choice, double angleDeg, double budgetMs) {
  const auto best = choice.choose(angleDeg, {.ms = budgetMs}, [](const Configuration&) { return true; });
  return best ? best->configuration.technique->name : "nothing";
}

TEST(AutoChoice, LeastErrorWithinTheBudget) {
  const AutoChoice choice(someRows());
  EXPECT_EQ(chosen(choice, 0.0, 100.0), "hold");
  EXPECT_EQ(chosen(choice, 10.0, 100.0), "spheres");
  EXPECT_EQ(chosen(choice, -10.0, 100.0), "spheres");
  EXPECT_EQ(chosen(choice, 10.0, 29.0), "points");
  EXPECT_EQ(chosen(choice, 10.0, 4.0), "hold");
  EXPECT_EQ(chosen(choice, 90.0, 100.0), "spheres");  // beyond what was measured
  EXPECT_EQ(chosen(choice, 350.0, 100.0), "spheres");
  EXPECT_EQ(chosen(choice, 360.0, 100.0), "hold");
}

/// Of a sweep, as `shot --technique auto` measures one: the time of a picture of segments has their decoding and building, and the bytes are theirs.
TEST(AutoChoice, SegmentsWhereTheyAreBestAndAffordable) {
  const Stage stage(smallScene("shells"));
  MarchSettings march = stage.scene().march;
  march.sample.proxy = 8;  // the copy is much coarser than the volume
  SweepSettings settings;
  settings.plan = quickPlan(march, 96, 72, 10.0);
  settings.width = 96;
  settings.height = 72;
  settings.warp.reference = stage.scene().march.render;
  SweepJournal journal;
  const std::vector<SweepRow> rows = Sweep(stage.scene(), stage.resources(), settings, {}).run(journal, [](const std::string&) {});
  const SweepRow& segments = *std::ranges::find_if(rows, [](const SweepRow& row) { return row.configuration.technique->name == "segments"; });
  EXPECT_EQ(segments.configuration.march.sample.segments, march.sample.segments);
  EXPECT_GT(segments.cost.decode.medianMs, 0.0);
  EXPECT_GT(segments.cost.build.medianMs, 0.0);
  EXPECT_GE(segments.frameMs(), segments.cost.decode.medianMs + segments.cost.build.medianMs + segments.draw.medianMs);
  SampleFrame frame = *stage.frame(stage.camera(96, 72), segments.configuration.march);
  FrameCodec codec;
  codec.encode(frame, segments.configuration.codec);
  EXPECT_EQ(segments.cost.bytes, codec.bytes().segments);
  const AutoChoice choice(rows);
  EXPECT_EQ(chosen(choice, 10.0, 1e4), "segments");
  const auto cheap = choice.choose(10.0, {.ms = 0.999 * segments.frameMs()}, [](const Configuration&) { return true; });
  ASSERT_TRUE(cheap);
  EXPECT_NE(cheap->configuration.technique->name, "segments");
  EXPECT_LT(cheap->frameMs, segments.frameMs());
}

TEST(AutoChoice, BetweenMeasuredAnglesErrorsAndTimesAreInterpolated) {
  const AutoChoice choice(someRows());
  // hold: 0.02 degrees per degree; spheres 0.01 + 0.003 per degree: they cross at 0.588 degrees.
  EXPECT_EQ(chosen(choice, 0.5, 100.0), "hold");
  EXPECT_EQ(chosen(choice, 0.7, 100.0), "spheres");
  const auto best = choice.choose(5.0, {.ms = 100.0}, [](const Configuration&) { return true; });
  EXPECT_NEAR(best->flip, 0.025, 1e-12);
  EXPECT_NEAR(best->frameMs, 25.0, 1e-12);
}

TEST(AutoChoice, WhatWasNotMeasuredThatFarOutComesLast) {
  std::vector<SweepRow> rows = someRows();
  rows.push_back(sweepRow("splats", 0, 0.001, 1));  // in the frame's own view alone
  const AutoChoice choice(rows);
  EXPECT_EQ(chosen(choice, 1.0, 100.0), "splats");
  EXPECT_EQ(chosen(choice, 10.0, 100.0), "spheres");
  const auto far = choice.choose(90.0, {.ms = 100.0}, [](const Configuration&) { return true; });
  EXPECT_THAT(far->reason, testing::EndsWith("though nothing was measured that far out"));
}

TEST(AutoChoice, SaysWhatAndWhy) {
  const AutoChoice choice(someRows());
  const auto all = [](const Configuration&) { return true; };
  EXPECT_THAT(choice.choose(10.0, {.ms = 33.0}, all)->reason,
              testing::StartsWith("spheres, gradient, voxel: least error (FLIP 0.0400) at 10.0 degrees of what was measured within 33 ms (30 ms, of 3)"));
  EXPECT_THAT(choice.choose(10.0, {.ms = 0.5}, all)->reason, testing::HasSubstr("the fastest (1 ms, FLIP 0.2000 at 10.0 degrees) of 3 measured, none of which keeps to 0.5 ms"));
}

TEST(AutoChoice, KeepsToWhatMayBeChosen) {
  const AutoChoice choice(someRows());
  const auto best = choice.choose(10.0, {.ms = 100.0}, [](const Configuration& configuration) { return configuration.technique->name != "spheres"; });
  EXPECT_EQ(best->configuration.technique->name, "points");
  EXPECT_FALSE(choice.choose(10.0, {.ms = 100.0}, [](const Configuration&) { return false; }));
  EXPECT_FALSE(AutoChoice({}).choose(1.0, {.ms = 1.0}, [](const Configuration&) { return true; }));
}

TEST(AutoChoice, KeepsToTheBytesOfAFrame) {
  std::vector<SweepRow> rows = someRows();
  for (SweepRow& row : rows) row.cost.bytes = row.configuration.technique->name == "spheres" ? 5000 : 2000;
  rows[3].cost.bytes = 3000;  // points, turned by 10 degrees
  const AutoChoice choice(rows);
  const auto nameWithin = [&](double angleDeg, uint64_t bytes) {
    const auto best = choice.choose(angleDeg, {.ms = 100.0, .bytes = bytes}, [](const Configuration&) { return true; });
    return best ? best->configuration.technique->name : std::string_view("nothing");
  };
  EXPECT_EQ(nameWithin(10.0, 0), "spheres");
  EXPECT_EQ(nameWithin(10.0, 5000), "spheres");
  EXPECT_EQ(nameWithin(10.0, 4999), "points");
  EXPECT_EQ(nameWithin(5.0, 2999), "hold") << "between two angles a frame may be as large as at either";
  EXPECT_EQ(nameWithin(10.0, 1999), "nothing");
  EXPECT_THAT(choice.choose(10.0, {.ms = 100.0, .bytes = 4096}, [](const Configuration&) { return true; })->reason,
              testing::EndsWith("(5 ms, of 2), of frames of no more than 4 KiB"));
}

TEST(AutoChoice, LeavesOutLinks) {
  std::vector<SweepRow> rows = someRows();
  rows.push_back(sweepRow("multihit", 10, 0.001, 1));
  rows.back().link = "4g";
  EXPECT_EQ(chosen(AutoChoice(rows), 10.0, 100.0), "spheres");
}

TEST(AutoChoice, KnowsTheLargestImage) {
  std::vector<SweepRow> rows = someRows();
  rows.push_back(sweepRow("splats", 10, 0.001, 1, {}, 256));
  EXPECT_EQ(AutoChoice(rows).largestSidePx(), 512u);
  EXPECT_EQ(AutoChoice({}).largestSidePx(), 0u);
}

TEST(AutoChoice, ComesWithASweepsFile) {
  const TestFolder folder;
  nlohmann::json document{{"rows", nlohmann::json::array()}};
  for (const SweepRow& row : someRows()) document["rows"].push_back(toJson(row));
  EXPECT_EQ(chosen(*readSweepFile(folder.write("sweep.json", document.dump()))->choice, 10.0, 100.0), "spheres");
  document["rows"] = {toJson(someRows().back())};
  EXPECT_EQ(readSweepFile(folder.write("reference.json", document.dump()))->choice, nullptr);
}

TEST(AngleBetween, IsThatOfTheViews) {
  Scene scene = smallScene("block");
  scene.views.front().elevationDeg = 0.0;
  const Stage stage(std::move(scene));
  for (const double turnDeg : {0.0, 0.5, 10.0, -25.0, 90.0, 180.0})
    EXPECT_NEAR(angleBetweenDeg(stage.camera(40, 30), stage.camera(40, 30, turnDeg)), std::abs(turnDeg), 1e-2) << turnDeg;
  // Nearer, and past the centre: no turn, but not the same view either.
  View near = stage.scene().views.front(), panned = near;
  near.distance *= 0.8;
  panned.pan.x = 0.3;
  for (const View& view : {near, panned})
    EXPECT_GT(angleBetweenDeg(stage.camera(40, 30), makeCamera(stage.scene(), view, 40, 30)), 4.0);
}

}  // namespace
}  // namespace warpscope

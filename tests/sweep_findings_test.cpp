// Fronts, summaries, answers, rows as JSON and CSV, and frames on a line of time.
// Mirrors app/experiment/findings.h, app/experiment/sweep_result.h and app/experiment/motion.h.
#include "app/experiment/findings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "app/experiment/effect_findings.h"
#include "app/experiment/motion.h"
#include "app/scene/json_document.h"
#include "tests/sweep_rows.h"

namespace warpscope {
namespace {

SweepRow rowOf(std::string_view technique, Heuristic heuristic, double angleDeg, double flip, double drawMs) {
  MarchSettings march;
  march.sample.heuristic = heuristic;
  SweepRow row = sweepRow(technique, angleDeg, flip, drawMs, march);
  row.draw = {drawMs, 0.1};
  row.draws = 3;
  return row;
}

bool dominates(const CostAndError& a, const CostAndError& b) {
  return a.cost <= b.cost && a.error <= b.error && (a.cost < b.cost || a.error < b.error);
}

TEST(ParetoFront, IsWhatNothingDominates) {
  std::mt19937 dice(7);
  std::uniform_int_distribution<int> value(0, 12);  // small, so that there are ties
  for (int round = 0; round < 300; ++round) {
    std::vector<CostAndError> points(static_cast<size_t>(value(dice)));
    for (CostAndError& point : points) point = {static_cast<double>(value(dice)), static_cast<double>(value(dice))};
    const std::vector<size_t> front = paretoFront(points);
    for (size_t i = 0; i < points.size(); ++i) {
      const bool isBeaten = std::any_of(points.begin(), points.end(), [&](const CostAndError& other) { return dominates(other, points[i]); });
      const bool isThere = std::any_of(front.begin(), front.end(), [&](size_t j) {
        return points[j].cost == points[i].cost && points[j].error == points[i].error;
      });
      EXPECT_EQ(isThere, !isBeaten) << round;
    }
    for (size_t i = 1; i < front.size(); ++i) EXPECT_LT(points[front[i - 1]].cost, points[front[i]].cost);
  }
}

TEST(ParetoFront, LeavesOutWhatIsNoNumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(paretoFront({{1.0, nan}, {2.0, 0.5}}), std::vector<size_t>{1});
}

SweepRow litRow(std::string_view technique, float shading, double flip, double marchMs) {
  SweepRow row = rowOf(technique, Heuristic::gradient, 0.0, flip, 1.0);
  row.configuration.march.render.effects.shading.strength = shading;
  row.cost.march = {marchMs, 0.0};
  return row;
}

TEST(EffectSentences, SayWhatAnEffectCostsAndAdds) {
  const std::vector<SweepRow> rows{litRow("spheres", 0.0f, 0.05, 10.0), litRow("spheres", 0.5f, 0.055, 21.0), litRow("spheres", 1.0f, 0.06, 21.0),
                                   litRow("points", 0.0f, 0.25, 10.0),  litRow("points", 1.0f, 0.2, 19.0)};
  EXPECT_EQ(effectSentences(summariesOf(rows)),
            "Shading at 1 instead of 0: the server takes 20 ms instead of 10; spheres is off by +0.0100 (FLIP 0.0600 instead of 0.0500), points is off by -0.0500 (FLIP 0.2000 instead of 0.2500).\n");
  EXPECT_THAT(findingsOf(rows).answer, testing::HasSubstr("Shading at 1 instead of 0"));
  EXPECT_EQ(effectSentences({}), "");
  EXPECT_EQ(effectSentences(summariesOf({rows[0], rows[3]})), "") << "no effect was turned";
  EXPECT_EQ(effectSentences(summariesOf({rows[0], rows[4]})), "") << "they differ in more than the effect";
}

TEST(Summaries, AreOverAnglesAndLeaveLinksOut) {
  std::vector<SweepRow> rows{rowOf("splats", Heuristic::median, 0.0, 0.1, 3.0), rowOf("splats", Heuristic::median, 10.0, 0.3, 5.0),
                             rowOf("hold", Heuristic::gradient, 0.0, 0.0, 1.0)};
  rows.push_back(rows[0]);
  rows.back().link = "4g";
  rows.back().errors.flip = 0.9;
  rows[0].cost.build = rows[1].cost.build = {2.0, 0.0};
  const std::vector<Summary> summaries = summariesOf(rows);
  ASSERT_EQ(summaries.size(), 2u);
  EXPECT_DOUBLE_EQ(summaries[0].flip, 0.2);
  EXPECT_DOUBLE_EQ(summaries[0].frameMs, 7.0);  // the slowest view, with the build
  EXPECT_DOUBLE_EQ(summaries[0].drawMs, 5.0);
}

TEST(Findings, TheReferenceIsNeverTheAnswer) {
  const std::vector<SweepRow> rows{rowOf("reference", Heuristic::gradient, 0.0, 0.0, 0.5), rowOf("points", Heuristic::median, 0.0, 0.09, 3.0),
                                   rowOf("spheres", Heuristic::gradient, 0.0, 0.04, 14.0), rowOf("splats", Heuristic::expected, 0.0, 0.03, 40.0)};
  EXPECT_EQ(frontOf(summariesOf(rows)), (std::vector<size_t>{1, 2, 3}));
  const Findings findings = findingsOf(rows);
  ASSERT_EQ(findings.equalTime.size(), 4u);
  EXPECT_FALSE(findings.equalTime[0].best);  // 1 ms
  EXPECT_EQ(findings.equalTime[1].best->configuration.technique->name, "points");
  EXPECT_EQ(findings.equalTime[2].best->configuration.technique->name, "spheres");
  EXPECT_EQ(findings.equalTime[3].best->configuration.technique->name, "spheres");
  ASSERT_EQ(findings.equalError.size(), 3u);
  EXPECT_FALSE(findings.equalError[0].fastest);  // FLIP 0.02
  EXPECT_EQ(findings.equalError[1].fastest->configuration.technique->name, "spheres");
  EXPECT_EQ(findings.equalError[2].fastest->configuration.technique->name, "points");
  EXPECT_EQ(findings.least->configuration.technique->name, "splats");
  EXPECT_TRUE(findings.papersMethod && findings.pointBaseline);
  EXPECT_THAT(findings.answer, testing::HasSubstr("Within 1 ms a frame nothing measured here gets ready."));
  EXPECT_THAT(findings.answer, testing::HasSubstr("Within 16 ms a frame use spheres, gradient, voxel: FLIP 0.0400, holes 0.0 %, in 14 ms."));
  EXPECT_THAT(findings.answer, testing::HasSubstr("The paper's method (spheres, gradient, voxel): FLIP 0.0400"));
  EXPECT_THAT(findings.answer, testing::HasSubstr("The 2012 method (points of 2 px, median): FLIP 0.0900"));
}

TEST(Findings, TheHeadlineIsThePaperThe2012MethodAndTheBestInTime) {
  std::vector<SweepRow> rows{rowOf("points", Heuristic::median, 0.0, 0.08, 3.0), rowOf("spheres", Heuristic::gradient, 0.0, 0.04, 14.0),
                             rowOf("splats", Heuristic::expected, 0.0, 0.03, 30.0), rowOf("multihit", Heuristic::expected, 0.0, 0.01, 34.0)};
  EXPECT_EQ(findingsOf(rows).headline,
            "The paper's method (spheres, gradient, voxel) has FLIP 0.0400, holes 0.0 %, in 14 ms.\n"
            "The method of 2012 (points of 2 px, median) has FLIP 0.0800, holes 0.0 %, in 3 ms: 100 % more error than the paper's.\n"
            "The best within 33 ms a frame (splats, expected, voxel) has FLIP 0.0300, holes 0.0 %, in 30 ms: 25 % less error than the paper's, "
            "62 % less error than that of 2012.\n");
  rows[1].errors.flip = 0.02;
  EXPECT_THAT(findingsOf(rows).headline, testing::EndsWith("\nNothing that was measured has less error within 33 ms a frame than the paper's method.\n"));
  rows[0].errors.flip = 0.0195;
  EXPECT_THAT(findingsOf(rows).headline, testing::HasSubstr("in 3 ms: 2.5 % less error than the paper's.\n"));
  EXPECT_THAT(findingsOf(rows).headline, testing::EndsWith("within 33 ms a frame than the method of 2012.\n"));
  rows[0].errors.flip = rows[1].errors.flip = 0.0;
  EXPECT_THAT(findingsOf(rows).headline, testing::HasSubstr("in 3 ms: as much error as the paper's.\n"));
  for (SweepRow& row : rows) row.draw.medianMs = 40.0;
  EXPECT_THAT(findingsOf(rows).headline, testing::EndsWith("Nothing that was measured gets ready within 33 ms a frame.\n"));
  EXPECT_EQ(findingsOf({}).headline, "The paper's method was not measured.\nThe method of 2012 was not measured.\n"
                                     "Nothing that was measured gets ready within 33 ms a frame.\n");
}

TEST(Findings, EachAngleHasItsOwnWinner) {
  std::vector<SweepRow> rows{rowOf("hold", Heuristic::gradient, 0.0, 0.01, 1.0), rowOf("hold", Heuristic::gradient, 10.0, 0.2, 1.0),
                             rowOf("splats", Heuristic::median, 0.0, 0.03, 3.0), rowOf("splats", Heuristic::median, 10.0, 0.05, 3.0)};
  rows.push_back(rows[0]);
  rows.back().errors.flip = 0.0;
  rows.back().link = "4g";
  const Findings findings = findingsOf(rows);
  ASSERT_EQ(findings.atAngles.size(), 2u);
  EXPECT_EQ(findings.atAngles[0].best.technique->name, "hold");
  EXPECT_EQ(findings.atAngles[0].flip, 0.01);
  EXPECT_EQ(findings.atAngles[1].best.technique->name, "splats");
  EXPECT_THAT(findings.answer, testing::HasSubstr("At 10 degrees alone FLIP 0.0500 with splats, median, voxel."));
}

TEST(Findings, BaselinesAreOfTheLargestImage) {
  std::vector<SweepRow> rows{rowOf("spheres", Heuristic::gradient, 0.0, 0.03, 3.0), rowOf("spheres", Heuristic::gradient, 0.0, 0.02, 1.0)};
  rows[1].configuration.serverSidePx = 256;
  EXPECT_EQ(findingsOf(rows).papersMethod->configuration.serverSidePx, 512u);
}

TEST(Findings, NamesSayWhatTellsApart) {
  std::vector<SweepRow> rows{rowOf("spheres", Heuristic::gradient, 0.0, 0.03, 3.0), rowOf("hold", Heuristic::gradient, 0.0, 0.2, 1.0),
                             rowOf("reference", Heuristic::gradient, 0.0, 0.0, 90.0)};
  EXPECT_EQ(nameAmong(rows[0].configuration, summariesOf(rows)), "spheres, gradient, voxel");
  rows.push_back(rows[0]);
  rows.back().configuration.serverSidePx = 256;
  EXPECT_EQ(nameAmong(rows[0].configuration, summariesOf(rows)), "spheres, gradient, voxel, server's image of 512 px");
  EXPECT_EQ(nameAmong(rows[1].configuration, summariesOf(rows)), "hold, server's image of 512 px");
  EXPECT_EQ(nameAmong(rows[2].configuration, summariesOf(rows)), "reference");  // which needs no frame
  rows.back().configuration.march.render.step *= 2.0f;
  EXPECT_EQ(nameAmong(rows[2].configuration, summariesOf(rows)), "reference, step " + numberText(rows[2].configuration.march.render.step));
  rows.back() = rows[0];
  rows.back().configuration.codec.color = ColorCoding::lossless;
  ASSERT_NE(rows.back().configuration.codec, rows[0].configuration.codec);
  EXPECT_EQ(nameAmong(rows[0].configuration, summariesOf(rows)), "spheres, gradient, voxel, " + codecWord(rows[0].configuration.codec));
}

TEST(Findings, OfNothing) {
  const Findings findings = findingsOf({});
  EXPECT_FALSE(findings.least);
  EXPECT_THAT(findings.answer, testing::HasSubstr("nothing measured"));
}

TEST(SweepRow, ComesBackFromJson) {
  SweepRow row = rowOf("multihit", Heuristic::expected, 12.5, 0.25, 3.0);
  row.errors.psnrDb = std::numeric_limits<double>::infinity();
  row.errors.psnrLinearDb = 31.25;
  row.errors.flipVisible = 0.125;
  row.errors.ssim = -0.5;
  row.errors.holeFraction = 0.0625;
  row.disoccludedFraction = 0.5;
  row.cost = {1234, 5678, {1, 2}, {3, 4}, {5, 6}, {7, 8}, {9, 10}, {11, 12}, {13, 14}};
  for (const bool isMoving : {false, true}) {
    if (isMoving) {
      row.link = "delay=100";
      row.ageMs = 250.0;
      row.framesPerSecond = 4.0;
      row.flicker = 0.125;
      row.disoccludedFraction.reset();
    }
    const nlohmann::json json = toJson(row);
    const JsonDocument document(json.dump(), "row");
    EXPECT_EQ(toJson(sweepRowFrom(document.root(), {})), json);
    EXPECT_EQ(json["frameMs"], 9.0 + 11.0 + 13.0 + 3.0);
    EXPECT_EQ(json["serverMs"], 1.0 + 3.0 + 5.0 + 7.0);
    EXPECT_TRUE(json["psnrDb"].is_null());
  }
}

TEST(SweepRow, OfASweepThatCountedUploadsAsBuilds) {
  nlohmann::json json = toJson(rowOf("spheres", Heuristic::gradient, 0.0, 0.1, 3.0));
  json["buildMs"] = 5.0;
  json.erase("uploadMs");
  json.erase("uploadSpreadMs");
  const JsonDocument document(json.dump(), "row");
  EXPECT_EQ(sweepRowFrom(document.root(), {}).frameMs(), 8.0);
}

TEST(SweepRow, AsCsvHasAFieldForEachColumn) {
  SweepRow row = rowOf("points", Heuristic::median, 5.0, 0.1, 2.0);
  row.link = "delay=100,rate=20M";
  const std::string csv = csvOf({row});
  const size_t end = csv.find("\r\n");
  const auto commas = [](const std::string& text) { return std::count(text.begin(), text.end(), ','); };
  EXPECT_THAT(csv, testing::StartsWith("technique,heuristic,"));
  EXPECT_EQ(commas(csv.substr(end)), commas(csv.substr(0, end)) + 1);  // one within quotes
  EXPECT_THAT(csv, testing::HasSubstr("\"delay=100,rate=20M\""));
  EXPECT_THAT(csv, testing::HasSubstr("\r\npoints,median,"));
}

// --- Frames on a line of time

MotionStages stagesOf(double serverMs, double arrivalMs, double drawMs, size_t frameBytes) {
  MotionStages stages;
  stages.serverMs = serverMs;
  stages.arrivalMs = arrivalMs;
  stages.drawMs = drawMs;
  stages.frameBytes = frameBytes;
  return stages;
}

TEST(Motion, WithoutALinkAFrameIsAsOldAsItsStagesAndTheNextOnes) {
  // Requests leave at 0, 100, 200, ... and are ready 120 ms after they left. Pictures are finished each 50 ms.
  const Motion motion = simulateMotion({2.06, 2.16, 2.21}, stagesOf(100.0, 20.0, 50.0, 1000), {});
  ASSERT_EQ(motion.pictures.size(), 3u);
  EXPECT_NEAR(motion.pictures[0].drawnForS, 2.0, 1e-6);
  EXPECT_NEAR(motion.pictures[0].requestedS, 1.8, 1e-6);
  EXPECT_NEAR(motion.pictures[1].drawnForS, 2.1, 1e-6);
  EXPECT_NEAR(motion.pictures[1].requestedS, 1.9, 1e-6);  // drawing began before the next one was ready, at 2.12
  EXPECT_NEAR(motion.pictures[2].drawnForS, 2.15, 1e-6);
  EXPECT_NEAR(motion.pictures[2].requestedS, 2.0, 1e-6);
  EXPECT_NEAR(motion.framesPerSecond, 10.0, 0.5);
  EXPECT_NEAR(*motion.firstFrameS, 0.12, 1e-6);
}

TEST(Motion, AClientThatIsSlowTakesOneFrameAfterTheOtherAndTheNewest) {
  // Frames arrive each 10 ms, building takes 100.
  const Motion motion = simulateMotion({5.0}, stagesOf(10.0, 100.0, 0.0, 1000), {});
  const double ageS = 5.0 - motion.pictures[0].requestedS;
  EXPECT_GT(ageS, 0.105);
  EXPECT_LT(ageS, 0.235);  // its own 110 ms, the next one's 100, and the display's 17
  EXPECT_NEAR(motion.framesPerSecond, 100.0, 1.0);
}

TEST(Motion, ADisplayShowsNoMoreThanItsRate) {
  const Motion motion = simulateMotion({2.0 + 0.1 / 60, 2.0 + 0.9 / 60, 2.0 + 1.1 / 60}, stagesOf(1.0, 1.0, 1.0, 1000), {});
  EXPECT_EQ(motion.pictures[0].drawnForS, motion.pictures[1].drawnForS);
  EXPECT_NEAR(motion.pictures[2].drawnForS - motion.pictures[1].drawnForS, 1.0 / 60, 1e-9);
}

TEST(Motion, DelayAndRateMakeItOlder) {
  net::DuplexLinkSettings link;
  link.up.delayMs = link.down.delayMs = 50.0;
  link.down.rateBitPerS = 8e6;  // 100 kB take 100 ms
  const Motion motion = simulateMotion({5.0}, stagesOf(0.0, 0.0, 0.0, 100000), link);
  // A round trip of about 200 ms; the frame on show left between 200 and 400 ms ago.
  EXPECT_NEAR(motion.framesPerSecond, 5.0, 0.3);
  EXPECT_GT(5.0 - motion.pictures[0].requestedS, 0.19);
  EXPECT_LT(5.0 - motion.pictures[0].requestedS, 0.43);
}

TEST(Motion, BeforeTheFirstFrameThereIsNone) {
  const Motion motion = simulateMotion({0.5, 1.5}, stagesOf(1000.0, 0.0, 0.0, 0), {});
  EXPECT_FALSE(motion.pictures[0].hasFrame);
  EXPECT_TRUE(motion.pictures[1].hasFrame);
  EXPECT_EQ(motion.pictures[1].requestedS, 0.0);
  EXPECT_NEAR(*motion.firstFrameS, 1.0, 1e-6);
}

TEST(Motion, WhatTakesNothingEnds) {
  const Motion motion = simulateMotion({3.0}, {}, {});
  EXPECT_NEAR(motion.pictures[0].requestedS, 3.0, 2e-3 + 1.0 / 60);
  EXPECT_LE(motion.framesPerSecond, 1001.0);
}

TEST(Motion, IsTheSameEachTime) {
  const net::DuplexLinkSettings link = net::parseLinkSettings("conference-wifi");
  const MotionStages stages = stagesOf(50.0, 5.0, 8.0, 200000);
  const Motion a = simulateMotion({2.0, 3.0, 4.0}, stages, link), b = simulateMotion({2.0, 3.0, 4.0}, stages, link);
  for (size_t i = 0; i < a.pictures.size(); ++i) EXPECT_EQ(a.pictures[i].requestedS, b.pictures[i].requestedS);
}

}  // namespace
}  // namespace warpscope

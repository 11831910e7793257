// An earlier run beside today's: which figures there are, what differs by more than it varies, and what cannot be compared.
// Mirrors app/experiment/bench_comparison.h.
#include "app/experiment/bench_comparison.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace warpscope {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

json someReport(double marchMs, double spreadMs, double drawMs) {
  json report = json::parse(R"({
    "scene": "shells", "width": 256, "runs": 5, "version": "1", "step": 0.5, "marchMs": 1.0,
    "backends": [{
      "backend": "cpu", "device": "2 CPU threads", "samples": 1000, "serverMs": 9.0, "bytes": 500,
      "buildMs": 4.0, "views": [{"angleDeg": 0.0, "drawMs": 77.0}],
      "techniques": [{"technique": "spheres", "buildMs": 4.0, "buildSpreadMs": 0.1,
                      "views": [{"angleDeg": 0.0, "drawSpreadMs": 0.2, "fps": 100.0}, {"angleDeg": 25.0, "drawMs": 3.0, "drawSpreadMs": 0.0}]}]}]})");
  json& backend = report["backends"][0];
  backend["marchMs"] = marchMs;
  backend["marchSpreadMs"] = spreadMs;
  backend["techniques"][0]["views"][0]["drawMs"] = drawMs;
  return report;
}

std::vector<std::string> labelsOf(const std::vector<BenchFigure>& figures) {
  std::vector<std::string> labels;
  for (const BenchFigure& figure : figures) labels.push_back(figure.where + " " + figure.what);
  return labels;
}

const ComparedFigure& figureOf(const BenchComparison& comparison, const std::string& where, const std::string& what) {
  for (const ComparedFigure& figure : comparison.figures)
    if (figure.now.where == where && figure.now.what == what) return figure;
  throw std::out_of_range(where + ", " + what);
}

TEST(BenchComparison, FiguresAreMediansAndBytesEachOnce) {
  const std::vector<BenchFigure> figures = figuresOf(someReport(10.0, 1.0, 2.0));
  EXPECT_THAT(labelsOf(figures), ElementsAre("cpu: bytes", "cpu: marchMs", "cpu: serverMs", "cpu: spheres buildMs", "cpu: spheres, 0° drawMs", "cpu: spheres, 25° drawMs"));
  EXPECT_EQ(figures[0].spread, 0.0) << "bytes do not vary";
  EXPECT_EQ(figures[1].spread, 1.0);
  EXPECT_EQ(figures[2].spread, std::nullopt) << "a sum";
  EXPECT_TRUE(figuresOf(json::object()).empty());
  EXPECT_TRUE(figuresOf(json::parse(R"({"backends": 3})")).empty());
  EXPECT_TRUE(figuresOf(json::parse(R"({"backends": [1, {"backend": 2}]})")).empty());
}

TEST(BenchComparison, EffectsAreFiguresAndTheirDifferencesAreNot) {
  const json report = json::parse(R"({"backends": [{"backend": "cuda", "noneMs": 1.0, "noneSpreadMs": 0.1, "addsMs": 2.0,
                                       "effects": [{"effect": "jitter", "marchMs": 1.5, "marchSpreadMs": 0.2, "addsMs": -0.5, "savesMs": 0.1}]}]})");
  EXPECT_THAT(labelsOf(figuresOf(report)), ElementsAre("cuda: noneMs", "cuda: jitter marchMs"));
}

TEST(BenchComparison, AVerdictNeedsRangesThatAreApart) {
  const auto verdict = [](double before, double beforeSpread, double now, double nowSpread) {
    return figureOf(compared(someReport(before, beforeSpread, 2.0), someReport(now, nowSpread, 2.0)), "cpu:", "marchMs").verdict;
  };
  EXPECT_EQ(verdict(10.0, 1.0, 8.9, 1.0), BenchVerdict::less);
  EXPECT_EQ(verdict(10.0, 1.0, 9.1, 1.0), BenchVerdict::unclear) << "9.5 and 9.6 meet";
  EXPECT_EQ(verdict(10.0, 1.0, 11.1, 1.0), BenchVerdict::more);
  EXPECT_EQ(verdict(10.0, 1.0, 11.0, 1.0), BenchVerdict::unclear) << "they touch";
  EXPECT_EQ(verdict(10.0, 0.0, 10.0, 0.0), BenchVerdict::unclear);
  const BenchComparison comparison = compared(someReport(10.0, 1.0, 2.0), someReport(5.0, 1.0, 4.0));
  EXPECT_DOUBLE_EQ(*figureOf(comparison, "cpu:", "marchMs").ratio(), 0.5);
  EXPECT_EQ(figureOf(comparison, "cpu: spheres, 0°", "drawMs").verdict, BenchVerdict::more);
  EXPECT_EQ(figureOf(comparison, "cpu:", "serverMs").verdict, BenchVerdict::unclear) << "it has no spread";
  const std::string text = textOf(comparison);
  EXPECT_THAT(text, HasSubstr("0.500  faster\n"));
  EXPECT_THAT(text, HasSubstr("2.000  slower\n"));
  EXPECT_THAT(text, HasSubstr("1.000  no spread is known\n"));
  EXPECT_THAT(text, HasSubstr("1.000  the same\n"));
  const json described = toJson(comparison);
  EXPECT_EQ(described["figures"].size(), 6u);
  EXPECT_TRUE(described["figures"][2]["nowSpread"].is_null());
}

TEST(BenchComparison, WhatOnlyOneHasAndWhatDiffersBesideIsSaid) {
  json before = someReport(10.0, 1.0, 2.0), now = before;
  now["backends"][0]["techniques"][0]["technique"] = "splats";
  now["backends"][0]["device"] = "64 CPU threads";
  now["version"] = "2";
  const BenchComparison comparison = compared(before, now);
  EXPECT_EQ(comparison.figures.size(), 3u);
  EXPECT_THAT(comparison.onlyBefore, ElementsAre("cpu: spheres, buildMs", "cpu: spheres, 0°, drawMs", "cpu: spheres, 25°, drawMs"));
  EXPECT_EQ(comparison.onlyNow.size(), 3u);
  EXPECT_THAT(comparison.differences, ElementsAre("version 1 then, 2 now", "cpu was 2 CPU threads then and is 64 CPU threads now"));
  EXPECT_THAT(textOf(comparison), HasSubstr("then alone: 3 figures, the first cpu: spheres, buildMs"));
}

TEST(BenchComparison, WhatIsNoBackendIsPassedOver) {
  json before = someReport(10.0, 1.0, 2.0);
  const json now = before;
  before["backends"].push_back(3);
  before["backends"].push_back(nullptr);
  before["version"] = 4;
  const BenchComparison comparison = compared(before, now);
  EXPECT_EQ(comparison.figures.size(), 6u);
  EXPECT_THAT(comparison.differences, ElementsAre("version an unknown one then, 1 now"));
}

TEST(BenchComparison, OtherConditionsForbidIt) {
  const json before = someReport(10.0, 1.0, 2.0);
  EXPECT_EQ(whyNotComparable(before, before), "");
  json now = before;
  now["runs"] = 50;
  now["version"] = "2";
  now["marchMs"] = 1.0;
  EXPECT_EQ(whyNotComparable(before, now), "") << "as often and by whom is no condition";
  now["step"] = 1.0;
  EXPECT_EQ(whyNotComparable(before, now), "step was 0.5 then and is 1.0 now");
  now = before;
  now["scene"] = "block";
  EXPECT_EQ(whyNotComparable(before, now), "scene was \"shells\" then and is \"block\" now");
}

}  // namespace
}  // namespace warpscope

// Sweeps of a small scene: every unit is measured, rows are what drawing anew gives, what is done is not done again, nothing is lost.
// Mirrors app/experiment/sweep.h, journal.h, ground_truth.h, report.h and svg_plot.h.
#include "app/experiment/sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>

#include "app/experiment/ground_truth.h"
#include "app/experiment/report.h"
#include "app/picture/heat_map.h"
#include "app/picture/plot_picture.h"
#include "app/picture/svg_plot.h"
#include "app/scene/json_document.h"
#include "render/base/error.h"
#include "render/warp/fill.h"
#include "render/warp/kept_frames.h"
#include "tests/headless.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

SweepPlan smallPlan(const Scene& scene) {
  SweepPlan plan = defaultPlan(scene.march, 96, 72);
  const JsonDocument document(R"({"techniques": ["reference", "hold", "spheres", "splats"], "heuristics": ["median", "gradient"], "radii": ["voxel"],
    "serverSides": [96], "codecs": ["lossless"], "angles": [0, 20], "links": ["delay=100"], "instants": 2, "draws": 2})", "plan");
  applyPlanFile(document.root(), plan);
  return plan;
}

class SweepTest : public ::testing::Test {
 protected:
  SweepTest() : stage_(smallScene("block")) {
    settings_.plan = smallPlan(stage_.scene());
    settings_.width = 96;
    settings_.height = 72;
    settings_.warp.reference = stage_.scene().march.render;
  }

  TestFolder folder_;
  Stage stage_;
  SweepSettings settings_;
  nlohmann::json identity_{{"scene", "block"}};
};

TEST_F(SweepTest, EveryConfigurationAtEveryAngleAndBehindEveryLink) {
  SweepJournal journal(folder_.path(), identity_, stage_.scene().march);
  size_t steps = 0;
  Sweep run(stage_.scene(), stage_.resources(), settings_, {});
  const std::vector<SweepRow> rows = run.run(journal, [&](const std::string&) { ++steps; });
  // reference, hold, spheres and splats twice each, and the points of 2012.
  ASSERT_EQ(configurationsOf(settings_.plan).size(), 7u);
  EXPECT_EQ(steps, 7u * 2);
  ASSERT_EQ(rows.size(), 7u * 3);
  for (const SweepRow& row : rows) {
    const bool usesFrame = row.configuration.technique->usesFrame;
    EXPECT_EQ(row.cost.samples > 0, usesFrame);
    EXPECT_EQ(row.cost.bytes > 0, usesFrame);
    EXPECT_EQ(row.cost.serverMs() > 0, usesFrame);
    EXPECT_GT(row.draw.medianMs, 0.0);
    EXPECT_EQ(row.draws, 2);
    EXPECT_EQ(row.disoccludedFraction.has_value(), row.link.empty());
    EXPECT_EQ(row.flicker.has_value(), !row.link.empty());
    if (row.link.empty()) {
      EXPECT_EQ(row.errors.flip == 0.0, !usesFrame) << keyOf(row.configuration) << row.angleDeg;
    }
    if (!row.link.empty() && usesFrame) {
      EXPECT_GE(row.ageMs, 200.0);
      EXPECT_NEAR(row.angleDeg, settings_.plan.speedDegPerS * row.ageMs * 1e-3, 1e-9);
      EXPECT_GT(row.framesPerSecond, 1.0);
      EXPECT_LE(row.framesPerSecond, 5.0);
      EXPECT_GT(row.errors.flip, 0.0);
    }
  }
  const std::vector<SweepFloor> floors = run.floors();
  ASSERT_EQ(floors.size(), 2u);
  for (const SweepFloor& floor : floors) {
    EXPECT_GT(floor.errors.flip, 0.0);
    EXPECT_LT(floor.errors.flip, 0.02);
  }
}

TEST_F(SweepTest, FramesThatAreKeptAreThoseOfACameraThatCameTurning) {
  applyPlanFile(JsonDocument(R"({"techniques": ["spheres", "segments"], "keeps": [1, 3], "angles": [-12, 0, 12], "heuristics": ["gradient"], "fills": ["none"],
    "links": ["delay=100"]})", "plan").root(), settings_.plan);
  SweepJournal journal;
  Sweep run(stage_.scene(), stage_.resources(), settings_, {});
  const std::vector<SweepRow> rows = run.run(journal, [](const std::string&) {});
  const auto rowOf = [&](std::string_view technique, double keep, double angleDeg, bool isMoving = false) -> const SweepRow& {
    return *std::ranges::find_if(rows, [&](const SweepRow& row) {
      const Configuration& c = row.configuration;
      return c.technique->name == technique && c.knobs[kKeepKnob] == keep && c.knobs.choice<Fill>(kFillKnob) == Fill::none &&
             (isMoving ? !row.link.empty() : row.link.empty() && row.angleDeg == angleDeg);
    });
  };
  for (const std::string_view technique : {"spheres", "segments"}) {
    SCOPED_TRACE(technique);
    // They saw what lies on the side that the camera came from.
    EXPECT_LE(rowOf(technique, 3, -12.0).errors.holeFraction, 0.7 * rowOf(technique, 1, -12.0).errors.holeFraction);
    EXPECT_GT(rowOf(technique, 3, -12.0).errors.psnrDb, rowOf(technique, 1, -12.0).errors.psnrDb - 0.1);
    EXPECT_LE(rowOf(technique, 3, 12.0).errors.holeFraction, rowOf(technique, 1, 12.0).errors.holeFraction);
    EXPECT_GT(rowOf(technique, 3, 0.0, true).framesPerSecond, 0.0);  // how old its pictures are is a matter of time
    EXPECT_EQ(rowOf(technique, 3, 0.0).cost.bytes, rowOf(technique, 1, 0.0).cost.bytes) << "nothing more is sent";
    EXPECT_NE(labelOf(rowOf(technique, 3, 0.0).configuration).find("3 frames kept"), std::string::npos);
    // The same as from frames that are handed over one by one.
    const Configuration& three = rowOf(technique, 3, 0.0).configuration;
    const std::unique_ptr<Warp> warp = makeWarp(findWarp(technique), stage_.resources());
    const WarpSettings settings = three.warp(settings_.warp);
    for (const double turnDeg : {-8.0, -4.0, 0.0}) warp->setFrame(stage_.frame(stage_.camera(96, 72, turnDeg), three.march), settings);
    WarpedImage image, truth;
    warp->draw(stage_.camera(96, 72, -12.0), settings, image);
    stage_.marcher().render(stage_.camera(96, 72, -12.0), stage_.scene().march.render, truth.color);
    EXPECT_NEAR(rowOf(technique, 3, -12.0).errors.holeFraction, PictureJudge(truth.color, stage_.scene().background).errorsOf(image).holeFraction, 0.01);
  }
}

TEST_F(SweepTest, ErrorsAreThoseOfThePictures) {
  SweepJournal journal(folder_.path(), identity_, stage_.scene().march);
  Sweep run(stage_.scene(), stage_.resources(), settings_, {});
  const std::vector<SweepRow> rows = run.run(journal, [](const std::string&) {});
  for (const SweepRow& row : rows) {
    if (!row.link.empty() || !row.configuration.technique->usesFrame) continue;
    // Lossless: the frame is what the marcher makes.
    const SampleFramePtr frame = stage_.frame(stage_.camera(96, 72), row.configuration.march);
    const Camera camera = stage_.camera(96, 72, row.angleDeg);
    WarpedImage truth;
    stage_.marcher().render(camera, stage_.scene().march.render, truth.color);
    const WarpedImage image = stage_.draw(row.configuration.technique->name, frame, camera, row.configuration.warp(settings_.warp));
    const PictureErrors errors = PictureJudge(truth.color, stage_.scene().background).errorsOf(image);
    EXPECT_EQ(row.errors.flip, errors.flip) << keyOf(row.configuration) << row.angleDeg;
    EXPECT_EQ(row.errors.holeFraction, errors.holeFraction);
    EXPECT_EQ(row.cost.samples, frame->size());
  }
  // Spheres and splats draw the same picture.
  const auto errorOf = [&](std::string_view technique) {
    return std::find_if(rows.begin(), rows.end(), [&](const SweepRow& row) {
             return row.configuration.technique->name == technique && row.angleDeg == 20.0 && row.configuration.march.sample.heuristic == Heuristic::median;
           })->errors.flip;
  };
  EXPECT_NEAR(errorOf("spheres"), errorOf("splats"), 1e-3);
}

TEST_F(SweepTest, WhatIsDoneIsNotDoneAgain) {
  std::stop_source source;
  size_t steps = 0;
  {
    SweepJournal journal(folder_.path(), identity_, stage_.scene().march);
    Sweep run(stage_.scene(), stage_.resources(), settings_, source.get_token());
    EXPECT_THROW(run.run(journal, [&](const std::string&) {
      if (++steps == 5) source.request_stop();
    }), OperationCancelled);
  }
  const std::string text = folder_.read("sweep-unfinished.jsonl");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1 + 4);
  std::ofstream(folder_.path() / "sweep-unfinished.jsonl", std::ios::binary | std::ios::app) << R"({"unit": "cut o)";  // as a crash may leave it

  SweepJournal journal(folder_.path(), identity_, stage_.scene().march);
  EXPECT_EQ(journal.found(), 4u);
  steps = 0;
  Sweep run(stage_.scene(), stage_.resources(), settings_, {});
  const std::vector<SweepRow> rows = run.run(journal, [&](const std::string&) { ++steps; });
  EXPECT_EQ(steps, 7u * 2 - 4);
  EXPECT_EQ(rows.size(), 7u * 3);
  journal.remove();
  EXPECT_TRUE(folder_.listing().empty());
}

TEST_F(SweepTest, AJournalIsOneSweepsAtATime) {
  const auto refusal = [&](const nlohmann::json& identity) -> std::string {
    try {
      SweepJournal(folder_.path(), identity, {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  {
    const SweepJournal journal(folder_.path(), identity_, {});
    EXPECT_THAT(refusal(identity_), testing::HasSubstr("another sweep is at work"));
  }
  EXPECT_THAT(refusal({{"scene", "other"}}), testing::HasSubstr("unfinished sweep of other settings"));
  EXPECT_EQ(refusal(identity_), "accepted");
}

TEST_F(SweepTest, WhatIsDamagedOrAnothersIsMeasuredAnew) {
  const Sweep::Step quiet = [](const std::string&) {};
  std::vector<SweepRow> rows;
  {
    SweepJournal journal(folder_.path(), identity_, stage_.scene().march);
    rows = Sweep(stage_.scene(), stage_.resources(), settings_, {}).run(journal, quiet);
  }
  // Line by line: the head, then units. Damage some of them.
  std::istringstream text(folder_.read("sweep-unfinished.jsonl"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 1 + 7u * 2);
  const nlohmann::json first = nlohmann::json::parse(lines[1]), second = nlohmann::json::parse(lines[2]);
  const auto with = [](nlohmann::json unit, const char* key, const nlohmann::json& value) {
    unit[key] = value;
    return unit.dump();
  };
  nlohmann::json twice = first["rows"];
  twice.push_back(first["rows"][0]);
  for (const std::string& damaged : {with(first, "rows", nlohmann::json::array()), with(first, "rows", second["rows"]), with(first, "rows", twice),
                                     with(first, "rows", 3), lines[1].substr(0, 40), std::string(), std::string("{}"), std::string(20, '\0')}) {
    std::string file = lines[0] + "\n" + damaged + "\n";
    for (size_t i = 2; i < lines.size(); ++i) file += lines[i] + "\n";
    folder_.write("sweep-unfinished.jsonl", file);
    SweepJournal journal(folder_.path(), identity_, stage_.scene().march);
    size_t steps = 0;
    const std::vector<SweepRow> again = Sweep(stage_.scene(), stage_.resources(), settings_, {}).run(journal, [&](const std::string&) { ++steps; });
    EXPECT_EQ(steps, 1u) << damaged.substr(0, 60);
    ASSERT_EQ(again.size(), rows.size());
    for (size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(keyOf(again[i].configuration), keyOf(rows[i].configuration));
  }
}

TEST_F(SweepTest, AJournalIsAFile) {
  ASSERT_EQ(mkfifo(folder_.file("sweep-unfinished.jsonl").c_str(), 0600), 0);
  EXPECT_THROW(SweepJournal(folder_.path(), identity_, {}), InputError);
}

TEST_F(SweepTest, TheTruthKnowsWhatWasHidden) {
  GroundTruth truth(stage_.scene(), stage_.resources().marcher, stage_.scene().march.render, 96, 72);
  EXPECT_EQ(truth.seenAt(0.0, {}).disoccludedFraction, 0.0);
  EXPECT_GT(truth.seenAt(45.0, {}).disoccludedFraction, truth.seenAt(10.0, {}).disoccludedFraction);
  EXPECT_EQ(&truth.at(45.0, {}), &truth.at(45.0, {}));
  const Camera half = truth.camera(0.0, 48);
  EXPECT_EQ(half.width, 48u);
  EXPECT_EQ(half.height, 36u);
  EXPECT_EQ(truth.camera(0.0, 1).height, 1u);
}

TEST_F(SweepTest, TheReportHoldsWhatItShould) {
  SweepJournal journal(folder_.path(), identity_, stage_.scene().march);
  Sweep run(stage_.scene(), stage_.resources(), settings_, {});
  SweepReport report;
  report.title = "Blocks <&> more";
  report.rows = run.run(journal, [](const std::string&) {});
  report.floors = run.floors();
  report.summaries = summariesOf(report.rows);
  report.findings = findingsOf(report.rows);
  report.links = settings_.plan.links;
  for (const Configuration& configuration : shownConfigurations(report.summaries, report.findings))
    report.strips.push_back({configuration, run.pictures(configuration)});
  report.head = {{"scene", "block"}, {"width", 96}, {"height", 72}, {"plan", toJson(settings_.plan)}, {"version", "1"},
                 {"machine", {{"backend", "cpu"}, {"openGl", ""}, {"devices", nlohmann::json::array()}, {"threads", 2}}}};
  EXPECT_GE(report.strips.size(), 5u);
  for (const PictureStrip& strip : report.strips) ASSERT_EQ(strip.pictures.size(), 2u);

  const std::string html = htmlOf(report);
  EXPECT_THAT(html, testing::HasSubstr("Blocks &lt;&amp;&gt; more"));
  EXPECT_THAT(html, testing::Not(testing::HasSubstr("http")));  // nothing is fetched
  const auto count = [&](const std::string& what) {
    size_t found = 0;
    for (size_t at = html.find(what); at != std::string::npos; at = html.find(what, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(count("<svg"), 4u);
  EXPECT_EQ(count("<svg"), count("</svg>"));
  EXPECT_EQ(count("<img"), 2 * (2 * report.strips.size() - 1));  // a heat map beneath each but the reference
  EXPECT_EQ(count("<tr>"), count("</tr>"));
  EXPECT_THAT(html, testing::HasSubstr("<strong>delay=100</strong>: 200 ms there and back</li>"));
  std::istringstream headline(report.findings.headline);
  size_t sentences = 0;
  for (std::string sentence; std::getline(headline, sentence); ++sentences) EXPECT_THAT(html, testing::HasSubstr("<p>" + escaped(sentence) + "</p>"));
  EXPECT_EQ(sentences, 3u);
  for (const SweepRow& row : report.rows) EXPECT_THAT(html, testing::HasSubstr(labelOf(row.configuration)));
}

/// Pixels of that colour, sRGB 0xRRGGBB, and the middle of where they are.
std::pair<size_t, glm::dvec2> pixelsOf(const Image<Rgba8>& picture, uint32_t rgb) {
  const Rgba8 code = 0xff000000u | (rgb & 255) << 16 | (rgb & 0xff00) | rgb >> 16;
  size_t count = 0;
  glm::dvec2 sum(0.0);
  for (uint32_t y = 0; y < picture.height(); ++y)
    for (uint32_t x = 0; x < picture.width(); ++x)
      if (picture(x, y) == code) {
        ++count;
        sum += glm::dvec2(x + 0.5, y + 0.5);
      }
  return {count, sum / std::max(1.0, static_cast<double>(count))};
}

TEST(SvgPlot, ShowsPointsWhereTheyAre) {
  Plot plot{{"x", true}, {"y", false}, {{"a<b", 0x123456, {{1.0, 0.0, "one"}, {100.0, 1.0, "two", true}, {10.0, 0.5, "three"}}}}};
  const std::string svg = svgOf(plot);
  EXPECT_THAT(svg, testing::HasSubstr("a&lt;b"));
  EXPECT_THAT(svg, testing::HasSubstr("<title>three</title>"));
  EXPECT_THAT(svg, testing::HasSubstr("class=\"ring\""));
  const auto placeOf = [&](const std::string& title, const std::string& axis) {
    const size_t circle = svg.find("<circle", svg.find("<title>" + title));
    const size_t at = svg.find(axis + "=\"", circle) + axis.size() + 2;
    return std::stod(svg.substr(at));
  };
  EXPECT_NEAR(placeOf("three", "cx"), 0.5 * (placeOf("one", "cx") + placeOf("two", "cx")), 0.02);  // logarithmic
  EXPECT_NEAR(placeOf("three", "cy"), 0.5 * (placeOf("one", "cy") + placeOf("two", "cy")), 0.02);
  EXPECT_GT(placeOf("one", "cy"), placeOf("two", "cy"));  // up is more
}

TEST(SvgPlot, PointsThatWouldHideEachOtherAreOneMark) {
  const Plot plot{{"x", true}, {"y", true}, {{"a", 0xaa0000, {{1.0, 1.0, "first"}, {1.001, 1.0, "second", true}, {100.0, 1.0, "alone"}}},
                                             {"b", 0x00bb00, {{1.0, 1.001, "third"}, {100.0, 100.0, "far"}}}}};
  const std::string svg = svgOf(plot);
  const auto count = [&](const std::string& what) {
    size_t found = 0;
    for (size_t at = svg.find(what); at != std::string::npos; at = svg.find(what, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(count("<g class=\"mark\">"), 3u);
  EXPECT_THAT(svg, testing::HasSubstr("<title>first\n\nsecond\n\nthird</title>"));
  EXPECT_EQ(count("class=\"count\""), 1u);
  EXPECT_THAT(svg, testing::HasSubstr(">3</text>"));
  EXPECT_EQ(count("<path fill=\"#aa0000\""), 1u);  // a sector for each colour, not for each point
  EXPECT_EQ(count("<path fill=\"#00bb00\""), 1u);
  EXPECT_EQ(count("class=\"ring\""), 1u);
}

TEST(SvgPlot, BearsWhatCannotBeShown) {
  EXPECT_THAT(svgOf({}), testing::HasSubstr("</svg>"));
  const Plot plot{{"x", true}, {"y", true}, {{"a", 0xff0000, {{0.0, -1.0, "none"}, {5.0, 5.0, "one"}, {std::nan(""), INFINITY, "no number"}}}}};
  EXPECT_THAT(svgOf(plot), testing::Not(testing::HasSubstr("nan\"")));
  const Plot line{{"x", false}, {"y", false}, {{"a", 0xff0000, {{1.0, 1.0, ""}, {std::nan(""), 2.0, ""}, {3.0, 3.0, ""}}, true}}};
  EXPECT_THAT(svgOf(line), testing::Not(testing::HasSubstr("nan,")));
  EXPECT_GT(pixelsOf(pictureOf(line, 1.0f), 0xff0000).first, 300u) << "from the first point to the third";
}

TEST(PlotPicture, ShowsWhatTheSvgShows) {
  const Plot plot{{"x", true}, {"y", false}, {{"", 0xd03030, {{1.0, 0.0, "one"}}}, {"", 0x3030d0, {{100.0, 1.0, "two", true}}}, {"", 0x209020, {{10.0, 0.5, "three"}}},
                                              {"a line", 0x905090, {{1.0, 1.0, ""}, {100.0, 0.0, ""}}, true, true}}};
  const std::string svg = svgOf(plot);
  for (const float scale : {1.0f, 2.0f}) {
    const Image<Rgba8> picture = pictureOf(plot, scale);
    for (const uint32_t rgb : {0xd03030u, 0x3030d0u, 0x209020u}) {
      char fill[32];
      std::snprintf(fill, sizeof fill, "fill=\"#%06x\"", rgb);
      const std::string circle = svg.substr(svg.rfind("<circle", svg.find(fill)), 60);
      const auto at = [&](const char* axis) { return std::stod(circle.substr(circle.find(axis) + 4)); };
      const auto [count, middle] = pixelsOf(picture, rgb);
      EXPECT_NEAR(middle.x, scale * at("cx=\""), 0.6);
      EXPECT_NEAR(middle.y, scale * at("cy=\""), 0.6);
      const double inner = scale * 3.6 - 0.5;  // of its border pixels are mixed with white
      EXPECT_NEAR(static_cast<double>(count), 3.1416 * inner * inner, 0.1 * inner * inner + 4.0);
    }
    EXPECT_GT(pixelsOf(picture, 0x905090).first, 100u * static_cast<size_t>(scale)) << "its legend's disc, and the line";
    // The name of the vertical axis reads upwards, left of all else: taller than wide.
    uint32_t ink = 0;
    for (uint32_t y = 0; y < picture.height(); ++y)
      for (uint32_t x = 0; x < static_cast<uint32_t>(20 * scale); ++x) ink += picture(x, y) != 0xffffffffu;
    EXPECT_GT(ink, 10u);
  }
}

TEST(PlotPicture, SharedPlacesHaveAllColours) {
  const Plot plot{{"x", true}, {"y", true}, {{"", 0xaa0000, {{1.0, 1.0, ""}}}, {"", 0x00bb00, {{1.0, 1.0, ""}}}}};
  const Image<Rgba8> picture = pictureOf(plot, 4.0f);
  const auto [reds, red] = pixelsOf(picture, 0xaa0000);
  const auto [greens, green] = pixelsOf(picture, 0x00bb00);
  EXPECT_GT(reds, 400u);
  EXPECT_NEAR(static_cast<double>(reds), static_cast<double>(greens), 0.1 * static_cast<double>(reds));
  EXPECT_GT(red.x, green.x) << "from the top, clockwise";
  EXPECT_NEAR(red.y, green.y, 1.0);
}

TEST(PlotPicture, BearsWhatCannotBeShown) {
  EXPECT_GT(pictureOf({}, 1.0f).width(), 100u);
  const Plot plot{{"x", true}, {"y", true}, {{"a", 0xff0000, {{0.0, -1.0, "none"}, {5.0, 5.0, "one"}, {std::nan(""), INFINITY, "no number"}, {7.0, 1.0, ""}}, true, true}}};
  EXPECT_GT(pixelsOf(pictureOf(plot, 1.0f), 0xff0000).first, 10u);
}

TEST(HeatMap, BrighterIsMore) {
  const auto lightness = [](Rgba8 color) { return 0.2126 * linearFromSrgb((color & 255) / 255.0f) + 0.7152 * linearFromSrgb((color >> 8 & 255) / 255.0f) +
                                                  0.0722 * linearFromSrgb((color >> 16 & 255) / 255.0f); };
  EXPECT_EQ(heatColor(0.0f), 0xff000000u);
  EXPECT_EQ(heatColor(-1.0f), heatColor(std::nanf("")));
  EXPECT_EQ(heatColor(2.0f), heatColor(1.0f));
  for (int i = 1; i <= 255; ++i) EXPECT_GT(lightness(heatColor(static_cast<float>(i) / 255.0f)), lightness(heatColor(static_cast<float>(i - 1) / 255.0f))) << i;
  Image<float> map(3, 1);
  map[1] = 0.25f;
  map[2] = 1.0f;
  const Image<Rgba8> colors = heatMap(map, 2.0f);
  EXPECT_EQ(colors[0], heatColor(0.0f));
  EXPECT_EQ(colors[1], heatColor(0.5f));
  EXPECT_EQ(colors[2], heatColor(1.0f));
}

}  // namespace
}  // namespace warpscope

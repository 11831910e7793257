// The report of a window without a window: gaps and ages that are known, null where there is nothing to tell.
// Mirrors app/session/window_report.h. Times are made up; the session behind them is a real one with a tiny volume.
#include "app/session/window_report.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "app/frames/backend.h"

namespace warpscope {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

class WindowReportTest : public testing::Test {
 protected:
  WindowReportTest() { session_.setPanelSize({40, 56}); }

  static SessionSettings settings() {
    SessionSettings settings;
    settings.panels = {{.technique = &findWarp("points")}, {.technique = &findWarp("reference")}};  // with frames, and without
    settings.knobs.serverSidePx = 48;
    return settings;
  }

  /// Opens a scene that this process serves, and waits until both panels show it and nothing is under way.
  void open() {
    session_.load({"block", [io = io_](const std::function<void()>& onNews, const std::stop_token& stop) {
                     SceneOverrides overrides;
                     overrides.proceduralDims = {16, 16, 16};
                     Scene scene = openScene("block", overrides, stop);
                     const MarcherPtr marcher = makeMarcher(Backend::cpu, scene.volume, scene.transferFunction);
                     return hostScene(io, std::move(scene), marcher, {}, onNews, stop);
                   }});
    const auto isSettled = [this] {
      const Panel& panel = session_.panel(0);
      return panel.picture && panel.errorsAreCurrent && session_.panel(1).picture && session_.ageMs(0, clock_.now()) == 0.0;
    };
    for (const auto limit = clock_.now() + std::chrono::seconds(60); clock_.now() < limit && !isSettled();
         std::this_thread::sleep_for(milliseconds(1)))
      session_.update(clock_.now());
    ASSERT_TRUE(isSettled());
  }
  json report(Clock::TimePoint now) const { return json::parse(report_.text(session_, now)); }

  SteadyClock clock_;
  std::shared_ptr<net::IoThread> io_ = std::make_shared<net::IoThread>();
  Session session_{settings(), [] {}};
  WindowReport report_;
  const Clock::TimePoint start_ = clock_.now();
};

TEST_F(WindowReportTest, WithoutASceneThereIsNothingToTell) {
  const json figures = report(start_);
  for (const char* key : {"framesPerSecond", "gapMs", "ageMs", "lastFrameAgeMs", "server"}) {
    ASSERT_TRUE(figures.contains(key)) << key;
    EXPECT_TRUE(figures[key].is_null()) << key;
  }
  EXPECT_EQ(figures["framesReceived"], 0);
  EXPECT_EQ(figures["panels"], json::array({nullptr, nullptr}));
  const json nothing{{"made", 0},         {"builds", 0},         {"draws", 0},
                     {"drawsToJudge", 0}, {"shortcutsTaken", 0}, {"stages", json::array()}};
  EXPECT_EQ(figures["work"], json::array({nothing, nothing}));
}

TEST_F(WindowReportTest, GapsAreThoseWhileSomethingMoves) {
  for (const int ms : {0, 10, 20, 60}) report_.add(session_, start_ + milliseconds(ms), true);
  report_.add(session_, start_ + milliseconds(5000), false);  // a rest: neither the gap before it counts nor the one after it
  for (const int ms : {9000, 9030}) report_.add(session_, start_ + milliseconds(ms), true);
  const json figures = report(start_ + milliseconds(9030));
  // 10, 10, 40 and 30 ms.
  EXPECT_DOUBLE_EQ(figures["framesPerSecond"], 4e3 / 90.0);
  EXPECT_DOUBLE_EQ(figures["gapMs"]["median"], 30.0);
  EXPECT_DOUBLE_EQ(figures["gapMs"]["longest"], 40.0);
}

TEST_F(WindowReportTest, TheThreadsTimesHaveAMedianAndALongest) {
  EXPECT_TRUE(report(start_)["threadMs"].is_null());
  for (const double ms : {4.0, 2.0, 9.0}) report_.add({0.5, 0.5, ms - 1.0});
  EXPECT_DOUBLE_EQ(report(start_)["threadMs"]["median"], 4.0);
  EXPECT_DOUBLE_EQ(report(start_)["threadMs"]["longest"], 9.0);
}

TEST_F(WindowReportTest, FramesThatAHandWouldFeelAreListed) {
  report_.add({1.0, 2.0, 30.0});
  report_.add({1.0, 20.0, 12.5, 86400.25});
  const auto frames = report(start_)["threadFrames"];
  EXPECT_EQ(frames["all"], 2);
  EXPECT_EQ(frames["over33Ms"], 1);
  EXPECT_EQ(frames["hitches"], nlohmann::json::parse(R"([{"frame": 1, "sessionMs": 1.0, "widgetsMs": 20.0, "openGlMs": 12.5, "endedS": 86400.25}])"));
}

TEST_F(WindowReportTest, OneFrameHasNoGap) {
  report_.add(session_, start_, true);
  EXPECT_TRUE(report(start_)["gapMs"].is_null());
  EXPECT_TRUE(report(start_)["framesPerSecond"].is_null());
}

TEST_F(WindowReportTest, AgesAreThoseOfFramesOfAnotherCamera) {
  open();
  report_.add(session_, clock_.now(), false);
  EXPECT_TRUE(report(clock_.now())["ageMs"].is_null()) << "the frame on show is of the current camera";

  View view = session_.view();
  view.angleDeg += 20.0;
  session_.setView(view);
  const Clock::TimePoint moved = clock_.now();
  session_.update(moved);
  for (const int ms : {30, 10, 20}) report_.add(session_, moved + milliseconds(ms), true);
  const json figures = report(moved + milliseconds(30));
  EXPECT_DOUBLE_EQ(figures["ageMs"]["median"], 20.0);
  EXPECT_DOUBLE_EQ(figures["ageMs"]["longest"], 30.0);
}

TEST_F(WindowReportTest, PicturesAndMarchesAreThoseWhileSomethingMoves) {
  open();
  report_.add(session_, start_, false);  // what was there before does not count
  EXPECT_TRUE(report(start_)["movingMarchMs"].is_null());
  EXPECT_EQ(report(start_)["picturesPerSecond"], json::array({nullptr, nullptr}));
  for (int i = 0; i <= 4; ++i) report_.add(session_, start_ + milliseconds(250 * i), true);
  EXPECT_TRUE(report(start_)["movingMarchMs"].is_null()) << "no frame came";
  EXPECT_EQ(report(start_)["picturesPerSecond"], json::array({0.0, 0.0}));

  View view = session_.view();
  view.angleDeg += 20.0;
  session_.setView(view);
  const uint64_t before = session_.panel(0).requestId;
  for (const auto limit = clock_.now() + std::chrono::seconds(60); clock_.now() < limit && session_.panel(0).requestId == before;
       std::this_thread::sleep_for(milliseconds(1)))
    session_.update(clock_.now());
  report_.add(session_, start_ + milliseconds(2000), true);
  const json figures = report(start_ + milliseconds(2000));
  EXPECT_DOUBLE_EQ(figures["movingMarchMs"]["median"], session_.frames().newest()->timings.marchMs);
  EXPECT_DOUBLE_EQ(figures["picturesPerSecond"][0], 0.5) << "one in two seconds, however many there were between two looks";
}

TEST_F(WindowReportTest, WhatAMovingCameraLeavesOutIsSaidAndComesBackAtRest) {
  open();
  LiveSettings knobs = session_.knobs();
  knobs.march = neededBy({}, knobs.march);  // neither panel draws more than samples
  knobs.march.render.step = 0.002f;  // more than a millisecond on any machine
  knobs.march.render.skipEmpty = knobs.march.render.terminateEarly = false;
  knobs.transport.server.movingMs = 1;
  session_.setKnobs(knobs);
  const auto updateUntil = [&](const auto& isSo, double turnDeg) {
    for (const auto limit = clock_.now() + std::chrono::seconds(60); clock_.now() < limit && !isSo(); std::this_thread::sleep_for(milliseconds(1))) {
      View view = session_.view();
      view.angleDeg += turnDeg;
      session_.setView(view);
      session_.update(clock_.now());
    }
    return isSo();
  };
  const Panel& panel = session_.panel(0);
  ASSERT_TRUE(updateUntil([&] { return !panel.leftOut.empty(); }, 0.5));
  EXPECT_THAT(panel.leftOut, testing::HasSubstr("instead of 0.002"));
  EXPECT_EQ(report(clock_.now())["panels"][0]["leftOut"], panel.leftOut);
  EXPECT_FALSE(panel.configuration) << "nobody chose that step: it gets no point in the plot";
  ASSERT_TRUE(updateUntil([&] { return panel.leftOut.empty() && panel.errorsAreCurrent && session_.ageMs(0, clock_.now()) == 0.0; }, 0.0));
  EXPECT_EQ(session_.frames().newest()->settings, knobs.march);
  ASSERT_TRUE(panel.configuration);
  EXPECT_EQ(panel.configuration->march, knobs.march);
  EXPECT_EQ(session_.groundTruth().image()->job().settings, knobs.march.render);
}

TEST_F(WindowReportTest, ErrorsAreThoseOfThePictureOnShow) {
  open();
  const Panel& panel = session_.panel(0);
  const json panels = report(clock_.now())["panels"];
  EXPECT_DOUBLE_EQ(panels[0]["flip"], panel.errors->flip);
  EXPECT_DOUBLE_EQ(panels[0]["psnrDb"], panel.errors->psnrDb);
  EXPECT_DOUBLE_EQ(panels[0]["holeFraction"], panel.errors->holeFraction);
  EXPECT_GT(panels[0]["flip"], 0.0);

  View view = session_.view();
  view.angleDeg += 20.0;
  session_.setView(view);
  session_.update(clock_.now());
  const json moving = report(clock_.now())["panels"][0];
  for (const char* key : {"flip", "psnrDb", "holeFraction"}) {
    ASSERT_TRUE(moving.contains(key)) << key;
    EXPECT_TRUE(moving[key].is_null()) << key << ": that of an earlier camera";
  }
}

TEST_F(WindowReportTest, WorkIsWhatPanelsDidSinceTheSceneWasOpened) {
  open();
  const auto count = [&](size_t panel, const char* key) {
    return report(clock_.now())["work"][panel][key].get<uint64_t>();
  };
  EXPECT_EQ(report(clock_.now())["panels"][0]["shortcut"], "");
  for (const size_t panel : {0, 1}) {
    EXPECT_EQ(count(panel, "made"), 1u);
    EXPECT_EQ(count(panel, "shortcutsTaken"), 0u);
    EXPECT_GE(count(panel, "draws"), 1u);
  }
  EXPECT_EQ(count(0, "builds"), 1u) << "of one frame";
  EXPECT_EQ(count(1, "builds"), 0u) << "the reference draws from none";

  const json stages = report(clock_.now())["work"][0]["stages"];
  ASSERT_EQ(stages.size(), kPictureStages.size());
  EXPECT_EQ(stages[0]["stage"], "own-picture");
  EXPECT_EQ(stages[0]["in"], false);
  EXPECT_EQ(stages[0]["reason"], "shortcuts are switched off: the technique is shown");

  const uint64_t draws = count(0, "draws");
  LiveSettings knobs = session_.knobs();
  knobs.takesShortcuts = true;
  session_.setKnobs(knobs);
  const auto limit = clock_.now() + std::chrono::seconds(60);
  for (; clock_.now() < limit && session_.panel(0).shortcut.empty(); std::this_thread::sleep_for(milliseconds(1)))
    session_.update(clock_.now());
  EXPECT_EQ(report(clock_.now())["panels"][0]["shortcut"], "the frame's picture, turned: no depth");
  EXPECT_EQ(count(0, "shortcutsTaken"), 1u);
  EXPECT_EQ(report(clock_.now())["work"][0]["stages"][1]["in"], true);
  EXPECT_EQ(count(0, "draws"), draws);
  EXPECT_EQ(count(1, "shortcutsTaken"), 0u);
}

TEST_F(WindowReportTest, StagesAreThoseOfPanelsThatDrawFrames) {
  open();
  const Clock::TimePoint now = clock_.now();
  const json figures = report(now);
  const json& stages = figures["panels"][0];
  const Panel& panel = session_.panel(0);
  const FrameLatency& latency = panel.latency;
  const std::vector<std::pair<const char*, double>> expected{
      {"waitMs", latency.waitMs}, {"wireMs", latency.wireMs},       {"queueMs", latency.queueMs},   {"marchMs", latency.marchMs},
      {"copyMs", latency.copyMs}, {"compactMs", latency.compactMs}, {"encodeMs", latency.encodeMs}, {"decodeMs", latency.decodeMs},
      {"buildMs", panel.buildMs}, {"drawMs", panel.drawMs},         {"displayMs", panel.displayMs}};
  EXPECT_EQ(stages.size(), expected.size() + 8);  // bytes, errors, what was left out, and a shortcut
  EXPECT_EQ(stages["leftOut"], "");
  for (const auto& [key, value] : expected) EXPECT_DOUBLE_EQ(stages[key], value) << key;
  EXPECT_EQ(stages["bytes"], panel.bytes.value());
  EXPECT_GT(panel.bytes, size_t{0});
  EXPECT_EQ(stages["proxyBytes"], panel.proxyBytes);
  EXPECT_TRUE(figures["panels"][1].is_null()) << "the reference is drawn from no frame";

  EXPECT_EQ(figures["framesReceived"], session_.frames().received());
  EXPECT_GE(session_.frames().received(), 1u);
  EXPECT_DOUBLE_EQ(figures["lastFrameAgeMs"], session_.frames().ageOfNewestMs(now).value());
  EXPECT_EQ(figures["server"]["isConnected"], true);
  EXPECT_EQ(figures["server"]["where"], session_.sourceStatus()->where);
  EXPECT_EQ(figures["server"]["sentence"], "");
}

}  // namespace
}  // namespace warpscope

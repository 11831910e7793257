// What the newest frame's march has to do, live: known for every frame, measured when somebody looks and all rests, never another frame's.
// Mirrors app/session/live_plan.h. Threads are real, volumes and images tiny.
#include "tests/session_fixture.h"

namespace warpscope {
namespace {

class SessionPlanTest : public SessionTest {
 protected:
  const LivePlan& plan() const { return session_.plan(); }
  bool isIn(PlanStage stage) const { return plan().plan() && plan().plan()->has(stage); }
  void setShading(float strength) {
    LiveSettings knobs = session_.knobs();
    knobs.march.render.effects.shading.strength = strength;
    session_.setKnobs(knobs);
  }
  bool openMeasured(const std::string& name) {
    session_.setShowsPlan(true);
    return open(name) && pumpUntil([&] { return plan().areCurrent(); });
  }
};

TEST_F(SessionPlanTest, IsThatOfTheMarcherForTheFramesSettings) {
  ASSERT_TRUE(open("shells"));
  ASSERT_TRUE(pumpUntil([&] { return plan().isKnown(); }));
  const MarchSettings& settings = session_.frames().newest()->settings;
  const auto expected = makeMarcher(Backend::cpu, session_.scene()->volume, session_.scene()->transferFunction)->plan(settings.render, settings.sample);
  for (const StageDescriptor& stage : kStages) {
    EXPECT_EQ(plan().plan()->has(stage.stage), expected->has(stage.stage)) << stage.name;
    EXPECT_EQ((*plan().plan())[stage.stage].reason, (*expected)[stage.stage].reason);
  }
  EXPECT_FALSE(isIn(PlanStage::gradient));
  setShading(1.0f);
  EXPECT_TRUE(pumpUntil([&] { return isIn(PlanStage::gradient); }));
}

TEST_F(SessionPlanTest, IsMeasuredAtRestIfSomebodyLooks) {
  ASSERT_TRUE(open("shells"));
  ASSERT_TRUE(pumpUntil([&] { return session_.liveFront().points().size() == 2u; }));  // all rests, and was timed
  const auto until = clock_.now() + milliseconds(900);
  pumpUntil([&] { return clock_.now() > until; });
  EXPECT_FALSE(plan().isMeasuring());
  EXPECT_FALSE(plan().costs());
  session_.setShowsPlan(true);
  ASSERT_TRUE(pumpUntil([&] { return plan().areCurrent(); }));
  EXPECT_GT(plan().costs()->march.medianMs, 0.0);
  for (const StageDescriptor& stage : kStages)
    EXPECT_EQ(plan().costs()->of(stage.stage) != nullptr, isIn(stage.stage) && without(stage.stage, session_.frames().newest()->settings)) << stage.name;
  EXPECT_FALSE(plan().isMeasuring());
}

TEST_F(SessionPlanTest, FiguresOfAnEarlierCameraSayThatTheyAre) {
  ASSERT_TRUE(openMeasured("shells"));
  turn(session_, 10.0);
  ASSERT_TRUE(pumpUntil([&] { return !plan().areCurrent(); }));
  EXPECT_TRUE(plan().costs());
  EXPECT_TRUE(pumpUntil([&] { return plan().areCurrent(); }));
}

TEST_F(SessionPlanTest, FiguresOfOtherSettingsGo) {
  ASSERT_TRUE(openMeasured("shells"));
  ASSERT_FALSE(plan().costs()->of(PlanStage::gradient));
  setShading(1.0f);
  ASSERT_TRUE(pumpUntil([&] { return isIn(PlanStage::gradient); }));
  EXPECT_FALSE(plan().areCurrent());
  ASSERT_TRUE(pumpUntil([&] { return plan().areCurrent(); }));
  EXPECT_TRUE(plan().costs()->of(PlanStage::gradient));
}

TEST_F(SessionPlanTest, AnotherScenesFiguresGo) {
  ASSERT_TRUE(openMeasured("shells"));
  session_.load(builtin("block"));
  ASSERT_TRUE(pumpUntil([&] { return session_.scene()->name == "block"; }));
  EXPECT_FALSE(plan().costs());
  EXPECT_TRUE(pumpUntil([&] { return plan().areCurrent(); }));
}

TEST_F(SessionPlanTest, IsUnknownWhereTheServerPlans) {
  faults_->plansElsewhere = true;
  session_.setShowsPlan(true);
  ASSERT_TRUE(open("shells"));
  ASSERT_TRUE(pumpUntil([&] { return plan().isKnown(); }));
  EXPECT_FALSE(plan().plan());
  const auto until = clock_.now() + milliseconds(900);
  pumpUntil([&] { return clock_.now() > until; });
  EXPECT_FALSE(plan().isMeasuring());
}

TEST_F(SessionPlanTest, SaysWhyItCouldNotBeMeasured) {
  ASSERT_TRUE(open("shells"));
  faults_->march = true;
  session_.setShowsPlan(true);
  ASSERT_TRUE(pumpUntil([&] { return !plan().error().empty(); }));
  EXPECT_EQ(plan().error(), "the server is on fire");
  EXPECT_TRUE(plan().plan());
  faults_->march = false;
  setShading(0.5f);
  EXPECT_TRUE(pumpUntil([&] { return plan().areCurrent() && plan().error().empty(); }));
}

}  // namespace
}  // namespace warpscope

// Panels that choose their technique by themselves: what was measured to be best at this angle and within the budget, and why.
// Mirrors app/session/technique_choice.h.
#include <gtest/gtest.h>

#include "render/warp/fill.h"
#include "tests/session_fixture.h"
#include "tests/sweep_rows.h"

namespace warpscope {
namespace {

class SessionChoiceTest : public SessionTest {
 protected:
  /// Of a sweep of larger pictures.
  SweepRow rowOf(std::string_view technique, double angleDeg, double flip, double drawMs) const {
    return sweepRow(technique, angleDeg, flip, drawMs, session_.knobs().march, 999);
  }
  std::shared_ptr<const AutoChoice> someFront() const {
    std::vector<SweepRow> rows{rowOf("hold", 0, 0.0, 1),    rowOf("hold", 20, 0.5, 1),    rowOf("spheres", 0, 0.1, 20),
                               rowOf("spheres", 20, 0.2, 20), rowOf("splats", 0, 0.15, 5), rowOf("splats", 20, 0.3, 5)};
    return std::make_shared<const AutoChoice>(rows);
  }
  void freeze() {
    LiveSettings knobs = session_.knobs();
    knobs.isFrozen = true;
    session_.setKnobs(knobs);
  }
};

TEST_F(SessionChoiceTest, TakesWhatIsBestAtThisAngleWithinTheBudget) {
  ASSERT_TRUE(open("block"));
  session_.setFront(someFront());
  session_.setAutomatic(0);
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.panel(0).technique->name, "hold");
  EXPECT_EQ(session_.panel(0).drawn->name, "hold");
  EXPECT_THAT(session_.panel(0).choiceText, testing::StartsWith("hold: least error (FLIP 0.0000) at 0.0 degrees"));
  EXPECT_EQ(session_.panel(1).technique->name, "spheres");  // as it was chosen
  EXPECT_FALSE(session_.panel(1).isAutomatic);

  EXPECT_NEAR(session_.angleDeg(0).value_or(-1.0), 0.0, 1e-3);
  freeze();  // so that the frame stays behind
  turn(session_, 20.0);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(0).drawn->name == "spheres"; }));
  EXPECT_NEAR(session_.angleDeg(1).value_or(-1.0), 20.0, 3.0) << "about an axis that is not across what it looks along";
  EXPECT_THAT(session_.panel(0).choiceText, testing::HasSubstr("within 33 ms"));

  LiveSettings knobs = session_.knobs();
  knobs.budgetMs = 10.0;
  session_.setKnobs(knobs);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(0).drawn->name == "splats"; }));
  knobs.budgetMs = 0.5;
  session_.setKnobs(knobs);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(0).drawn->name == "hold"; }));
  EXPECT_THAT(session_.panel(0).choiceText, testing::HasSubstr("none of which keeps to 0.5 ms"));
}

TEST_F(SessionChoiceTest, WithoutASweepItIsWhatWasOnShow) {
  ASSERT_TRUE(open("block"));
  ASSERT_TRUE(pumpUntil([&] { return session_.liveFront().points().size() == 2u; }));
  session_.setAutomatic(0);
  ASSERT_TRUE(settle());
  // hold and spheres were on show at this angle.
  const auto flipOf = [&](std::string_view technique) {
    for (const LiveFront::Point& point : session_.liveFront().points())
      if (point.configuration.technique->name == technique) return point.flip;
    return 1.0;
  };
  LiveSettings knobs = session_.knobs();
  knobs.budgetMs = 10000.0;
  session_.setKnobs(knobs);
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.panel(0).technique->name, flipOf("hold") <= flipOf("spheres") ? "hold" : "spheres");
  ASSERT_TRUE(session_.panel(0).choice);
}

TEST_F(SessionChoiceTest, WhatWasNotMeasuredIsSaid) {
  ASSERT_TRUE(open("block"));
  LiveSettings knobs = session_.knobs();
  knobs.march.sample.heuristic = Heuristic::exit;
  session_.setKnobs(knobs);
  session_.setTechnique(0, findWarp("points"));
  std::vector<SweepRow> rows{rowOf("spheres", 0, 0.1, 1)};
  rows[0].configuration.march.sample.heuristic = Heuristic::entrance;
  session_.setFront(std::make_shared<const AutoChoice>(rows));
  session_.setAutomatic(0);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(0).drawn != nullptr && session_.panel(0).drawn->name == "splats"; }));
  EXPECT_FALSE(session_.panel(0).choice);
  EXPECT_THAT(session_.panel(0).choiceText, testing::HasSubstr("nothing was measured yet"));
}

TEST_F(SessionChoiceTest, WhatTheFrameDoesNotHaveYetIsAskedForAndChosen) {
  ASSERT_TRUE(open("block"));
  session_.setTechnique(0, findWarp("spheres"));
  ASSERT_TRUE(settle());
  ASSERT_EQ(session_.frames().newest()->settings.sample.segments, 0) << "nothing on show draws them";
  const std::vector<SweepRow> rows{rowOf("spheres", 0, 0.2, 5), rowOf("spheres", 20, 0.3, 5), rowOf("segments", 0, 0.05, 20), rowOf("segments", 20, 0.1, 20)};
  session_.setFront(std::make_shared<const AutoChoice>(rows));
  session_.setAutomatic(0);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(0).drawn->name == "segments"; }));
  EXPECT_GT(session_.frames().newest()->settings.sample.segments, 0);
  EXPECT_EQ(session_.panel(0).lack, "");
  // Too slow for this budget: the frames have none again.
  LiveSettings knobs = session_.knobs();
  knobs.budgetMs = 10.0;
  session_.setKnobs(knobs);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(0).drawn->name == "spheres" && session_.frames().newest()->settings.sample.segments == 0; }));
  // A frozen frame has what it has.
  freeze();
  turn(session_, 20.0);
  knobs = session_.knobs();
  knobs.budgetMs = 100.0;
  session_.setKnobs(knobs);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(0).choiceText.find("within 100 ms") != std::string::npos; }));
  EXPECT_EQ(session_.panel(0).technique->name, "spheres");
  EXPECT_EQ(session_.panel(0).choice->technique->name, "spheres");
}

TEST_F(SessionChoiceTest, PanelsKnobsGoWithWhatIsChosen) {
  ASSERT_TRUE(open("block"));
  SweepRow row = rowOf("spheres", 0, 0.1, 5);
  row.configuration.knobs.set(kFillKnob, Fill::pullPush);
  session_.setFront(std::make_shared<const AutoChoice>(std::vector{row, rowOf("spheres", 0, 0.2, 5)}));
  session_.setAutomatic(0);
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.panel(0).knobs.choice<Fill>(kFillKnob), Fill::pullPush);
  ASSERT_TRUE(session_.panel(0).configuration);
  EXPECT_EQ(session_.panel(0).configuration->knobs.choice<Fill>(kFillKnob), Fill::pullPush) << "which is what was measured";
}

TEST_F(SessionChoiceTest, WhatIsHardlyBetterDoesNotTakeOver) {
  ASSERT_TRUE(open("block"));
  freeze();
  const auto frontWhere = [&](double splatsFlip) {
    return std::make_shared<const AutoChoice>(std::vector<SweepRow>{rowOf("spheres", 0, 0.2, 5), rowOf("splats", 0, splatsFlip, 5)});
  };
  session_.setFront(frontWhere(0.3));
  session_.setAutomatic(0);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(0).drawn != nullptr && session_.panel(0).drawn->name == "spheres"; }));
  session_.setFront(frontWhere(0.19));
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.panel(0).technique->name, "spheres");
  EXPECT_THAT(session_.panel(0).choiceText, testing::HasSubstr("FLIP 0.2000"));
  session_.setFront(frontWhere(0.1));
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(0).drawn->name == "splats"; }));
}

TEST_F(SessionChoiceTest, ATechniqueThatIsChosenByHandStays) {
  ASSERT_TRUE(open("block"));
  session_.setFront(someFront());
  session_.setAutomatic(0);
  ASSERT_TRUE(settle());
  session_.setTechnique(0, findWarp("multihit"));
  ASSERT_TRUE(settle());
  EXPECT_FALSE(session_.panel(0).isAutomatic);
  EXPECT_EQ(session_.panel(0).drawn->name, "multihit");
  EXPECT_EQ(session_.panel(0).choiceText, "");
}

}  // namespace
}  // namespace warpscope

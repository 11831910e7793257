// Demonstrations: each sets up what it says, and shows it; outages hold frames up and end.
// Mirrors app/session/demos.h and what of app/session/session.h is about motions and outages.
#include "app/session/demos.h"

#include "net/link_settings.h"
#include "tests/session_fixture.h"

namespace warpscope {
namespace {

class SessionDemoTest : public SessionTest {
 protected:
  /// Until its camera moves.
  testing::AssertionResult show(const Demo& demo) {
    demo_.start(demo, session_, history_);
    const bool isGoing = pumpUntil([&] {
      demo_.follow(session_, history_, false, clock_.now());
      return session_.motion().motion() == demo.motion;
    });
    return isGoing ? testing::AssertionSuccess() : testing::AssertionFailure() << demo.name << " does not begin";
  }

  EditHistory history_;
  RunningDemo demo_;
};

TEST_F(SessionDemoTest, EachShowsItsTechniquesBehindItsLink) {
  ASSERT_TRUE(open("block"));
  EXPECT_EQ(demos().size(), 5u);
  EXPECT_EQ(demos().front().link, "satellite");
  for (const Demo& demo : demos()) {
    SCOPED_TRACE(demo.name);
    ASSERT_TRUE(show(demo));
    ASSERT_EQ(session_.panelCount(), demo.techniques.size());
    for (size_t i = 0; i < demo.techniques.size(); ++i) EXPECT_EQ(session_.panel(i).technique->name, demo.techniques[i]);
    EXPECT_EQ(session_.motion().motion(), demo.motion);
    EXPECT_FALSE(session_.knobs().transport.link.down.isTransparent());
    EXPECT_EQ(session_.knobs().transport.frameKib, demo.frameKib);
    const View home = session_.view();
    ASSERT_TRUE(pumpUntil([&] {
      for (size_t i = 0; i < session_.panelCount(); ++i)
        if (session_.panel(i).drawn != session_.panel(i).technique) return false;
      return session_.view() != home;
    }));
  }
}

TEST_F(SessionDemoTest, AfterOneAllIsAsItWas) {
  ASSERT_TRUE(open("block"));
  session_.addPanel({.technique = &findWarp("mesh"), .content = PictureContent::depth});
  session_.setOwnCamera(1, true);
  View own = session_.view(1);
  own.angleDeg += 30.0;
  session_.setView(1, own);
  turn(session_, 10.0);
  LiveSettings knobs = session_.knobs();
  knobs.transport.link = net::parseLinkSettings("delay=20");
  knobs.transport.frameKib = 77;
  knobs.isFrozen = true;
  session_.setKnobs(knobs);
  const View view = session_.view();
  std::vector<const WarpDescriptor*> techniques;
  for (size_t i = 0; i < session_.panelCount(); ++i) techniques.push_back(session_.panel(i).technique);
  for (const Demo& demo : demos()) ASSERT_TRUE(show(demo));
  demo_.end(session_, history_);
  ASSERT_EQ(session_.panelCount(), techniques.size());
  for (size_t i = 0; i < techniques.size(); ++i) EXPECT_EQ(session_.panel(i).technique, techniques[i]);
  EXPECT_EQ(session_.panel(techniques.size() - 1).content, PictureContent::depth);
  EXPECT_EQ(session_.view(), view);
  ASSERT_TRUE(session_.hasOwnCamera(1));
  EXPECT_EQ(session_.view(1), own);
  EXPECT_EQ(session_.knobs().transport.link, knobs.transport.link);
  EXPECT_EQ(session_.knobs().transport.frameKib, 77);
  EXPECT_TRUE(session_.knobs().isFrozen);
  EXPECT_EQ(session_.motion().motion(), CameraMotion::none);
  // In another scene its first view is as good as any.
  ASSERT_TRUE(show(demos().front()));
  session_.setMotion(CameraMotion::none);
  ASSERT_TRUE(open("shells"));
  const View first = session_.view();
  turn(session_, 20.0);
  demo_.end(session_, history_);
  EXPECT_EQ(session_.view(), first);
}

TEST_F(SessionDemoTest, TheUsersHandEndsAMotion) {
  ASSERT_TRUE(open("block"));
  session_.setMotion(CameraMotion::orbit);
  const View home = session_.view();
  ASSERT_TRUE(pumpUntil([&] { return session_.view() != home; }));
  turn(session_, 10.0);
  ASSERT_TRUE(pumpUntil([&] { return session_.motion().motion() == CameraMotion::none; }));
  EXPECT_TRUE(settle());
}

TEST_F(SessionDemoTest, AnOutageHoldsFramesUpAndEnds) {
  ASSERT_TRUE(open("block"));
  session_.update(clock_.now());
  session_.beginOutage(milliseconds(1500), clock_.now());
  session_.update(clock_.now());
  std::this_thread::sleep_for(milliseconds(30));  // the link takes effect for what is sent from now on
  const size_t received = session_.frames().received();
  const auto began = clock_.now();
  turn(session_, 10.0);
  ASSERT_TRUE(pumpUntil([&] { return session_.frames().received() > received; }));
  EXPECT_GT(clock_.now() - began, milliseconds(1000));
  EXPECT_LT(clock_.now() - began, seconds(10));
  EXPECT_TRUE(settle());
  EXPECT_FALSE(session_.hasOutage(clock_.now()));
  EXPECT_TRUE(session_.knobs().transport.link.up.isTransparent()) << "no knob was turned";
}

}  // namespace
}  // namespace warpscope

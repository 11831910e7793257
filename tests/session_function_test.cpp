// Another transfer function while the scene is open: the ground truth and the copy of the volume follow at once, frames as they come, and nothing stands still.
// Mirrors the part of app/session/session.h that is about it, and app/frames/frame_server.h's.
#include "app/scene/transfer_presets.h"
#include "app/session/panel.h"
#include "tests/session_fixture.h"

namespace warpscope {
namespace {

class SessionFunctionTest : public SessionTest {
 protected:
  /// The scene's with half the opacity.
  TransferFunction thinned() const {
    TransferFunction function = session_.scene()->transferFunction;
    for (TransferPoint& point : function.points) point.alpha *= 0.5f;
    return function;
  }
  bool hasFrameOfNow() { return session_.frames().newest()->functionVersion > 0 && !session_.frames().isUnderWay() && session_.frames().isWhatIsWanted(); }
};

TEST_F(SessionFunctionTest, FramesGroundTruthAndErrorsAreOfTheNewOne) {
  ASSERT_TRUE(open("shells"));
  const SampleFramePtr before = session_.frames().newest();
  const Image<glm::vec4> truth = session_.groundTruth().image()->color();
  const uint64_t made = session_.panel(1).counts.made;
  session_.setTransferFunction(thinned());
  ASSERT_TRUE(pumpUntil([&] { return hasFrameOfNow(); }));
  ASSERT_TRUE(settle());
  EXPECT_NE(session_.groundTruth().image()->color(), truth);
  EXPECT_NE(session_.frames().newest()->colors, before->colors);
  EXPECT_LT(session_.panel(1).errors->flip, 0.2) << "the picture and the truth are of one function";
  EXPECT_EQ(session_.panel(1).counts.made, made) << "what draws frames needs not be made anew";
  // As a marcher of that function makes them.
  const MarcherPtr marcher = makeMarcher(Backend::cpu, session_.scene()->volume, session_.scene()->transferFunction);
  const SampleFramePtr& frame = session_.frames().newest();
  EXPECT_EQ(marcher->march(frame->camera, frame->settings).samples, frame->samples);
}

/// What an old frame shows beside a new ground truth says nothing about techniques.
TEST_F(SessionFunctionTest, FramesFromBeforeAreNoPointsOfThePlot) {
  ASSERT_TRUE(open("shells"));
  const LiveFront& front = session_.liveFront();
  ASSERT_TRUE(pumpUntil([&] { return front.points().size() == 2u; }));
  LiveSettings knobs = session_.knobs();
  knobs.isFrozen = true;  // the old frame stays
  session_.setKnobs(knobs);
  const double before = session_.panel(1).errors->flip;
  session_.setTransferFunction(thinned());
  EXPECT_TRUE(front.points().empty());
  // What is on show is judged all the same.
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(0).errorsAreCurrent && session_.panel(1).errorsAreCurrent && session_.panel(1).errors->flip > before; }));
  EXPECT_TRUE(front.points().empty());
  EXPECT_EQ(front.remembered(), 0u);
  session_.measureNow();
  EXPECT_FALSE(session_.fair().isMeasuring());
  EXPECT_THAT(session_.fair().error(), testing::HasSubstr("transfer function"));
  knobs.isFrozen = false;
  session_.setKnobs(knobs);
  ASSERT_TRUE(pumpUntil([&] { return front.points().size() == 2u; }));
  EXPECT_DOUBLE_EQ(front.points().back().flip, session_.panel(front.points().back().configuration.technique == session_.panel(0).technique ? 0 : 1).errors->flip);
}

TEST_F(SessionFunctionTest, TheCopyOfTheVolumeFollowsAtOnce) {
  session_.setTechnique(1, findWarp("proxy"));
  ASSERT_TRUE(open("shells"));
  ASSERT_TRUE(session_.frames().newest()->proxy);
  LiveSettings knobs = session_.knobs();
  knobs.isFrozen = true;  // no other frame comes
  session_.setKnobs(knobs);
  const ShownPicture before = session_.panel(1).picture;
  session_.setTransferFunction(thinned());
  EXPECT_EQ(session_.frames().newest()->proxy->function, session_.scene()->transferFunction);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(1).picture != before; }));
  knobs.isFrozen = false;
  session_.setKnobs(knobs);
  ASSERT_TRUE(pumpUntil([&] { return hasFrameOfNow(); }));
  EXPECT_EQ(session_.frames().newest()->proxy->function, session_.scene()->transferFunction) << "also with frames that come afterwards";
}

TEST_F(SessionFunctionTest, WhileItIsDraggedPicturesGoOn) {
  ASSERT_TRUE(open("shells"));
  int pictures = 0;
  ShownPicture last = session_.panel(1).picture;
  TransferFunction function = session_.scene()->transferFunction;
  const auto end = clock_.now() + seconds(2);
  while (clock_.now() < end) {
    for (TransferPoint& point : function.points) point.alpha *= 0.999f;
    session_.setTransferFunction(function);
    session_.update(clock_.now());
    if (session_.panel(1).picture != last) ++pictures;
    last = session_.panel(1).picture;
    std::this_thread::sleep_for(milliseconds(4));
  }
  EXPECT_GE(pictures, 5);
  ASSERT_TRUE(pumpUntil([&] { return hasFrameOfNow(); }));
  EXPECT_TRUE(settle());
}

TEST_F(SessionFunctionTest, AnotherSceneHasItsOwnAndPointsInThePlotAreForgotten) {
  ASSERT_TRUE(open("block"));
  ASSERT_TRUE(pumpUntil([&] { return session_.liveFront().points().size() == 2u; }));
  session_.setTransferFunction(thinned());
  EXPECT_EQ(session_.liveFront().points().size(), 0u);
  const TransferFunction changed = session_.scene()->transferFunction;
  ASSERT_TRUE(open("shells"));
  EXPECT_NE(session_.scene()->transferFunction, changed);
  ASSERT_TRUE(session_.frames().newest());
  const MarcherPtr marcher = makeMarcher(Backend::cpu, session_.scene()->volume, session_.scene()->transferFunction);
  EXPECT_EQ(marcher->march(session_.frames().newest()->camera, session_.frames().newest()->settings).samples, session_.frames().newest()->samples);
}

TEST_F(SessionFunctionTest, WhatCannotBeIsRefusedAndChangesNothing) {
  EXPECT_THROW(session_.setTransferFunction(TransferFunction{}), UsageError) << "without a scene";
  ASSERT_TRUE(open("block"));
  const TransferFunction before = session_.scene()->transferFunction;
  EXPECT_THROW(session_.setTransferFunction(TransferFunction{}), UsageError);
  EXPECT_THROW(session_.setTransferFunction({{{0.0, glm::vec3(1.0f), 2.0f}}}), UsageError);
  EXPECT_EQ(session_.scene()->transferFunction, before);
  EXPECT_EQ(session_.whyFunctionIsFixed(), "");
}

}  // namespace
}  // namespace warpscope

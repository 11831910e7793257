// "Measure now": every technique on show at the same angles, with the errors that the judge has for the same pictures.
// Mirrors app/session/fair_measuring.h.
#include "app/session/fair_measuring.h"

#include "render/metrics/picture_errors.h"
#include "tests/session_fixture.h"

namespace warpscope {
namespace {

class SessionFairTest : public SessionTest {
 protected:
  bool measure() {
    session_.measureNow();
    EXPECT_TRUE(session_.fair().isMeasuring());
    return pumpUntil([&] { return !session_.fair().isMeasuring(); });
  }
};

TEST_F(SessionFairTest, AllTechniquesOnShowAtTheSameAngles) {
  ASSERT_TRUE(open("shells"));
  session_.addPanel({.technique = &findWarp("reference")});  // draws no frame: is not measured
  session_.addPanel({.technique = &findWarp("points")});     // by OpenGL
  session_.addPanel({.technique = &findWarp("spheres")});    // the same again
  ASSERT_TRUE(settle());
  const SampleFramePtr frame = session_.frames().newest();
  LiveSettings knobs = session_.knobs();
  knobs.isFrozen = true;
  session_.setKnobs(knobs);
  turn(session_, 25.0);
  ASSERT_TRUE(measure());
  EXPECT_EQ(session_.fair().error(), "");
  EXPECT_EQ(session_.fair().done(), kFairAnglesDeg.size() * 4);
  const auto& points = session_.fair().points();
  ASSERT_EQ(points.size(), 3u);
  EXPECT_EQ(points[2].configuration.technique->name, "points");
  EXPECT_EQ(points[0].configuration.technique->name, "hold");
  EXPECT_EQ(points[1].configuration.technique->name, "spheres");
  EXPECT_FALSE(session_.fair().front().empty());
  const MarcherPtr marcher = makeMarcher(Backend::cpu, session_.scene()->volume, session_.scene()->transferFunction);
  for (const FairPoint& point : points) {
    ASSERT_EQ(point.angles.size(), kFairAnglesDeg.size());
    double sum = 0.0;
    for (const FairPoint::Angle& angle : point.angles) {
      EXPECT_GT(angle.frameMs, 0.0);
      EXPECT_LE(angle.frameMs, point.frameMs);
      sum += angle.flip;
    }
    EXPECT_NEAR(point.flip, sum / static_cast<double>(kFairAnglesDeg.size()), 1e-9);
    // By hand, from the frame's own view and 30 degrees beside it.
    for (const size_t i : {size_t{0}, size_t{4}}) {
      View view = session_.scene()->views.front();
      view.angleDeg += kFairAnglesDeg[i];
      const Camera camera = makeCamera(*session_.scene(), view, kPanelPx.x, kPanelPx.y);
      Image<glm::vec4> truth;
      marcher->render(camera, session_.knobs().march.render, truth, {});
      if (point.configuration.technique->usesOpenGl) continue;
      WarpResources resources;
      const std::unique_ptr<Warp> warp = makeWarp(*point.configuration.technique, resources);
      WarpedImage image;
      warp->setFrame(frame, point.configuration.warp({}));
      warp->draw(camera, point.configuration.warp({}), image);
      EXPECT_NEAR(PictureJudge(truth, session_.scene()->background).errorsOf(image).flip, point.angles[i].flip, 1e-6);
    }
  }
}

TEST_F(SessionFairTest, CanBeCancelledAndIsForgottenWithWhatItWasOf) {
  session_.measureNow();
  EXPECT_FALSE(session_.fair().isMeasuring()) << "there is no frame";
  ASSERT_TRUE(open("shells"));
  session_.measureNow();
  session_.cancelMeasuring();
  EXPECT_FALSE(session_.fair().isMeasuring());
  EXPECT_TRUE(session_.fair().points().empty());
  ASSERT_TRUE(measure());
  EXPECT_EQ(session_.fair().points().size(), 2u);
  session_.setPanelSize({57, 33});
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.fair().points().size(), 2u) << "a change of layout forgets nothing";
  TransferFunction function = session_.scene()->transferFunction;
  function.points.back().alpha *= 0.5f;
  session_.setTransferFunction(function);
  EXPECT_TRUE(session_.fair().points().empty());
}

TEST_F(SessionFairTest, WithoutAGroundTruthThereIsASentence) {
  ASSERT_TRUE(open("block"));
  faults_->render = true;
  ASSERT_TRUE(measure());
  EXPECT_EQ(session_.fair().error(), "no ground truth today");
  faults_->render = false;
  ASSERT_TRUE(measure());
  EXPECT_EQ(session_.fair().error(), "");
}

}  // namespace
}  // namespace warpscope

// Sessions whose server marches and codes on a GPU, whose frames stay there, and whose panels draw there: what they show is what a CPU shows.
// With a device that is none: tests/session_away_test.cpp.
#include "render/cuda/devices.h"
#include "tests/gpu/agreement.h"
#include "tests/session_fixture.h"

namespace warpscope {
namespace {

class SessionOnDevice : public SessionTest {
 protected:
  SessionSettings on(Backend backend) const {
    SessionSettings own = settings();
    own.panels = {{.technique = &findWarp("hold")}, {.technique = &findWarp("spheres")}, {.technique = &findWarp("segments")}, {.technique = &findWarp("multihit")}};
    own.knobs.march.sample.segments = 3;
    own.knobs.transport.codec.format = PayloadFormat::tiled;
    own.resources.backend = backend;
    return own;
  }
  LoadJob shells(Backend backend) {
    return {"shells", [io = io_, backend, transport = on(backend).knobs.transport](const std::function<void()>& onNews, const std::stop_token& stop) {
              SceneOverrides overrides;
              overrides.proceduralDims = {16, 16, 16};
              Scene scene = openScene("shells", overrides, stop);
              const MarcherPtr marcher = makeMarcher(backend, scene.volume, scene.transferFunction);
              return hostScene(io, std::move(scene), marcher, transport, onNews, stop, DecodedPlace::device);
            }};
  }
  /// A device judges with sums of another order.
  static void expectSameErrors(const Session& expected, const Session& actual) {
    ASSERT_EQ(actual.panelCount(), expected.panelCount());
    for (size_t i = 0; i < expected.panelCount(); ++i) {
      EXPECT_EQ(actual.panel(i).error, "") << i;
      ASSERT_TRUE(actual.panel(i).errors && expected.panel(i).errors) << i;
      EXPECT_NEAR(actual.panel(i).errors->flip, expected.panel(i).errors->flip, 1e-4) << i;
      EXPECT_EQ(actual.panel(i).errors->holeFraction, expected.panel(i).errors->holeFraction) << i;
    }
  }
};

TEST_F(SessionOnDevice, ShowsWhatACpuShows) {
  WARPSCOPE_NEEDS_GPU();
  Session onCpu(on(Backend::cpu), [] {}), onDevice(on(Backend::cuda), [] {});
  ASSERT_TRUE(load(onCpu, shells(Backend::cpu)));
  ASSERT_TRUE(load(onDevice, shells(Backend::cuda)));
  EXPECT_TRUE(onDevice.groundTruth().followsCamera());
  expectSameErrors(onCpu, onDevice);
  for (Session* const session : {&onCpu, &onDevice}) {
    turn(*session, 25.0);
    ASSERT_TRUE(settle(*session));
  }
  const SampleFramePtr here = onCpu.frames().newest(), there = onDevice.frames().newest();
  EXPECT_FALSE(here->isAway);
  EXPECT_TRUE(there->isAway);
  EXPECT_EQ(there->camera, here->camera);
  expectSameFrames(*here, *onHost(there));
  expectSameErrors(onCpu, onDevice);

  // The same frames from beside.
  for (Session* const session : {&onCpu, &onDevice}) {
    LiveSettings knobs = session->knobs();
    knobs.isFrozen = true;
    session->setKnobs(knobs);
    turn(*session, -20.0);
    ASSERT_TRUE(pumpUntil(*session, [&] { return isJudged(*session); }));
  }
  EXPECT_EQ(onDevice.frames().newest(), there);
  EXPECT_EQ(onCpu.frames().newest(), here);
  EXPECT_GT(onCpu.panel(1).errors->flip, 0.0);
  expectSameErrors(onCpu, onDevice);
}

TEST_F(SessionOnDevice, ShowsDepthsSegmentsAndRaysOfAFrameThatIsThere) {
  WARPSCOPE_NEEDS_GPU();
  Session onCpu(on(Backend::cpu), [] {}), onDevice(on(Backend::cuda), [] {});
  ASSERT_TRUE(load(onCpu, shells(Backend::cpu)));
  ASSERT_TRUE(load(onDevice, shells(Backend::cuda)));
  for (Session* const session : {&onCpu, &onDevice}) {
    session->lookAt(LookedAt{session->panel(1).id, {0.5, 0.5}});
    ASSERT_TRUE(pumpUntil(*session, [&] { return session->ray().isCurrent(); }));
    EXPECT_EQ(session->ray().error(), "");
  }
  const RayResult &expectedRay = *onCpu.ray().result(), &ray = *onDevice.ray().result();
  EXPECT_FALSE(expectedRay.trace.samples.empty());
  EXPECT_EQ(ray.trace.color, expectedRay.trace.color);
  EXPECT_TRUE(expectedRay.job.ray.sample);
  EXPECT_EQ(ray.job.ray.sample, expectedRay.job.ray.sample);
  EXPECT_EQ(ray.job.ray.pixel, expectedRay.job.ray.pixel);
  EXPECT_EQ(ray.missed.has_value(), expectedRay.missed.has_value());  // looked for in the frame
  int pictures = 0;
  for (const PictureContent content : {PictureContent::depth, PictureContent::segments}) {
    for (Session* const session : {&onCpu, &onDevice}) {
      for (size_t i = 1; i < 3; ++i) session->setContent(i, content);
      ASSERT_TRUE(settle(*session));
    }
    for (size_t i = 1; i < 3; ++i) {
      const PanelContent &expected = onCpu.panel(i).shownContent, &shown = onDevice.panel(i).shownContent;
      EXPECT_EQ(shown.refusal, expected.refusal);
      ASSERT_EQ(shown.picture.host == nullptr, expected.picture.host == nullptr);
      if (expected.picture.host) {
        ++pictures;
        EXPECT_TRUE(*shown.picture.host == *expected.picture.host) << i << ", " << describe(content).name;
      }
    }
  }
  EXPECT_GE(pictures, 3);  // depths of both, segments of one
}

}  // namespace
}  // namespace warpscope

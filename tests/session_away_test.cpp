// A session whose frames are on a device alone (SampleFrame::isAway): everything that looks at them sees what it sees of frames that are here.
// The device is none: tests/held_frame.h.
#include "app/frames/recorded_frames.h"
#include "app/picture/content.h"
#include "tests/held_frame.h"
#include "tests/session_fixture.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

/// Leaves what comes on a device that has lost it while `isLost`.
class StayingSource final : public FrameSource {
 public:
  StayingSource(FrameSourcePtr source, const std::atomic<bool>& isLost) : source_(std::move(source)), isLost_(isLost) {}

  void post(const FrameRequest& request, Clock::TimePoint now) override { source_->post(request, now); }
  std::optional<ServedFrame> tryTake() override {
    std::optional<ServedFrame> served = source_->tryTake();
    if (served && served->frame) served->frame = std::make_shared<const SampleFrame>(leftOnDevice(*onHost(served->frame), isLost_));
    return served;
  }
  void setTransport(const TransportSettings& transport) override { source_->setTransport(transport); }
  bool setTransferFunction(const TransferFunction& function, uint64_t version) override { return source_->setTransferFunction(function, version); }
  SourceStatus status() const override { return source_->status(); }
  void requestStop() override { source_->requestStop(); }

 private:
  const FrameSourcePtr source_;
  const std::atomic<bool>& isLost_;
};

class SessionAway : public SessionTest {
 protected:
  SessionSettings ownSettings() const {
    SessionSettings own = settings();
    own.panels = {{.technique = &findWarp("hold")}, {.technique = &findWarp("spheres")}, {.technique = &findWarp("segments")}};
    own.knobs.march.sample.segments = 3;
    return own;
  }
  LoadJob staying(const std::string& name) {
    LoadJob job = builtin(name);
    job.open = [this, inner = job.open](const std::function<void()>& onNews, const std::stop_token& stop) {
      ConnectedScene opened = inner(onNews, stop);
      opened.source = std::make_shared<StayingSource>(std::move(opened.source), isLost_);
      return opened;
    };
    return job;
  }

  std::atomic<bool> isLost_ = false;
};

TEST_F(SessionAway, ShowsWhatItShowsOfFramesThatAreHere) {
  Session here(ownSettings(), [] {}), there(ownSettings(), [] {});
  ASSERT_TRUE(load(here, builtin("shells")));
  ASSERT_TRUE(load(there, staying("shells")));
  for (const PictureContent content : {PictureContent::picture, PictureContent::depth, PictureContent::radius, PictureContent::segments}) {
    for (size_t i = 0; i < 3; ++i) {
      for (Session* const session : {&here, &there}) session->setContent(i, content);
      ASSERT_TRUE(settle(here) && settle(there));
      const Panel &expected = here.panel(i), &shown = there.panel(i);
      EXPECT_EQ(shown.error, "");
      EXPECT_EQ(shown.errors->flip, expected.errors->flip);
      EXPECT_EQ(shown.shownContent.refusal, expected.shownContent.refusal);
      if (content == PictureContent::picture) continue;
      ASSERT_EQ(shown.shownContent.picture.host == nullptr, expected.shownContent.picture.host == nullptr);
      if (expected.shownContent.picture.host) EXPECT_TRUE(*shown.shownContent.picture.host == *expected.shownContent.picture.host) << i << ", " << describe(content).name;
    }
  }
  for (Session* const session : {&here, &there}) {
    turn(*session, 25.0);
    ASSERT_TRUE(settle(*session));
  }
  ASSERT_TRUE(there.frames().newest()->isAway);
  EXPECT_EQ(onHost(there.frames().newest())->samples, here.frames().newest()->samples);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(there.panel(i).errors->flip, here.panel(i).errors->flip) << i;
    EXPECT_EQ(there.panel(i).errors->holeFraction, here.panel(i).errors->holeFraction) << i;
  }
}

TEST_F(SessionAway, ShortcutsRaysAndMeasuredPicturesWork) {
  SessionSettings own = ownSettings();
  own.knobs.takesShortcuts = true;
  own.knobs.transport.codec.color = ColorCoding::lossless;
  own.knobs.serverSidePx = kPanelPx.y;
  Session session(own, [] {});
  ASSERT_TRUE(load(session, staying("shells")));
  EXPECT_GT(session.panel(1).counts.shortcuts, 0u);
  EXPECT_LT(session.panel(1).errors->flip, 0.01);
  session.lookAt(LookedAt{session.panel(1).id, {0.5, 0.5}});
  ASSERT_TRUE(pumpUntil(session, [&] { return session.ray().isCurrent(); }));
  EXPECT_EQ(session.ray().error(), "");
  session.measureNow();
  ASSERT_TRUE(session.fair().isMeasuring());
  ASSERT_TRUE(pumpUntil(session, [&] { return !session.fair().isMeasuring(); }));
  EXPECT_EQ(session.fair().error(), "");
  EXPECT_TRUE(session.frames().newest()->isAway);
}

TEST_F(SessionAway, IsRecordedAsItIs) {
  const TestFolder folder;
  Session session(ownSettings(), [] {});
  ASSERT_TRUE(load(session, staying("shells")));
  session.startRecording(folder.file("away.warpscope"), "");
  session.update(clock_.now());
  const uint64_t first = session.frames().newest()->requestId;
  isLost_ = true;  // such a frame is not in the recording, which goes on
  turn(session, 20.0);
  ASSERT_TRUE(pumpUntil(session, [&] { return session.frames().newest()->requestId != first; }));
  isLost_ = false;
  turn(session, 20.0);
  ASSERT_TRUE(pumpUntil(session, [&] { return session.panel(1).error.empty(); }) && settle(session));
  const SampleFramePtr expected = onHost(session.frames().newest());
  EXPECT_TRUE(session.close(kPatience));
  EXPECT_EQ(session.recordingFailure(), "");
  const Recording recording = readRecording(folder.file("away.warpscope"));
  EXPECT_GE(recording.frames.size(), 2u);
  const SampleFramePtr frame = RecordedFrames(recording).at(recording.seconds);
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->samples, expected->samples);
  EXPECT_EQ(frame->segments.depths, expected->segments.depths);
}

/// What went with its device is said; the next frame is shown.
TEST_F(SessionAway, AFrameThatIsLostIsSaidAndTheNextOneShown) {
  Session session(ownSettings(), [] {});
  ASSERT_TRUE(load(session, staying("shells")));
  isLost_ = true;
  turn(session, 20.0);
  ASSERT_TRUE(pumpUntil(session, [&] { return !session.panel(1).error.empty(); }));
  EXPECT_THAT(session.panel(1).error, testing::HasSubstr("unplugged"));
  isLost_ = false;
  turn(session, 20.0);
  ASSERT_TRUE(pumpUntil(session, [&] { return session.panel(1).error.empty() && session.panel(2).error.empty(); }) && settle(session));
}

}  // namespace
}  // namespace warpscope

// What is asked of a server, and since when the frames on show are outdated: against a source that answers when it is told to.
// Mirrors app/session/frame_requests.h. Times are made up.
#include "app/session/frame_requests.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace warpscope {
namespace {

using std::chrono::milliseconds;

class ObedientSource final : public FrameSource {
 public:
  void post(const FrameRequest& request, Clock::TimePoint) override { posted.push_back(request); }
  std::optional<ServedFrame> tryTake() override { return std::exchange(answer, std::nullopt); }
  void setTransport(const TransportSettings& transport) override { transports.push_back(transport); }
  SourceStatus status() const override { return {}; }
  void requestStop() override {}

  std::vector<FrameRequest> posted;
  std::vector<TransportSettings> transports;
  std::optional<ServedFrame> answer;
};

class FrameRequestsTest : public ::testing::Test {
 protected:
  FrameRequestsTest() { frames_.begin(source_, {}); }

  static WantedFrame viewFrom(float x) {
    WantedFrame wanted;
    wanted.camera.eye.x = x;
    return wanted;
  }
  bool ask(float x, bool isFrozen = false) { return frames_.ask(viewFrom(x), isFrozen, now_); }
  void answer(uint64_t id, const std::string& error = "") {
    ServedFrame served;
    served.requestId = id;
    served.arrivedAt = now_;
    served.bytes.samples = 100 * id;
    served.error = error;
    if (error.empty()) {
      auto frame = std::make_shared<SampleFrame>();
      frame->requestId = id;
      served.frame = std::move(frame);
    }
    source_.answer = std::move(served);
    ASSERT_TRUE(frames_.take());
  }

  ObedientSource source_;
  FrameRequests frames_;
  Clock::TimePoint now_{std::chrono::hours(1)};
};

TEST_F(FrameRequestsTest, AsksOnceForWhatIsWantedAndAgainWhereItChanges) {
  EXPECT_TRUE(ask(1));
  EXPECT_FALSE(ask(1));
  EXPECT_TRUE(frames_.isUnderWay());
  EXPECT_TRUE(ask(2));
  WantedFrame coded = viewFrom(2);
  coded.codec.jpegQuality = 11;
  EXPECT_TRUE(frames_.ask(coded, false, now_));
  ASSERT_EQ(source_.posted.size(), 3u);
  EXPECT_EQ(source_.posted[1].camera.eye.x, 2.0f);
  EXPECT_LT(source_.posted[1].id, source_.posted[2].id);
  answer(3);
  EXPECT_FALSE(frames_.isUnderWay());
  EXPECT_EQ(frames_.newest()->requestId, 3u);
  EXPECT_EQ(frames_.bytesOfNewest().ofFrame(), 300u);
  EXPECT_EQ(frames_.askedBy(3)->codec.jpegQuality, 11);
}

TEST_F(FrameRequestsTest, AFrameIsAsOldAsItsViewHasNotBeenWanted) {
  ask(1);
  answer(1);
  now_ += milliseconds(50);
  EXPECT_EQ(frames_.ageMs(1, now_), 0.0);
  EXPECT_EQ(frames_.ageOfNewestMs(now_), 50.0);
  ask(2);
  now_ += milliseconds(30);
  ask(3);  // what is on show was outdated before
  EXPECT_EQ(frames_.ageMs(1, now_), 30.0);
  EXPECT_EQ(frames_.ageMs(2, now_), 0.0);
  EXPECT_EQ(frames_.ageMs(3, now_), 0.0);
}

TEST_F(FrameRequestsTest, WhileFrozenNothingIsAskedButForTheFirst) {
  EXPECT_TRUE(ask(1, true));
  answer(1);
  EXPECT_FALSE(ask(2, true));
  EXPECT_FALSE(frames_.isWhatIsWanted());
  now_ += milliseconds(20);
  EXPECT_EQ(frames_.ageMs(1, now_), 20.0);
  EXPECT_FALSE(ask(1, true));  // the camera came back
  EXPECT_TRUE(frames_.isWhatIsWanted());
  EXPECT_EQ(frames_.ageMs(1, now_), 0.0);
  now_ += milliseconds(20);
  EXPECT_FALSE(ask(2, true));
  EXPECT_EQ(frames_.ageMs(1, now_), 0.0) << "counted from the second leave";
  EXPECT_EQ(source_.posted.size(), 1u);
}

TEST_F(FrameRequestsTest, AnErrorIsAnAnswerAndLeavesTheFrame) {
  ask(1);
  answer(1);
  ask(2);
  answer(2, "on fire");
  EXPECT_EQ(frames_.error(), "on fire");
  EXPECT_FALSE(frames_.isUnderWay());
  EXPECT_EQ(frames_.newest()->requestId, 1u);
  EXPECT_EQ(frames_.received(), 1u);
  ask(3);
  answer(3);
  EXPECT_EQ(frames_.error(), "");
}

class CoarseFrames : public FrameRequestsTest {
 protected:
  /// An answer that was marched at that step.
  void answerAt(float step, uint64_t id) {
    ServedFrame served;
    served.requestId = id;
    served.arrivedAt = now_;
    auto frame = std::make_shared<SampleFrame>();
    frame->requestId = id;
    frame->settings.render.step = step;
    served.frame = std::move(frame);
    source_.answer = std::move(served);
    ASSERT_TRUE(frames_.take());
  }
};

TEST_F(CoarseFrames, AreAskedForOnceMoreWhenTheCameraRests) {
  ask(1);
  answerAt(0.5f, 1);
  EXPECT_FALSE(frames_.isToBeRefined());
  ask(2);
  EXPECT_FALSE(frames_.isToBeRefined()) << "it is not there yet";
  answerAt(1.5f, 2);
  EXPECT_TRUE(frames_.isToBeRefined());
  EXPECT_TRUE(ask(2)) << "time passes";
  EXPECT_EQ(source_.posted.size(), 2u);
  now_ += FrameRequests::kRest - milliseconds(1);
  EXPECT_TRUE(ask(2));
  EXPECT_EQ(source_.posted.size(), 2u);
  now_ += milliseconds(1);
  EXPECT_TRUE(ask(2));
  ASSERT_EQ(source_.posted.size(), 3u);
  EXPECT_EQ(source_.posted[2].id, 3u);
  EXPECT_EQ(source_.posted[2].camera, source_.posted[1].camera);
  EXPECT_EQ(source_.posted[2].settings, source_.posted[1].settings) << "in full";
  EXPECT_TRUE(frames_.isUnderWay());
  EXPECT_EQ(frames_.ageMs(2, now_), 0.0) << "what is on show is of the camera of now";
  answerAt(0.5f, 3);
  EXPECT_FALSE(frames_.isToBeRefined());
  EXPECT_FALSE(ask(2));
}

TEST_F(CoarseFrames, AreLeftWhereTheCameraGoesOn) {
  ask(1);
  answerAt(1.5f, 1);
  for (int i = 2; i < 20; ++i) {
    now_ += milliseconds(100);
    EXPECT_TRUE(ask(static_cast<float>(i)));
    EXPECT_EQ(source_.posted.size(), static_cast<size_t>(i));
    answerAt(1.5f, static_cast<uint64_t>(i));
    EXPECT_TRUE(ask(static_cast<float>(i)));
    EXPECT_EQ(source_.posted.size(), static_cast<size_t>(i)) << "it has not rested";
  }
}

TEST_F(CoarseFrames, AreAskedForOnceAndNoMore) {
  ask(1);
  answerAt(1.5f, 1);
  now_ += FrameRequests::kRest;
  EXPECT_TRUE(ask(1));
  answerAt(1.5f, 2);  // a server that does not refine
  now_ += FrameRequests::kRest;
  EXPECT_FALSE(frames_.isToBeRefined());
  EXPECT_FALSE(ask(1));
  EXPECT_EQ(source_.posted.size(), 2u);
  ask(2);
  answerAt(1.5f, 3);
  now_ += FrameRequests::kRest;
  EXPECT_TRUE(ask(2)) << "another camera, another chance";
  EXPECT_EQ(source_.posted.size(), 4u);
}

TEST_F(CoarseFrames, StayWhereNothingIsAskedAnyMore) {
  ask(1);
  answerAt(1.5f, 1);
  now_ += FrameRequests::kRest;
  EXPECT_FALSE(ask(1, true));
  EXPECT_FALSE(frames_.isToBeRefined()) << "frozen";
  EXPECT_TRUE(ask(1, false));
  EXPECT_EQ(source_.posted.size(), 2u);
}

TEST_F(CoarseFrames, AFinerStepIsNoneOfThem) {
  ask(1);
  answerAt(0.25f, 1);
  EXPECT_FALSE(frames_.isToBeRefined());
}

TEST_F(FrameRequestsTest, RemembersWhatIsOnShowOrUnderWayAlone) {
  for (int i = 1; i <= 100; ++i) ask(static_cast<float>(i));
  answer(98);
  frames_.forgetOld([](uint64_t id) { return id == 40; });
  EXPECT_EQ(frames_.remembered(), 4u);  // 40, 98, and those that may still come
  EXPECT_TRUE(frames_.askedBy(40));
  EXPECT_FALSE(frames_.askedBy(97));
  EXPECT_FALSE(frames_.arrivalOf(40));
  EXPECT_EQ(frames_.arrivalOf(98)->bytes.samples, 9800u);
  answer(99);
  answer(100);
  frames_.forgetOld([](uint64_t) { return false; });
  EXPECT_EQ(frames_.remembered(), 1u);
}

TEST_F(FrameRequestsTest, WhereNobodyAnswersFewAreRemembered) {
  ask(0.5f);
  answer(1);
  const int many = 3 * static_cast<int>(FrameRequests::kMostKept);
  for (int i = 1; i <= many; ++i) ask(static_cast<float>(i));
  frames_.forgetOld([](uint64_t) { return false; });
  EXPECT_LE(frames_.remembered(), FrameRequests::kMostKept);
  const auto newest = static_cast<uint64_t>(many) + 1;
  EXPECT_TRUE(frames_.askedBy(1)) << "on show";
  EXPECT_TRUE(frames_.askedBy(2)) << "under way";
  EXPECT_TRUE(frames_.askedBy(newest));
  EXPECT_FALSE(frames_.askedBy(newest / 2)) << "replaced before it left";
  answer(2);
  EXPECT_TRUE(frames_.arrivalOf(2));
  answer(newest);
  EXPECT_TRUE(frames_.arrivalOf(newest));
}

TEST_F(FrameRequestsTest, AnotherSourceBeginsAnewWithIdsThatGoOn) {
  ask(1);
  answer(1);
  ObedientSource other;
  TransportSettings transport;
  transport.depth = 3;
  frames_.begin(other, transport);
  EXPECT_EQ(other.transports, std::vector{transport});
  EXPECT_FALSE(frames_.newest());
  EXPECT_FALSE(frames_.isUnderWay());
  EXPECT_TRUE(ask(1));
  EXPECT_EQ(source_.posted.size(), 1u);
  ASSERT_EQ(other.posted.size(), 1u);
  EXPECT_EQ(other.posted[0].id, 2u);
  frames_.setTransport(transport);  // as it was: nobody is told
  EXPECT_EQ(other.transports.size(), 1u);
}

class SmallFrames : public FrameRequestsTest {
 protected:
  static constexpr uint32_t kWidth = 512, kHeight = 384;

  SmallFrames() {
    TransportSettings transport;
    transport.frameKib = 100;
    frames_.setTransport(transport);
  }
  bool askFrom(float x) {
    WantedFrame wanted = viewFrom(x);
    wanted.camera.width = kWidth;
    wanted.camera.height = kHeight;
    wanted.serverSidePx = kWidth;
    return frames_.ask(wanted, false, now_);
  }
  const Camera& posted() const { return source_.posted.back().camera; }
  /// Four bytes a pixel of what was asked for last: in full 768 KiB.
  void answerLast(float step = 0.5f) {
    ServedFrame served;
    served.requestId = source_.posted.back().id;
    served.arrivedAt = now_;
    served.bytes.samples = 4u * posted().width * posted().height;
    auto frame = std::make_shared<SampleFrame>();
    frame->requestId = served.requestId;
    frame->camera = posted();
    frame->settings.render.step = step;
    served.frame = std::move(frame);
    source_.answer = std::move(served);
    ASSERT_TRUE(frames_.take());
  }
  size_t lastBytes() const { return frames_.bytesOfNewest().ofFrame(); }
};

TEST_F(SmallFrames, FitWhileTheCameraMoves) {
  for (int i = 0; i < 12; ++i) {
    askFrom(static_cast<float>(i));
    answerLast();
    now_ += milliseconds(50);
    EXPECT_EQ(frames_.askedBy(frames_.newest()->requestId)->serverSidePx, posted().width);
    if (i < 3) continue;
    EXPECT_LE(lastBytes(), 102400u) << i;
    EXPECT_GE(lastBytes(), 102400u * 3 / 4) << i;
  }
}

TEST_F(SmallFrames, GrowAtRestUntilNoPixelIsMissing) {
  for (int i = 0; i < 5; ++i) {
    askFrom(static_cast<float>(i));
    answerLast();
  }
  size_t before = lastBytes();
  EXPECT_TRUE(frames_.isToBeRefined());
  EXPECT_TRUE(askFrom(4)) << "time passes";
  now_ += FrameRequests::kRest;
  int grown = 0;
  while (frames_.isToBeRefined()) {
    ASSERT_LT(++grown, 8);
    EXPECT_TRUE(askFrom(4));
    EXPECT_EQ(posted().eye.x, 4.0f);
    EXPECT_LE(posted().width, kWidth);
    answerLast();
    EXPECT_GT(lastBytes(), before);
    EXPECT_LE(static_cast<double>(lastBytes()), 2.5 * static_cast<double>(before)) << "whoever moves on waits for no more";
    before = lastBytes();
  }
  EXPECT_GT(grown, 1);
  EXPECT_EQ(posted().width, kWidth);
  EXPECT_EQ(posted().height, kHeight);
  EXPECT_EQ(frames_.askedBy(frames_.newest()->requestId)->serverSidePx, kWidth);
  EXPECT_FALSE(askFrom(4));
  now_ += milliseconds(10);
  EXPECT_TRUE(askFrom(5));
  EXPECT_LT(posted().width, kWidth / 2) << "it moves again";
}

TEST_F(SmallFrames, ThatAreCoarseAsWellAreRefinedToTheEnd) {
  for (int i = 0; i < 4; ++i) {
    askFrom(static_cast<float>(i));
    answerLast(1.5f);
  }
  now_ += FrameRequests::kRest;
  while (frames_.isToBeRefined() && frames_.newest()->settings.render.step != 0.5f) {
    const Camera before = posted();
    ASSERT_TRUE(askFrom(3));
    answerLast(posted() == before ? 0.5f : 1.5f);  // a server takes another image for a camera that moves
  }
  EXPECT_EQ(posted().width, kWidth);
  EXPECT_EQ(frames_.newest()->settings.render.step, 0.5f);
  EXPECT_FALSE(frames_.isToBeRefined());
}

TEST_F(SmallFrames, AreWholeWhereNothingIsSaidOfBytes) {
  frames_.setTransport({});
  for (int i = 0; i < 4; ++i) {
    askFrom(static_cast<float>(i));
    EXPECT_EQ(posted().width, kWidth);
    answerLast();
    EXPECT_FALSE(frames_.isToBeRefined());
  }
}

}  // namespace
}  // namespace warpscope

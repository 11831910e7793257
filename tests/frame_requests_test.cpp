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
  bool waitForEnd(std::chrono::steady_clock::time_point) override { return true; }

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

}  // namespace
}  // namespace warpscope

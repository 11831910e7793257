// Wrong tokens: how often they are listened to, what the log gets of them, and that neither grows.
// Mirrors net/login_limiter.h; time is moved by hand.
#include "net/login_limiter.h"

#include <gmock/gmock.h>

namespace warpscope::net {
namespace {

using std::chrono::milliseconds, std::chrono::seconds;
using testing::HasSubstr, testing::Not;

class LoginLimiterTest : public testing::Test {
 protected:
  Clock::TimePoint now_{std::chrono::hours(1)};
  LoginLimiter limiter_;
};

TEST_F(LoginLimiterTest, AMistakeCostsNothingAndPersistenceMoreEachTime) {
  for (int i = 0; i < LoginLimits().freeFailures; ++i) {
    limiter_.failed("192.0.2.1:4000", now_);
    EXPECT_TRUE(limiter_.admits("192.0.2.1:4001", now_));
  }
  for (const int expectedMs : {1000, 2000, 4000, 8000, 16000, 30000, 30000}) {
    EXPECT_THAT(limiter_.failed("192.0.2.1:4002", now_), HasSubstr("not listened to for " + std::to_string(expectedMs / 1000) + " s"));
    EXPECT_FALSE(limiter_.admits("192.0.2.1:4003", now_));
    EXPECT_FALSE(limiter_.admits("192.0.2.1:4004", now_ + milliseconds(expectedMs - 1)));
    EXPECT_TRUE(limiter_.admits("192.0.2.2:4005", now_)) << "another machine waits as well";
    now_ += milliseconds(expectedMs);
    EXPECT_TRUE(limiter_.admits("192.0.2.1:4006", now_));
  }
  EXPECT_THAT(limiter_.failed("192.0.2.1:7", now_), HasSubstr("2 more connections were turned away"));
}

/// However fast somebody tries: tokens compared in an hour.
TEST_F(LoginLimiterTest, AnHourOfTryingIsHardlyATry) {
  int compared = 0;
  for (const auto end = now_ + std::chrono::hours(1); now_ < end; now_ += milliseconds(1))
    if (limiter_.admits("192.0.2.1:1", now_)) {
      limiter_.failed("192.0.2.1:1", now_);
      ++compared;
    }
  EXPECT_LE(compared, 3600 / 30 + 10);
}

TEST_F(LoginLimiterTest, TheRightTokenAndTimeMakeGood) {
  for (int i = 0; i < 6; ++i) limiter_.failed("192.0.2.1:1", now_);
  limiter_.succeeded("192.0.2.1:2");
  EXPECT_TRUE(limiter_.admits("192.0.2.1:3", now_));
  EXPECT_THAT(limiter_.failed("192.0.2.1:4", now_), Not(HasSubstr("in a row")));
  for (int i = 0; i < 6; ++i) limiter_.failed("192.0.2.1:5", now_);
  now_ += LoginLimits().memory;
  EXPECT_THAT(limiter_.failed("192.0.2.1:6", now_), Not(HasSubstr("in a row")));
}

TEST_F(LoginLimiterTest, OneMachineIsOneSource) {
  for (int i = 0; i < 6; ++i) limiter_.failed("[2001:db8::" + std::to_string(i) + "]:4711", now_);
  EXPECT_FALSE(limiter_.admits("[2001:db8::ffff]:1", now_));
  EXPECT_TRUE(limiter_.admits("[2001:db8:0:1::1]:1", now_));
  for (int i = 0; i < 3; ++i) {
    limiter_.failed("198.51.100.1:1", now_);
    limiter_.failed("[::ffff:198.51.100.1]:1", now_);
  }
  EXPECT_FALSE(limiter_.admits("198.51.100.1:2", now_));
  for (int i = 0; i < 6; ++i) limiter_.failed("no address", now_);
  EXPECT_FALSE(limiter_.admits("none either", now_));
}

TEST_F(LoginLimiterTest, NeitherMemoryNorTheLogGrows) {
  size_t lines = 0;
  std::string last;
  for (int i = 0; i < 100'000; ++i) {
    const std::string peer = "10." + std::to_string(i >> 16) + "." + std::to_string(i >> 8 & 255) + "." + std::to_string(i & 255) + ":9";
    const std::string line = limiter_.failed(peer, now_ += milliseconds(1));
    lines += !line.empty();
    if (!line.empty()) last = line;
  }
  EXPECT_LE(limiter_.addresses(), LoginLimits().maxAddresses);
  EXPECT_LE(lines, 3u * static_cast<size_t>(LoginLimits().linesAMinute));  // in 100 s: parts of three minutes at most
  now_ += seconds(60);
  EXPECT_THAT(limiter_.failed("192.0.2.9:9", now_), testing::ContainsRegex("192.0.2.9:9: a wrong token .and [0-9]+ wrong tokens that no line tells of"));
}

}  // namespace
}  // namespace warpscope::net

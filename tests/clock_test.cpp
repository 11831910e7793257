// Time that is handed in: sleeping in real time, and a clock that is moved by hand, with its sleepers and alarms.
// Mirrors render/base/clock.h.
#include "render/base/clock.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace warpscope {
namespace {

using namespace std::chrono_literals;

TEST(SteadyClock, CallsNobody) {
  EXPECT_FALSE(steadyClock().callAt({}, [] { FAIL() << "real time is kept by the system's timers"; }));
  EXPECT_EQ(&steadyClock(), &steadyClock());
}

TEST(SteadyClock, WaitsUntilTheTimeOrTheStop) {
  SteadyClock clock;
  const Clock::TimePoint due = clock.now() + 5ms;
  EXPECT_TRUE(clock.waitUntil(due, {}));
  EXPECT_GE(clock.now(), due);
  std::stop_source source;
  source.request_stop();
  EXPECT_FALSE(clock.waitUntil(clock.now() + 1h, source.get_token()));
}

TEST(VirtualClock, StandsStillUntilItIsMoved) {
  VirtualClock clock;
  EXPECT_EQ(clock.now(), Clock::TimePoint{});
  clock.advance(5ms);
  EXPECT_EQ(clock.now(), Clock::TimePoint(5ms));
}

TEST(VirtualClock, AlarmsRingOnceInTheOrderOfTheirTimes) {
  VirtualClock clock;
  std::vector<int> rung;
  clock.callAt(Clock::TimePoint(20ms), [&] { rung.push_back(20); });
  clock.callAt(Clock::TimePoint(10ms), [&] { rung.push_back(10); });
  clock.callAt(Clock::TimePoint(10ms), [&] { rung.push_back(11); });
  clock.advance(9ms);
  EXPECT_TRUE(rung.empty());
  clock.advance(1ms);
  EXPECT_EQ(rung, (std::vector<int>{10, 11}));
  clock.advance(1s);
  EXPECT_EQ(rung, (std::vector<int>{10, 11, 20}));
}

TEST(VirtualClock, AnAlarmForThePastRingsAtOnce) {
  VirtualClock clock;
  clock.advance(1s);
  int rung = 0;
  clock.callAt(clock.now(), [&] { ++rung; });
  EXPECT_EQ(rung, 1);
  clock.advance(1s);
  EXPECT_EQ(rung, 1);
}

TEST(VirtualClock, ForgottenAlarmsDoNotRing) {
  VirtualClock clock;
  const auto alarm = clock.callAt(Clock::TimePoint(10ms), [] { FAIL(); });
  ASSERT_TRUE(alarm);
  EXPECT_TRUE(clock.hasSleeper(Clock::TimePoint(10ms)));
  clock.forget(*alarm);
  clock.forget(*alarm);
  EXPECT_FALSE(clock.hasSleeper(Clock::TimePoint(10ms)));
  clock.advance(1s);
}

TEST(VirtualClock, GoesFromOneSleeperOrAlarmToTheNext) {
  VirtualClock clock;
  int rung = 0;
  clock.callAt(Clock::TimePoint(10ms), [&] { ++rung; });
  clock.callAt(Clock::TimePoint(30ms), [&] { ++rung; });
  std::jthread sleeper([&](const std::stop_token& stop) { clock.waitUntil(Clock::TimePoint(20ms), stop); });
  while (!clock.hasSleeper(Clock::TimePoint(20ms))) std::this_thread::yield();
  EXPECT_EQ(clock.advanceToNextSleeper(), Clock::TimePoint(10ms));
  EXPECT_FALSE(clock.advanceToNextSleeper(Clock::TimePoint(19ms))) << "nobody wants to be woken by then";
  EXPECT_EQ(clock.now(), Clock::TimePoint(10ms));
  EXPECT_TRUE(clock.advanceToNextSleeper(Clock::TimePoint(20ms)));
  EXPECT_EQ(clock.now(), Clock::TimePoint(20ms));
  sleeper.join();
  EXPECT_TRUE(clock.advanceToNextSleeper(Clock::TimePoint(1s)));
  EXPECT_EQ(clock.now(), Clock::TimePoint(30ms));
  EXPECT_FALSE(clock.advanceToNextSleeper(Clock::TimePoint(1s)));
  EXPECT_EQ(rung, 2);
}

TEST(VirtualClock, ForgettingWaitsForAnAlarmThatRings) {
  VirtualClock clock;
  std::atomic<bool> isRinging = false, hasRung = false;
  const auto alarm = clock.callAt(Clock::TimePoint(1ms), [&] {
    isRinging = true;
    std::this_thread::sleep_for(20ms);
    hasRung = true;
  });
  const std::jthread moving([&] { clock.advance(1ms); });
  while (!isRinging) std::this_thread::yield();
  clock.forget(*alarm);
  EXPECT_TRUE(hasRung);
}

}  // namespace
}  // namespace warpscope

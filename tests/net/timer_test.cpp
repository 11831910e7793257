// Timers in both kinds of time: when they come, what ends a wait, and that nothing rings for who is gone.
// Mirrors net/timer.h and IoThread's clock.
#include "net/timer.h"

#include <thread>
#include <vector>

#include "net/io_thread.h"
#include "tests/net/io_test.h"

namespace warpscope::net {
namespace {

class TimerTest : public IoTest {
 protected:
  /// Waits, and notes what time it is then, in milliseconds.
  Awaitable<void> waitFor(Timer& timer) {
    co_await timer.wait();
    cameMs_.push_back(millisecondsBetween({}, clock_.now()));
  }

  std::vector<double> cameMs_;
};

TEST_F(TimerTest, ComesAtItsTimeAndNotBefore) {
  Timer timer(io_.get_executor(), inTime(milliseconds(30)));
  spawn([&]() -> Awaitable<> { co_await waitFor(timer); });
  run([&]() -> Awaitable<> {
    co_await pass(milliseconds(29));
    EXPECT_TRUE(cameMs_.empty());
    co_await pass(milliseconds(1));
    EXPECT_EQ(cameMs_, std::vector<double>{30.0});
  });
}

TEST_F(TimerTest, ComesInTheOrderOfTheTimes) {
  Timer late(io_.get_executor(), inTime(milliseconds(20))), early(io_.get_executor(), inTime(milliseconds(10)));
  spawn([&]() -> Awaitable<> { co_await waitFor(late); });
  spawn([&]() -> Awaitable<> { co_await waitFor(early); });
  runThrough();
  EXPECT_EQ(cameMs_, (std::vector<double>{10.0, 20.0}));
}

TEST_F(TimerTest, ATimeThatIsPastComesAtOnce) {
  clock_.advance(seconds(1));
  Timer timer(io_.get_executor(), TimePoint{});
  run([&]() -> Awaitable<> {
    co_await waitFor(timer);
    co_await waitFor(timer);  // and stays
  });
  EXPECT_EQ(cameMs_, (std::vector<double>{1000.0, 1000.0}));
}

TEST_F(TimerTest, CancellingAndSettingEndWaits) {
  Timer timer(io_.get_executor());  // no time: it never comes
  spawn([&]() -> Awaitable<> {
    co_await waitFor(timer);
    co_await waitFor(timer);
    co_await waitFor(timer);
  });
  run([&]() -> Awaitable<> {
    co_await pass(std::chrono::hours(100));
    EXPECT_TRUE(cameMs_.empty());
    timer.cancel();
    co_await pass({});
    EXPECT_EQ(cameMs_.size(), 1u);
    timer.setTo(inTime(milliseconds(5)));
    co_await pass({});
    EXPECT_EQ(cameMs_.size(), 2u) << "whoever waited for another time";
    co_await pass(milliseconds(5));
    EXPECT_EQ(cameMs_.size(), 3u);
  });
}

TEST_F(TimerTest, ATimeThatWasReplacedDoesNotCome) {
  Timer timer(io_.get_executor(), inTime(milliseconds(10)));
  // Its alarm has rung, but nobody has heard it yet.
  clock_.advance(milliseconds(10));
  timer.setTo(inTime(milliseconds(10)));
  spawn([&]() -> Awaitable<> { co_await waitFor(timer); });
  runThrough();
  EXPECT_EQ(cameMs_, std::vector<double>{20.0});
}

TEST_F(TimerTest, CallsSayWhetherTheTimeHasCome) {
  std::vector<bool> said;
  const auto note = [&](bool hasCome) { said.push_back(hasCome); };
  Timer comes(io_.get_executor(), inTime(milliseconds(10))), cancelled(io_.get_executor(), inTime(milliseconds(10)));
  std::optional<Timer> gone(std::in_place, io_.get_executor(), inTime(milliseconds(10)));
  cancelled.onEnd(note);
  cancelled.cancel();
  gone->onEnd(note);
  gone.reset();
  run([&]() -> Awaitable<> { co_await pass({}); });
  EXPECT_EQ(said, (std::vector<bool>{false, false}));
  comes.onEnd(note);
  run([&]() -> Awaitable<> {
    co_await pass(milliseconds(10));
    comes.onEnd(note);  // it has come already
    co_await pass({});
  });
  EXPECT_EQ(said, (std::vector<bool>{false, false, true, true}));
}

TEST_F(TimerTest, LeavesNoAlarmBehind) {
  const TimePoint time = inTime(milliseconds(10));
  std::optional<Timer> timer(std::in_place, io_.get_executor(), time);
  EXPECT_TRUE(clock_.hasSleeper(time));
  timer->setTo(time + milliseconds(1));
  EXPECT_FALSE(clock_.hasSleeper(time));
  timer.reset();
  EXPECT_FALSE(clock_.hasSleeper(time + milliseconds(1)));
}

/// The clock is moved by another thread than the timers'.
TEST(Timer, IsWokenFromAnyThreadAndMayGoMeanwhile) {
  VirtualClock clock;
  std::atomic<int> come = 0;
  {
    IoThread io(clock);
    std::jthread moving([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) clock.advance(std::chrono::microseconds(1));
    });
    for (int i = 0; i < 2000; ++i) {
      io.call([&] {
        Timer gone(io.context().get_executor(), clock.now() + std::chrono::microseconds(i % 5));
        gone.onEnd([&](bool) {});
      });
    }
    asio::co_spawn(
        io.context(),
        [&]() -> Awaitable<> {
          Timer timer(io.context().get_executor());
          for (int i = 0; i < 500; ++i) {
            timer.setTo(clock.now() + std::chrono::microseconds(i % 5));
            co_await timer.wait();
            ++come;
          }
        },
        asio::detached);
    while (come < 500) std::this_thread::yield();
  }
  EXPECT_EQ(come, 500);
}

TEST(Timer, WithoutAClockOfItsOwnAContextHasRealTime) {
  asio::io_context io(1);
  EXPECT_EQ(&clockOf(io.get_executor()), &steadyClock());
  const TimePoint begin = steadyClock().now();
  TimePoint end;
  asio::co_spawn(
      io,
      [&]() -> Awaitable<> {
        Timer timer(io.get_executor(), begin + milliseconds(20));
        co_await timer.wait();
        end = timer.clock().now();
      },
      asio::detached);
  io.run();
  EXPECT_GE(end - begin, milliseconds(20));
}

TEST(Timer, AThreadHasTheClockThatItWasHanded) {
  VirtualClock clock;
  IoThread io(clock), real;
  EXPECT_EQ(&io.clock(), &clock);
  EXPECT_EQ(&clockOf(io.context().get_executor()), &clock);
  EXPECT_EQ(&clockOf(real.context().get_executor()), &steadyClock());
}

}  // namespace
}  // namespace warpscope::net

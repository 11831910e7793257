// Threads that let others go first: that loops run on them and nowhere else, what is thrown there, and who gets a core that both want.
// Mirrors render/core/crew.h and what parallel.h makes of it.
#include "render/core/crew.h"
#include "render/core/expected_break.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "render/base/error.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

using namespace std::chrono_literals;

int niceOfThisThread() { return getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())); }

/// Where the pieces of a loop ran.
class Places {
 public:
  void add() {
    const std::scoped_lock lock(mutex_);
    threads_.insert(std::this_thread::get_id());
    nices_.insert(niceOfThisThread());
  }
  std::set<std::thread::id> threads() const { return threads_; }
  std::set<int> nices() const { return nices_; }

 private:
  std::mutex mutex_;
  std::set<std::thread::id> threads_;
  std::set<int> nices_;
};

TEST(Crew, EveryThreadTakesPartOnce) {
  Crew crew(3);
  EXPECT_EQ(crew.size(), 3u);
  for (int repetition = 0; repetition < 20; ++repetition) {
    Places places;
    std::atomic<int> calls = 0;
    crew.run([&] {
      places.add();
      ++calls;
    });
    EXPECT_EQ(calls, 3);
    EXPECT_EQ(places.threads().size(), 3u);
    EXPECT_FALSE(places.threads().contains(std::this_thread::get_id()));
  }
}

TEST(Crew, ItsThreadsStandBackBehindOthers) {
  Crew crew(2);
  Places places;
  crew.run([&] { places.add(); });
  ASSERT_EQ(places.nices().size(), 1u);
  if (niceOfThisThread() >= 19) GTEST_SKIP() << "nothing stands behind nice 19";
  EXPECT_GT(*places.nices().begin(), niceOfThisThread());
}

TEST(Crew, LoopsOfAShiftRunOnItAndThoseAfterItDoNot) {
  Crew crew(2);
  constexpr size_t kGrain = 7;
  // oneTBB cuts as it likes: into larger pieces where there is one core.
  const size_t largestOfPool = (Crew::usualSize() > 1 ? 2 : 4) * kGrain;
  const auto placesOfLoop = [&] {
    const bool isOnCrew = Crew::ofThisThread() != nullptr;
    Places places;
    std::vector<std::atomic<int>> times(1000);
    parallelForRanges(times.size(), kGrain, [&](size_t begin, size_t end) {
      EXPECT_LE(end - begin, isOnCrew ? kGrain : largestOfPool);
      places.add();
      for (size_t i = begin; i < end; ++i) ++times[i];
    });
    for (const auto& one : times) EXPECT_EQ(one, 1);
    return places.threads();
  };
  Places of;
  crew.run([&] { of.add(); });
  const std::set<std::thread::id> members = of.threads();
  {
    const Crew::Shift shift(&crew);
    EXPECT_EQ(Crew::ofThisThread(), &crew);
    for (const std::thread::id thread : placesOfLoop()) EXPECT_TRUE(members.contains(thread));
    {
      const Crew::Shift none(nullptr);
      for (const std::thread::id thread : placesOfLoop()) EXPECT_FALSE(members.contains(thread));
    }
    std::jthread([&] { EXPECT_EQ(Crew::ofThisThread(), nullptr); });
  }
  EXPECT_EQ(Crew::ofThisThread(), nullptr);
  for (const std::thread::id thread : placesOfLoop()) EXPECT_FALSE(members.contains(thread));
}

TEST(Crew, WhatIsThrownComesOutAndTheCrewGoesOn) {
  Crew crew(3);
  const Crew::Shift shift(&crew);
  EXPECT_THROW(parallelForRanges(100, 1, [](size_t begin, size_t) { if (begin == 50) throw std::runtime_error("50"); }), std::runtime_error);
  std::stop_source stop;
  EXPECT_THROW(parallelForRanges(100, 1, stop.get_token(), [&](size_t, size_t) { stop.request_stop(); }), OperationCancelled);
  std::atomic<size_t> done = 0;
  parallelForRanges(100, 1, [&](size_t begin, size_t end) { done += end - begin; });
  EXPECT_EQ(done, 100u);
  parallelForRanges(0, 1, [&](size_t, size_t) { ++done; });
  EXPECT_EQ(done, 100u);
}

TEST(Crew, ALoopWithinALoopEnds) {
  Crew crew(2);
  const Crew::Shift shift(&crew);
  std::atomic<size_t> done = 0;
  parallelForRanges(8, 1, [&](size_t, size_t) { parallelForRanges(8, 1, [&](size_t, size_t) { ++done; }); });
  EXPECT_EQ(done, 64u);
}

TEST(Crew, PausesBetweenTwoPiecesDuringABreak) {
  Crew crew(2);
  std::atomic<size_t> done = 0, doneInBreak = 0;
  std::atomic<bool> isBreak = false;
  const auto loop = [&] {
    const Crew::Shift shift(&crew);
    parallelForRanges(20, 1, [&](size_t, size_t) {
      if (isBreak) ++doneInBreak;
      ++done;
    });
  };
  const auto began = std::chrono::steady_clock::now();
  {
    auto pause = std::make_unique<Crew::Break>();
    isBreak = true;
    std::jthread caller(loop);
    std::this_thread::sleep_for(5ms);
    isBreak = false;
    pause.reset();
  }
  EXPECT_EQ(done, 20u);
  if (std::chrono::steady_clock::now() - began > Crew::kMostPause) GTEST_SKIP() << "a machine too busy to tell";
  EXPECT_EQ(doneInBreak, 0u);
  done = 0;
  loop();
  EXPECT_EQ(done, 20u);
}

TEST(Crew, NoBreakHoldsItUpForGood) {
  Crew crew(1);
  const Crew::Shift shift(&crew);
  const Crew::Break forGood;
  const auto began = std::chrono::steady_clock::now();
  std::atomic<size_t> done = 0;
  parallelForRanges(3, 1, [&](size_t, size_t) { ++done; });
  EXPECT_EQ(done, 3u);
  EXPECT_GE(std::chrono::steady_clock::now() - began, 3 * Crew::kMostPause);
}

TEST(Crew, ABreakDoesNotHoldUpWhoDoesNotStandBack) {
  const Crew::Break own;
  const auto began = std::chrono::steady_clock::now();
  for (int i = 0; i < 20; ++i) Crew::pauseForBreaks();
  EXPECT_LT(std::chrono::steady_clock::now() - began, 10 * Crew::kMostPause);
}

TEST(ExpectedBreak, IsLeftAloneByWhatWouldNotEndBefore) {
  const auto elapsed = [](std::chrono::milliseconds untilBreak, std::chrono::milliseconds length) {
    std::chrono::steady_clock::duration taken{};
    std::jthread([&] {
      Crew::standBack(0);
      const auto began = std::chrono::steady_clock::now();
      expectBreak(began + untilBreak);
      leaveBreakAlone(length);
      taken = std::chrono::steady_clock::now() - began;
    }).join();
    return taken;
  };
  EXPECT_GE(elapsed(5ms, 8ms), 5ms);
  EXPECT_GE(elapsed(kMostTimeBeforeBreak - 2ms, 1000ms), kMostTimeBeforeBreak - 2ms);
  const auto isSoon = [&](std::chrono::milliseconds untilBreak, std::chrono::milliseconds length) {  // on a machine that others use as well
    for (int i = 0; i < 20; ++i)
      if (elapsed(untilBreak, length) < 5ms) return true;
    return false;
  };
  EXPECT_TRUE(isSoon(1000ms, 8ms));
  EXPECT_TRUE(isSoon(kMostTimeBeforeBreak + 2ms, 1000ms));
  EXPECT_TRUE(isSoon(-5ms, 8ms));
  const auto began = std::chrono::steady_clock::now();  // by a thread that does not stand back: never late in all of them
  for (int i = 0; i < 100; ++i) {
    expectBreak(std::chrono::steady_clock::now() + 5ms);
    leaveBreakAlone(8ms);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - began, 100 * 5ms);
  const Crew::Break atWork;
  EXPECT_GE(elapsed(-5ms, 1ms), Crew::kMostPause);
}

// What it is for: who draws while it works gets most of a core that both want. The system is asked for shares, so that other programs do not matter: both
// sides count what they get done in the same time.
TEST(Crew, WhoWorksBesideItGetsMostOfTheMachine) {
  if (niceOfThisThread() > 10) GTEST_SKIP() << "the tests themselves stand back";
  const size_t cores = std::max(1u, std::thread::hardware_concurrency());
  Crew crew(cores);
  std::atomic<bool> isOver = false;
  std::atomic<uint64_t> ofCrew = 0, ofOthers = 0;
  const auto work = [&](std::atomic<uint64_t>& done) {
    while (!isOver) {
      volatile uint32_t x = 1;
      for (int i = 0; i < 10000; ++i) x = x * 1664525u + 1013904223u;
      ++done;
    }
  };
  std::vector<std::jthread> others;
  for (size_t i = 0; i < cores; ++i) others.emplace_back([&] { work(ofOthers); });
  std::jthread end([&] {
    std::this_thread::sleep_for(1500ms);
    isOver = true;
  });
  crew.run([&] { work(ofCrew); });
  EXPECT_GT(ofCrew, 0u) << "it does not starve";
  EXPECT_GT(static_cast<double>(ofOthers), 1.4 * static_cast<double>(ofCrew));
}

}  // namespace
}  // namespace warpscope

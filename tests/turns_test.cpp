// Turns in the order of asking, work in slices, and marches that would take too long: with work of the test's own, and with a marcher.
// Mirrors render/core/turns.h and what parallel.h makes of it.
#include "render/core/turns.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "render/base/error.h"
#include "render/core/parallel.h"
#include "render/march/marcher_cpu.h"
#include "render/volume/procedural.h"
#include "tests/marcher_cases.h"

namespace warpscope {
namespace {

using namespace std::chrono_literals;

void workFor(std::chrono::nanoseconds time) {
  for (const auto end = std::chrono::steady_clock::now() + time; std::chrono::steady_clock::now() < end;) {
  }
}

TEST(Turns, OneAtATimeInTheOrderOfAsking) {
  Turns turns;
  std::vector<int> order;
  std::vector<std::jthread> threads;
  {
    const Turns::Turn first = turns.take({});
    for (int i = 0; i < 8; ++i) {
      threads.emplace_back([&, i] {
        const Turns::Turn turn = turns.take({});
        order.push_back(i);  // only who has the turn does
      });
      while (turns.waiting() <= static_cast<size_t>(i)) std::this_thread::yield();
    }
    EXPECT_TRUE(order.empty());
  }
  threads.clear();
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST(Turns, AFewAtATimeInTheOrderOfAsking) {
  Turns turns;
  turns.sibling()->setAtOnce(3);
  std::atomic<int> inside = 0, most = 0, begun = 0;
  std::atomic<bool> mayEnd = false;
  std::vector<std::jthread> threads;
  std::vector<std::atomic<bool>> hasBegun(8);
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&, i] {
      const Turns::Turn turn = turns.take({});
      const int now = ++inside;
      for (int known = most; now > known && !most.compare_exchange_weak(known, now);) {
      }
      hasBegun[static_cast<size_t>(i)] = true;
      ++begun;
      while (!mayEnd) std::this_thread::yield();
      --inside;
    });
    while (begun + static_cast<int>(turns.waiting()) <= i) std::this_thread::yield();
  }
  EXPECT_EQ(begun, 3);
  for (size_t i = 0; i < 8; ++i) EXPECT_EQ(hasBegun[i], i < 3) << "the first that asked";
  mayEnd = true;
  threads.clear();
  EXPECT_EQ(begun, 8);
  EXPECT_EQ(most, 3);
}

TEST(Turns, WhoGivesUpLeavesThoseBehindTheirTurns) {
  Turns turns;
  turns.setAtOnce(2);
  std::atomic<int> begun = 0;
  std::jthread waits;
  {
    const Turns::Turn one = turns.take({}), other = turns.take({});
    std::jthread givesUp([&](const std::stop_token& stop) { EXPECT_THROW(turns.take(stop), OperationCancelled); });
    while (turns.waiting() < 1) std::this_thread::yield();
    waits = std::jthread([&] {
      const Turns::Turn turn = turns.take({});
      ++begun;
    });
    while (turns.waiting() < 2) std::this_thread::yield();
    givesUp.request_stop();
    givesUp.join();
    EXPECT_EQ(turns.waiting(), 1u);
    EXPECT_EQ(begun, 0);
  }
  waits.join();
  EXPECT_EQ(begun, 1);
}

TEST(Turns, WhoGivesUpLeavesTheRow) {
  Turns turns;
  std::jthread waiter;
  {
    const Turns::Turn first = turns.take({});
    waiter = std::jthread([&](const std::stop_token& stop) { EXPECT_THROW(turns.take(stop), OperationCancelled); });
    while (turns.waiting() == 0) std::this_thread::yield();
    waiter.request_stop();
    waiter.join();
    EXPECT_EQ(turns.waiting(), 0u);
  }
  const Turns::Turn next = turns.take({});
}

/// Two that end wake the same first one, which has to wake the next.
TEST(Turns, AllThatMayHaveATurnGetOne) {
  Turns turns;
  turns.setAtOnce(2);
  std::atomic<int> inside = 0;
  std::atomic<bool> met = false;
  std::vector<std::jthread> threads;
  {
    const Turns::Turn one = turns.take({}), other = turns.take({});
    for (size_t i = 0; i < 2; ++i) {
      threads.emplace_back([&] {
        const Turns::Turn turn = turns.take({});
        ++inside;
        for (const auto end = std::chrono::steady_clock::now() + 20s; inside < 2 && std::chrono::steady_clock::now() < end;) std::this_thread::yield();
        if (inside == 2) met = true;
      });
      while (turns.waiting() <= i) std::this_thread::yield();
    }
  }
  threads.clear();
  EXPECT_TRUE(met);
}

TEST(Turns, OfTurnsAtTheSameTimeAJobUsesItsShare) {
  Turns turns({.limit = 160ms});
  turns.setAtOnce(2);
  const auto workTwice = [&] {
    TurnsOfJob job(&turns);
    for (int i = 0; i < 2; ++i)
      job.work(
          {},
          [](auto) {
            std::this_thread::sleep_for(100ms);
            return false;
          },
          [] { return 0.5; });
  };
  EXPECT_THROW(workTwice(), WorkLimitExceeded);
  const Turns::Turn another = turns.take({});
  EXPECT_NO_THROW(workTwice());
}

TEST(Turns, WorkIsCutInSlices) {
  Turns turns({.slice = 2ms});
  TurnsOfJob job(&turns);
  std::atomic<int> calls = 0;
  std::atomic<int> betweenTurns = 0;
  std::vector<std::atomic<int>> done(200);
  std::jthread other([&](const std::stop_token& stop) {
    try {
      while (true) {
        const Turns::Turn turn = turns.take(stop);
        if (calls > 0 && calls < 200) ++betweenTurns;
      }
    } catch (const OperationCancelled&) {
    }
  });
  parallelForInTurns(200, job, {}, [&](size_t i) {
    ++calls;
    ++done[i];
    workFor(100us);
  });
  other.request_stop();
  EXPECT_GT(betweenTurns, 2) << "20 ms of work on as many cores as there are, in slices of 2";
  for (const auto& times : done) EXPECT_EQ(times, 1);
}

TEST(Turns, WhatTakesTooLongIsGivenUp) {
  Turns turns({.slice = 1ms, .limit = 40ms});
  TurnsOfJob job(&turns);
  try {
    parallelForInTurns(100'000, job, {}, [](size_t) { workFor(1ms); });
    FAIL() << "100 s of work";
  } catch (const WorkLimitExceeded& error) {
    EXPECT_EQ(error.limit(), 40ms);
    EXPECT_GT(error.share(), 0.0);
    EXPECT_LT(error.share(), 0.02);
  }
  TurnsOfJob another(&turns);
  EXPECT_NO_THROW(parallelForInTurns(10, another, {}, [](size_t) { workFor(1ms); })) << "the limit is one job's";
}

TEST(Turns, AMarchInTurnsIsTheSameAndEndsAtItsLimit) {
  const MarcherPtr whole = makeCpuMarcher(makeProceduralVolume("shells", glm::uvec3(32)), everywhere(0.01f));
  const MarcherPtr inTurns = whole->twin(std::make_shared<Turns>(TurnSettings{.slice = std::chrono::milliseconds(1)}));
  const Camera camera = lookingFrom({40.0f, 30.0f, 90.0f}, glm::vec3(16.0f), 70, 50);
  MarchSettings settings;
  for (const float step : {0.5f, 0.005f}) {  // tiles are smaller where there are many steps
    settings.render.step = step;
    EXPECT_TRUE(sameFrame(whole->march(camera, settings), inTurns->march(camera, settings))) << step;
    EXPECT_TRUE(sameBits(rendered(*whole, camera, settings), rendered(*inTurns, camera, settings))) << step;
  }
  const MarcherPtr limited = whole->twin(std::make_shared<Turns>(TurnSettings{.slice = 1ms, .limit = 2ms}));
  settings.render.terminateEarly = false;
  EXPECT_THROW(limited->march(camera, settings), WorkLimitExceeded);
  const Camera small = lookingFrom({40.0f, 30.0f, 90.0f}, glm::vec3(16.0f), 2, 1);
  EXPECT_NO_THROW(limited->march(small, {})) << "the next one has its own time";
}

}  // namespace
}  // namespace warpscope

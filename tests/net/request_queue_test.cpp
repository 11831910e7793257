// Turns, the newest of what waits, limits per client, and threads that wait, stop and leave at once.
// Mirrors net/request_queue.h.
#include "net/request_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <thread>

namespace warpscope::net {
namespace {

using namespace std::chrono_literals;

bool put(RequestQueue& queue, ClientId client, uint64_t id) {
  FrameRequest request;
  request.id = id;
  return queue.put(client, request, {});
}

/// What is there to take now. Whoever has come last is served last: where its request is given out, there is no other.
std::optional<RequestJob> takeNow(RequestQueue& queue) {
  constexpr ClientId kLast = 1'000'000;
  queue.join(kLast, 1);
  EXPECT_TRUE(put(queue, kLast, 1));
  std::optional<RequestJob> job = queue.take({});
  queue.leave(kLast);
  if (job && job->client == kLast) return std::nullopt;
  if (job) queue.finished(job->client, 0);
  return job;
}

TEST(RequestQueue, EachClientHasItsTurn) {
  RequestQueue queue;
  for (ClientId client = 1; client <= 64; ++client) queue.join(client, 4);
  for (uint64_t id = 1; id <= 4; ++id)
    for (ClientId client = 1; client <= 64; ++client) ASSERT_TRUE(put(queue, client, id));
  std::stop_source stop;
  for (uint64_t id = 1; id <= 4; ++id)
    for (ClientId client = 1; client <= 64; ++client) {
      const std::optional<RequestJob> job = queue.take(stop.get_token());
      ASSERT_TRUE(job);
      EXPECT_EQ(job->client, client);
      EXPECT_EQ(job->request.id, id);
      queue.finished(client, 0);
    }
}

TEST(RequestQueue, WhoAsksMoreIsNotServedMore) {
  RequestQueue queue;
  for (ClientId client = 1; client <= 64; ++client) queue.join(client, client == 1 ? 16 : 1);
  std::map<ClientId, int> served;
  std::map<ClientId, uint64_t> lastId;
  std::stop_source stop;
  for (int turn = 0; turn < 64 * 20; ++turn) {
    for (ClientId client = 1; client <= 64; ++client)
      for (int times = 0; times < (client == 1 ? 20 : 1); ++times) put(queue, client, ++lastId[client]);
    const std::optional<RequestJob> job = queue.take(stop.get_token());
    ASSERT_TRUE(job);
    ++served[job->client];
    queue.finished(job->client, 0);
    queue.done(job->client, 0);
  }
  for (const auto& [client, count] : served) EXPECT_EQ(count, 20) << client;
  EXPECT_EQ(served.size(), 64u);
}

TEST(RequestQueue, TheNewestReplacesTheNewestThatWaits) {
  RequestQueue queue;
  queue.join(1, 2);
  for (uint64_t id = 1; id <= 1000; ++id) {
    ASSERT_TRUE(put(queue, 1, id));
    EXPECT_LE(queue.waitingCount(1), 2u);
  }
  EXPECT_EQ(takeNow(queue)->request.id, 1u);
  EXPECT_EQ(takeNow(queue)->request.id, 1000u);
  EXPECT_FALSE(takeNow(queue));
}

TEST(RequestQueue, NoMoreThanDepthAreGivenOut) {
  RequestQueue queue;
  queue.join(1, 2);
  for (uint64_t id = 1; id <= 4; ++id) {
    put(queue, 1, id);
    if (id <= 2) {
      ASSERT_TRUE(takeNow(queue));
    }
  }
  EXPECT_EQ(queue.waitingCount(1), 2u);
  EXPECT_FALSE(takeNow(queue)) << "two are at work";
  queue.done(1, 0);
  EXPECT_EQ(takeNow(queue)->request.id, 3u);
  EXPECT_FALSE(takeNow(queue));
  queue.done(1, 0);
  queue.done(1, 0);
  queue.done(1, 0);  // one too many does nothing
  EXPECT_EQ(takeNow(queue)->request.id, 4u);
}

TEST(RequestQueue, IdsThatDoNotGrowAreRefused) {
  RequestQueue queue;
  queue.join(1, 1);
  EXPECT_FALSE(put(queue, 1, 0));
  EXPECT_TRUE(put(queue, 1, 5));
  EXPECT_FALSE(put(queue, 1, 5));
  EXPECT_FALSE(put(queue, 1, 4));
  EXPECT_TRUE(put(queue, 1, 6));
  EXPECT_TRUE(put(queue, 1, ~uint64_t{0}));
  EXPECT_FALSE(put(queue, 1, ~uint64_t{0}));
  EXPECT_FALSE(put(queue, 1, 0));
  EXPECT_FALSE(put(queue, 2, 1)) << "nobody";
}

TEST(RequestQueue, OneOfAClientIsWorkedOnAtATime) {
  RequestQueue queue;
  queue.join(1, 4);
  queue.join(2, 4);
  for (const ClientId client : {1, 2})
    for (uint64_t id = 1; id <= 2; ++id) put(queue, client, id);
  std::stop_source stop;
  EXPECT_EQ(queue.take(stop.get_token())->client, 1u);
  EXPECT_EQ(queue.take(stop.get_token())->client, 2u);
  EXPECT_FALSE(takeNow(queue));
  queue.finished(2, 100);
  EXPECT_EQ(queue.take(stop.get_token())->client, 2u) << "its answer may wait";
}

TEST(RequestQueue, WhoReadsSlowlyGetsNoMore) {
  RequestQueue queue;
  queue.join(1, 16);
  for (uint64_t id = 1; id <= 4; ++id) put(queue, 1, id);
  std::stop_source stop;
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(queue.take(stop.get_token()));
    queue.finished(1, kMostWaitingBytes / 2);
  }
  EXPECT_FALSE(takeNow(queue)) << "as much waits as may";
  EXPECT_TRUE(queue.isAwaited(1));
  queue.done(1, kMostWaitingBytes / 2);
  EXPECT_TRUE(queue.take(stop.get_token()));
  queue.finished(1, 1);
}

TEST(RequestQueue, TellsWhoElseIsServed) {
  RequestQueue queue;
  for (const ClientId client : {1, 2, 3}) queue.join(client, 1);
  EXPECT_FALSE(queue.isAwaited(1));
  put(queue, 1, 1);
  put(queue, 2, 1);
  EXPECT_TRUE(queue.isAwaited(1));
  EXPECT_EQ(queue.othersAwaited(1), 1u);
  EXPECT_EQ(queue.othersAwaited(3), 2u);
  std::stop_source stop;
  ASSERT_EQ(queue.take(stop.get_token())->client, 1u);
  EXPECT_TRUE(queue.isAwaited(1)) << "it is being made";
  queue.finished(1, 10);
  EXPECT_FALSE(queue.isAwaited(1)) << "it is on its way";
  EXPECT_EQ(queue.othersAwaited(3), 1u);
}

TEST(RequestQueue, LeavingForgets) {
  RequestQueue queue;
  queue.join(1, 1);
  queue.join(2, 1);
  put(queue, 1, 1);
  ASSERT_EQ(takeNow(queue)->client, 1u);
  put(queue, 1, 2);
  put(queue, 2, 1);
  queue.leave(1);
  queue.leave(1);
  EXPECT_EQ(queue.clientCount(), 1u);
  EXPECT_EQ(queue.waitingCount(1), 0u);
  queue.done(1, 0);  // of what was at work
  EXPECT_EQ(takeNow(queue)->client, 2u);
  EXPECT_FALSE(takeNow(queue));
}

TEST(RequestQueue, AStopWakesWhoWaits) {
  RequestQueue queue;
  std::optional<RequestJob> job;
  std::jthread taker([&](const std::stop_token& stop) { job = queue.take(stop); });
  std::this_thread::sleep_for(20ms);  // it waits, most likely
  taker.request_stop();
  taker.join();
  EXPECT_FALSE(job);
}

TEST(RequestQueue, AfterAStopNothingIsGivenOut) {
  RequestQueue queue;
  queue.join(1, 1);
  put(queue, 1, 1);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(queue.take(stop.get_token()));
  EXPECT_EQ(queue.waitingCount(1), 1u);
}

TEST(RequestQueue, WhoStopsTakesNobodysTurn) {
  for (int round = 0; round < 200; ++round) {
    RequestQueue queue;
    queue.join(1, 1);
    std::atomic<int> taken = 0;
    std::jthread first([&](const std::stop_token& stop) { taken += queue.take(stop).has_value(); });
    std::jthread second([&](const std::stop_token& stop) { taken += queue.take(stop).has_value(); });
    std::jthread stopper([&] { first.request_stop(); });
    put(queue, 1, 1);
    stopper.join();
    first.join();
    while (taken == 0) std::this_thread::yield();
    ASSERT_EQ(taken, 1) << "round " << round;
  }
}

TEST(RequestQueue, ManyThreadsAtOnce) {
  RequestQueue queue;
  constexpr uint64_t kEach = 400;
  std::atomic<int> served = 0;
  std::vector<std::jthread> takers;
  for (int i = 0; i < 3; ++i)
    takers.emplace_back([&](const std::stop_token& stop) {
      while (const std::optional<RequestJob> job = queue.take(stop)) {
        ++served;
        queue.finished(job->client, 0);
        queue.done(job->client, 0);
      }
    });
  {
    std::vector<std::jthread> clients;
    for (ClientId client = 1; client <= 4; ++client)
      clients.emplace_back([&queue, client] {
        for (uint64_t id = 1; id <= kEach; ++id) {
          if (id % 50 == 1) queue.join(client, 2);
          EXPECT_TRUE(put(queue, client, id));
          EXPECT_LE(queue.waitingCount(client), 2u);
          if (id % 50 == 0) queue.leave(client);
        }
      });
  }
  EXPECT_EQ(queue.clientCount(), 0u);
  // On a busy machine all may have left before anybody was served.
  queue.join(9, 1);
  put(queue, 9, 1);
  while (served == 0) std::this_thread::sleep_for(1ms);
  for (std::jthread& taker : takers) taker.request_stop();
  takers.clear();
  EXPECT_GT(served, 0);
}

/// Each answer is the next question, so that a request whose taker was not woken, or was stopped when it was, would be missed for good.
TEST(RequestQueue, NoRequestIsForgottenWhereThreadsComeAndGo) {
  RequestQueue queue;
  constexpr ClientId kClients = 5;
  constexpr uint64_t kEach = 400;
  for (ClientId client = 1; client <= kClients; ++client) queue.join(client, 1);
  std::atomic<uint64_t> answered = 0;
  const auto serve = [&](const std::stop_token& stop) {
    while (const std::optional<RequestJob> job = queue.take(stop)) {
      queue.finished(job->client, 0);
      queue.done(job->client, 0);
      ++answered;
      if (job->request.id < kEach) EXPECT_TRUE(put(queue, job->client, job->request.id + 1));
    }
  };
  std::vector<std::jthread> lasting;
  for (int i = 0; i < 8; ++i) lasting.emplace_back(serve);
  std::jthread passing([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) std::jthread(serve).request_stop();
  });
  for (ClientId client = 1; client <= kClients; ++client) EXPECT_TRUE(put(queue, client, 1));
  for (int i = 0; i < 20'000 && answered < kClients * kEach; ++i) std::this_thread::sleep_for(1ms);
  EXPECT_EQ(answered, kClients * kEach);
  passing.request_stop();
  passing.join();
  for (std::jthread& taker : lasting) taker.request_stop();
}

TEST(RequestQueue, ARequestIsTakenByOneThread) {
  RequestQueue queue;
  queue.join(1, 1);
  std::atomic<int> taken = 0;
  std::vector<std::jthread> takers;
  for (int i = 0; i < 4; ++i)
    takers.emplace_back([&](const std::stop_token& stop) {
      if (queue.take(stop)) ++taken;
    });
  EXPECT_TRUE(put(queue, 1, 1));
  for (int i = 0; i < 10'000 && taken == 0; ++i) std::this_thread::sleep_for(1ms);
  EXPECT_EQ(taken, 1);
  for (std::jthread& taker : takers) taker.request_stop();
  takers.clear();
  EXPECT_EQ(taken, 1);
}

}  // namespace
}  // namespace warpscope::net

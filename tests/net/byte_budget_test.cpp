// What is handed out never exceeds the whole, the small never wait for the large, and who gives up leaves no trace.
// Mirrors net/byte_budget.h.
#include "net/byte_budget.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace warpscope::net {
namespace {

constexpr size_t kAll = 12800;
constexpr size_t kLarge = kAll / 16, kSmall = kAll / 128;

TEST(ByteBudget, GivesUntilNothingIsLeft) {
  ByteBudget budget(kAll);
  std::vector<ByteBudget::SharePtr> shares;
  for (int i = 0; i < 8; ++i) shares.push_back(budget.tryTake(kLarge));
  for (const auto& share : shares) EXPECT_TRUE(share);
  EXPECT_FALSE(budget.tryTake(kLarge)) << "half of it is for what is small";
  for (int i = 0; i < 64; ++i) shares.push_back(budget.tryTake(kSmall));
  EXPECT_EQ(budget.taken(), kAll);
  EXPECT_FALSE(budget.tryTake(1));
  shares.clear();
  EXPECT_EQ(budget.taken(), 0u);
}

TEST(ByteBudget, NobodyGetsMoreThanAPart) {
  ByteBudget budget(kAll);
  EXPECT_EQ(budget.largest(), kLarge);
  EXPECT_THROW(budget.tryTake(kLarge + 1), std::invalid_argument);
  EXPECT_EQ(budget.taken(), 0u);
}

TEST(ByteBudget, WhatShrinksMakesRoom) {
  ByteBudget budget(kAll);
  std::vector<ByteBudget::SharePtr> shares;
  for (int i = 0; i < 8; ++i) shares.push_back(budget.tryTake(kLarge));
  shares[0]->shrinkTo(10);
  shares[0]->shrinkTo(1000);  // does not grow
  EXPECT_EQ(shares[0]->bytes(), 10u);
  EXPECT_EQ(budget.taken(), 7 * kLarge + 10);
  EXPECT_TRUE(budget.tryTake(kLarge - 10));
}

TEST(ByteBudget, FirstComeFirstServed) {
  ByteBudget budget(kAll);
  std::vector<ByteBudget::SharePtr> shares;
  for (int i = 0; i < 8; ++i) shares.push_back(budget.tryTake(kLarge));
  std::atomic<int> order = 0;
  int first = 0, second = 0;
  std::jthread large([&] {
    const auto share = budget.take(kLarge, {});
    first = ++order;
  });
  while (!budget.isShort()) std::this_thread::yield();
  std::jthread lessLarge([&] {
    const auto share = budget.take(kSmall + 1, {});
    second = ++order;
  });
  shares[0]->shrinkTo(kLarge - kSmall - 1);
  EXPECT_FALSE(budget.tryTake(kSmall + 1)) << "there is room for it, but not for those before it";
  EXPECT_EQ(order, 0);
  shares[0].reset();  // room for one of them until it gives it back
  large.join();
  lessLarge.join();
  EXPECT_EQ(order, 2);
  EXPECT_LT(first, second);
}

TEST(ByteBudget, AStopEndsTheWait) {
  ByteBudget budget(kAll);
  std::vector<ByteBudget::SharePtr> shares;
  for (int i = 0; i < 8; ++i) shares.push_back(budget.tryTake(kLarge));
  std::jthread waiter([&](const std::stop_token& stop) { EXPECT_FALSE(budget.take(kLarge, stop)); });
  waiter.request_stop();
  waiter.join();
  shares.clear();
  EXPECT_TRUE(budget.tryTake(kLarge)) << "it left the row";
}

TEST(ByteBudget, ManyThreadsNeverTakeTooMuch) {
  ByteBudget budget(kAll);
  std::atomic<size_t> most = 0;
  {
    std::vector<std::jthread> threads;
    for (size_t i = 0; i < 8; ++i)
      threads.emplace_back([&, i] {
        for (size_t round = 0; round < 300; ++round) {
          const auto share = budget.take(1 + (i * 37 + round * 101) % kLarge, {});
          ASSERT_TRUE(share);
          const size_t taken = budget.taken();
          for (size_t seen = most; taken > seen && !most.compare_exchange_weak(seen, taken);) {
          }
          share->shrinkTo(share->bytes() / 2);
        }
      });
  }
  EXPECT_LE(most, kAll);
  EXPECT_EQ(budget.taken(), 0u);
}

}  // namespace
}  // namespace warpscope::net

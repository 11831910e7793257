// As many are made as are in use at once; what came back last goes out first; with the last holder all goes.
// Mirrors render/base/shared_pool.h.
#include "render/base/shared_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace warpscope {
namespace {

std::atomic<int> alive = 0, made = 0;

struct Counted {
  Counted() {
    ++alive;
    ++made;
  }
  ~Counted() { --alive; }
  int value = 0;
};

TEST(SharedPool, MakesAsManyAsAreInUseAtOnce) {
  made = 0;
  const auto pool = SharedPool<Counted>::ofProcess();
  for (int i = 0; i < 5; ++i) pool->take()->value = i;
  EXPECT_EQ(made, 1);
  {
    const auto first = pool->take(), second = pool->take();
    EXPECT_NE(&*first, &*second);
    EXPECT_EQ(first->value, 4) << "what came back last";
  }
  EXPECT_EQ(made, 2);
  EXPECT_EQ(SharedPool<Counted>::ofProcess(), pool) << "one for all";
  pool->forget();
  EXPECT_EQ(alive, 0);
  {
    const auto held = pool->take();
    pool->forget();
    EXPECT_EQ(alive, 1) << "what is in use stays";
  }
}

TEST(SharedPool, GoesWithTheLastWhoHoldsIt) {
  {
    const auto pool = SharedPool<Counted>::ofProcess();
    static_cast<void>(pool->take());
    EXPECT_EQ(alive, 1);
  }
  EXPECT_EQ(alive, 0);
  {
    auto pool = SharedPool<Counted>::ofProcess();
    const auto held = pool->take();
    pool.reset();
    EXPECT_EQ(alive, 1) << "a lease holds it, too";
  }
  EXPECT_EQ(alive, 0);
}

TEST(SharedPool, NoTwoThreadsHaveTheSame) {
  const auto pool = SharedPool<Counted>::ofProcess();
  made = 0;
  std::atomic<bool> isShared = false;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        for (int i = 0; i < 5000; ++i) {
          const auto held = pool->take();
          held->value = t;
          std::this_thread::yield();
          if (held->value != t) isShared = true;
        }
      });
  }
  EXPECT_FALSE(isShared);
  EXPECT_LE(made, 4);
}

}  // namespace
}  // namespace warpscope

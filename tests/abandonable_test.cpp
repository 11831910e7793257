// Work that ends, that ends when it is told to, and that never does.
// Mirrors render/base/abandonable.h.
#include "render/base/abandonable.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace warpscope {
namespace {

using std::chrono::steady_clock, std::chrono::milliseconds, std::chrono::seconds;

TEST(Abandonable, ReturnsAndThrowsWhatTheWorkDoes) {
  const std::stop_source source;
  EXPECT_EQ(abandonable([] { return 7; }, source.get_token()), 7);
  EXPECT_THROW(abandonable([]() -> int { throw InputError("no"); }, source.get_token()), InputError);
  EXPECT_EQ(abandonable([] { return 8; }, std::stop_token()), 8);
  EXPECT_FALSE(isAnythingAbandoned());
}

TEST(Abandonable, WhatLooksAtTheTokenLeavesNoThread) {
  std::stop_source source;
  std::jthread impatient([&] {
    std::this_thread::sleep_for(milliseconds(20));
    source.request_stop();
  });
  const auto work = [stop = source.get_token()] {
    while (!stop.stop_requested()) std::this_thread::sleep_for(milliseconds(1));
    throw OperationCancelled();
  };
  EXPECT_THROW(abandonable(work, source.get_token()), OperationCancelled);
  EXPECT_FALSE(isAnythingAbandoned());
}

TEST(Abandonable, WhatNeverEndsIsLeftAloneSoon) {
  std::stop_source source;
  const auto goesOn = std::make_shared<std::atomic<bool>>(true);
  source.request_stop();
  const auto start = steady_clock::now();
  const auto work = [goesOn] {
    while (*goesOn) std::this_thread::sleep_for(milliseconds(1));
  };
  EXPECT_THROW(abandonable(work, source.get_token()), OperationCancelled);
  EXPECT_LT(steady_clock::now() - start, seconds(2));
  EXPECT_TRUE(isAnythingAbandoned());
  *goesOn = false;
  for (const auto end = steady_clock::now() + seconds(20); isAnythingAbandoned() && steady_clock::now() < end;) std::this_thread::sleep_for(milliseconds(1));
  EXPECT_FALSE(isAnythingAbandoned());
}

}  // namespace
}  // namespace warpscope

// Waiting for what another thread will have made.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <thread>

namespace warpscope {

/// What `take()` gives as soon as it gives something; a failure, and an empty one, if that takes a minute.
template <class Take>
auto waitFor(const Take& take) {
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  auto taken = take();
  for (; !taken && std::chrono::steady_clock::now() < limit; taken = take()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_TRUE(taken) << "it never came";
  using Taken = typename decltype(taken)::value_type;
  return taken ? std::move(*taken) : Taken{};
}

}  // namespace warpscope

// How long work took, for figures that are shown. What waits or simulates time takes render/base/clock.h instead.
// std::chrono::steady_clock.
#pragma once

#include <chrono>

namespace warpscope {

inline double millisecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// Milliseconds that calling `work` takes.
template <class Work>
double milliseconds(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return millisecondsSince(start);
}

}  // namespace warpscope

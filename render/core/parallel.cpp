// oneTBB's parallel_for over ranges, or a crew's threads that take one piece after the other.
// See parallel.h.
#include "render/core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <chrono>

#include "render/base/error.h"
#include "render/core/crew.h"
#include "render/core/turns.h"

namespace warpscope {

void parallelForRanges(size_t count, size_t grain, RangeBody body) {
  if (Crew* const crew = Crew::ofThisThread()) {
    std::atomic<size_t> next = 0;
    crew->run([&] {
      for (size_t begin; (begin = next.fetch_add(grain, std::memory_order_relaxed)) < count;) {
        Crew::pauseForBreaks();
        body(begin, std::min(begin + grain, count));
      }
    });
    return;
  }
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, grain),
                    [&](const tbb::blocked_range<size_t>& range) { body(range.begin(), range.end()); });
}

void parallelForRanges(size_t count, size_t grain, const std::stop_token& stop, RangeBody body) {
  parallelForRanges(count, grain, [&](size_t begin, size_t end) {
    for (size_t at = begin; at < end && !stop.stop_requested(); at += grain) body(at, std::min(at + grain, end));
  });
  if (stop.stop_requested()) throw OperationCancelled();
}

void parallelForInTurns(size_t count, TurnsOfJob& turns, const std::stop_token& stop, FunctionRef<void(size_t)> body) {
  std::atomic<size_t> next = 0;
  const auto workUntil = [&](std::chrono::steady_clock::time_point end) {
    const Crew* const crew = Crew::ofThisThread();
    parallelForRanges(crew ? crew->size() : Crew::usualSize(), 1, [&](size_t, size_t) {
      while (!stop.stop_requested() && std::chrono::steady_clock::now() < end) {
        const size_t i = next.fetch_add(1, std::memory_order_relaxed);
        if (i >= count) return;
        if (crew != nullptr) Crew::pauseForBreaks();
        body(i);
      }
    });
    return next.load() >= count;
  };
  const auto done = [&] { return static_cast<double>(next.load()) / static_cast<double>(count); };
  while (!turns.work(stop, workUntil, done)) {
  }
  if (stop.stop_requested()) throw OperationCancelled();
}

void parallelForTiles(uint32_t width, uint32_t height, uint32_t side, const std::stop_token& stop, TurnsOfJob& turns, TileBody body) {
  const size_t columns = (width + side - 1) / side;
  const size_t rows = (height + side - 1) / side;
  const auto onTile = [&](size_t tile) {
    const auto x0 = static_cast<uint32_t>(tile % columns) * side;
    const auto y0 = static_cast<uint32_t>(tile / columns) * side;
    body(x0, y0, x0 + side < width ? x0 + side : width, y0 + side < height ? y0 + side : height);
  };
  if (turns.areLimited()) {
    parallelForInTurns(columns * rows, turns, stop, onTile);
    return;
  }
  parallelForRanges(columns * rows, 1, stop, [&](size_t begin, size_t end) {
    for (size_t tile = begin; tile < end; ++tile) onTile(tile);
  });
}

void parallelForTiles(uint32_t width, uint32_t height, uint32_t side, const std::stop_token& stop, TileBody body) {
  TurnsOfJob unlimited(nullptr);
  parallelForTiles(width, height, side, stop, unlimited, body);
}

}  // namespace warpscope

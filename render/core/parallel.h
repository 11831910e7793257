// Loops over ranges on all cores, by oneTBB. The one place that says how work is cut.
// Whoever works with a Crew has its loops run on that one's threads instead; see crew.h.
// Cancelling: a stop token is looked at before every piece; see OperationCancelled.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <stop_token>

#include "render/base/error.h"
#include "render/core/crew.h"
#include "render/core/turns.h"

namespace warpscope {

/// Calls body(begin, end) on pieces of [0, count) of about `grain` items, in parallel.
template <class Body>
void parallelForRanges(size_t count, size_t grain, const Body& body) {
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

/// The same, with a look at `stop` before each piece, none longer than `grain`. Throws OperationCancelled if it is set.
template <class Body>
void parallelForRanges(size_t count, size_t grain, const std::stop_token& stop, const Body& body) {
  parallelForRanges(count, grain, [&](size_t begin, size_t end) {
    for (size_t at = begin; at < end && !stop.stop_requested(); at += grain) body(at, at + grain < end ? at + grain : end);
  });
  if (stop.stop_requested()) throw OperationCancelled();
}

/// Calls body(i) for every i below `count`, in parallel, in turns with other jobs. Throws as TurnsOfJob::work does.
template <class Body>
void parallelForInTurns(size_t count, TurnsOfJob& turns, const std::stop_token& stop, const Body& body) {
  std::atomic<size_t> next = 0;
  const auto workUntil = [&](std::chrono::steady_clock::time_point end) {
    const Crew* const crew = Crew::ofThisThread();
    const size_t lanes = crew ? crew->size() : static_cast<size_t>(std::max(1, tbb::this_task_arena::max_concurrency()));
    parallelForRanges(lanes, 1, [&](size_t, size_t) {
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

/// Calls body(x0, y0, x1, y1) for tiles of at most `side` pixels that cover width x height, in turns where there are any. Throws
/// OperationCancelled if `stop` is set, and as TurnsOfJob::work does.
template <class Body>
void parallelForTiles(uint32_t width, uint32_t height, uint32_t side, const std::stop_token& stop, TurnsOfJob& turns, const Body& body) {
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
template <class Body>
void parallelForTiles(uint32_t width, uint32_t height, uint32_t side, const std::stop_token& stop, const Body& body) {
  TurnsOfJob unlimited(nullptr);
  parallelForTiles(width, height, side, stop, unlimited, body);
}

}  // namespace warpscope

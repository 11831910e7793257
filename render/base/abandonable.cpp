// A thread, and who waits for it.
// See abandonable.h.
#include "render/base/abandonable.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

namespace warpscope {
namespace {

/// What looks at the token itself ends within this, and leaves no thread behind.
constexpr std::chrono::milliseconds kGrace(300);

std::atomic<int> abandonedCount = 0;

struct Shared {
  std::mutex mutex;
  std::condition_variable_any changed;
  bool isDone = false, isAbandoned = false;
};

}  // namespace

bool runAbandonable(std::function<void()> work, const std::stop_token& stop) {
  const auto shared = std::make_shared<Shared>();
  std::thread([shared, work = std::move(work)]() mutable {
    work();
    work = nullptr;  // what it holds goes before anybody hears that it is done
    const std::scoped_lock lock(shared->mutex);
    shared->isDone = true;
    if (shared->isAbandoned) --abandonedCount;
    shared->changed.notify_all();
  }).detach();
  std::unique_lock lock(shared->mutex);
  const auto isDone = [&] { return shared->isDone; };
  if (shared->changed.wait(lock, stop, isDone) || shared->changed.wait_for(lock, kGrace, isDone)) return true;
  shared->isAbandoned = true;
  ++abandonedCount;
  return false;
}

void noteLeftAlone() { ++abandonedCount; }

bool isAnythingAbandoned() { return abandonedCount > 0; }

}  // namespace warpscope

// Two counters.
// See looked_through.h.
#include "render/base/looked_through.h"

#include <atomic>

namespace warpscope {
namespace {

std::atomic<uint64_t> wanted = 0, done = 0;

}  // namespace

LookedThrough lookedThrough() {
  const uint64_t doneNow = done;  // first: so that it is no more than what is wanted
  return {wanted, doneNow};
}

void beginLooking(uint64_t bytes) { wanted += bytes; }

void noteLooked(uint64_t bytes) { done += bytes; }

}  // namespace warpscope

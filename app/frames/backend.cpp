// Choosing the hardware.
// See backend.h.
#include "app/frames/backend.h"

#include <cstdio>
#include <mutex>
#include <set>

#include "render/march/marcher_registry.h"

namespace warpscope {

MarcherPtr makeMarcher(Backend backend, VolumePtr volume, TransferFunction transferFunction) {
  return makeMarcher(backend, std::move(volume), std::move(transferFunction), reportFallback);
}

void reportFallback(const std::string& reason) {
  static std::mutex mutex;
  static std::set<std::string> reported;
  const std::scoped_lock lock(mutex);
  if (reported.insert(reason).second) std::fprintf(stderr, "warpscope: the GPU failed (%s); going on with the CPU\n", reason.c_str());
}

}  // namespace warpscope

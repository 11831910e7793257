// Choosing the hardware.
// See backend.h.
#include "app/frames/backend.h"

#include <cstdio>
#include <mutex>
#include <set>

#include "render/base/error.h"
#include "render/cuda/devices.h"
#include "render/march/fallback_marcher.h"
#include "render/march/marcher_cpu.h"
#include "render/march/marcher_cuda.h"

namespace warpscope {

MarcherPtr makeMarcher(Backend backend, VolumePtr volume, TransferFunction transferFunction) {
  if (backend == Backend::cpu) return makeCpuMarcher(std::move(volume), std::move(transferFunction));
  const std::string reason = cuda::whyUnavailable();
  if (backend == Backend::cuda) {
    if (!reason.empty()) throw DeviceError("the backend cuda cannot be used: " + reason);
    return makeCudaMarcher(std::move(volume), std::move(transferFunction));
  }
  if (!reason.empty()) return makeCpuMarcher(std::move(volume), std::move(transferFunction));
  return makeFallbackMarcher([volume, transferFunction] { return makeCudaMarcher(volume, transferFunction); },
                             [volume, transferFunction] { return makeCpuMarcher(volume, transferFunction); }, reportFallback);
}

void reportFallback(const std::string& reason) {
  static std::mutex mutex;
  static std::set<std::string> reported;
  const std::scoped_lock lock(mutex);
  if (reported.insert(reason).second) std::fprintf(stderr, "warpscope: the GPU failed (%s); going on with the CPU\n", reason.c_str());
}

}  // namespace warpscope

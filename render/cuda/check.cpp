// What a failed CUDA call is called.
// See check.h.
#include "render/cuda/check.h"

#include <string>
#include <string_view>

namespace warpscope::cuda {

void check(cudaError_t result, const char* expression, const char* file, int line) {
  if (result == cudaSuccess) return;
  cudaGetLastError();  // reported here; it must not surface in a later call
  std::string_view name(file);
  if (const size_t root = name.rfind("render/"); root != std::string_view::npos) name.remove_prefix(root);
  std::string what = std::string("CUDA: ") + cudaGetErrorString(result);
  if (result == cudaErrorInsufficientDriver) what += "; a newer driver is needed";
  if (result == cudaErrorMemoryAllocation) {
    size_t freeBytes = 0, totalBytes = 0;
    if (cudaMemGetInfo(&freeBytes, &totalBytes) == cudaSuccess)
      what += "; " + std::to_string(freeBytes >> 20) + " of the device's " + std::to_string(totalBytes >> 20) + " MiB are free";
  }
  throw DeviceError(what + " (" + expression + ", " + std::string(name) + ":" + std::to_string(line) + ")");
}

}  // namespace warpscope::cuda

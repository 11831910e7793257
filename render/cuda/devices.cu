// The CUDA devices that the driver offers.
// See devices.h.
#include "render/cuda/devices.h"

#include <cuda_runtime.h>

namespace warpscope::cuda {

DeviceReport listDevices() {
  DeviceReport report;
  int count = 0;
  const cudaError_t counted = cudaGetDeviceCount(&count);
  if (counted != cudaSuccess || count == 0) {
    report.reason = std::string("no CUDA device: ") + cudaGetErrorString(counted == cudaSuccess ? cudaErrorNoDevice : counted);
    cudaGetLastError();  // the failure is reported; it must not surface in a later call
    return report;
  }
  for (int i = 0; i < count; ++i) {
    cudaDeviceProp properties{};
    const cudaError_t read = cudaGetDeviceProperties(&properties, i);
    if (read != cudaSuccess) {
      report.reason = std::string("a CUDA device cannot be asked: ") + cudaGetErrorString(read);
      cudaGetLastError();
      continue;
    }
    report.devices.push_back({properties.name, properties.major, properties.minor, properties.totalGlobalMem});
  }
  if (!report.devices.empty()) report.reason.clear();
  return report;
}

}  // namespace warpscope::cuda

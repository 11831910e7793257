// The CUDA devices that the driver offers.
// See devices.h.
#include "render/cuda/devices.h"

#include <cuda_runtime.h>

namespace warpscope::cuda {

DeviceReport listDevices() {
  DeviceReport report;
  // Without a driver the runtime says that the driver is too old, which sends its reader the wrong way.
  int version = 0;
  if (cudaDriverGetVersion(&version) == cudaSuccess && version == 0) {
    report.reason = "no CUDA device: no NVIDIA driver is installed";
    return report;
  }
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
    int clockKHz = 0;
    cudaDeviceGetAttribute(&clockKHz, cudaDevAttrClockRate, i);  // stays 0 where it is not told
    report.devices.push_back({properties.name, properties.major, properties.minor, properties.totalGlobalMem, clockKHz / 1000});
  }
  if (!report.devices.empty()) report.reason.clear();
  if (version > 0)
    report.driverVersion = std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
  return report;
}

std::string whyUnavailable() {
  const DeviceReport report = listDevices();
  if (report.devices.empty()) return report.reason;
  const Device& first = report.devices.front();
  if (first.computeMajor > kLeastComputeMajor || (first.computeMajor == kLeastComputeMajor && first.computeMinor >= kLeastComputeMinor))
    return {};
  return first.name + " has compute capability " + std::to_string(first.computeMajor) + "." + std::to_string(first.computeMinor) +
         ", but " + std::to_string(kLeastComputeMajor) + "." + std::to_string(kLeastComputeMinor) + " is needed";
}

}  // namespace warpscope::cuda

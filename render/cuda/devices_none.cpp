// The report of a build without CUDA.
// See devices.h.
#include "render/cuda/devices.h"

namespace warpscope::cuda {

DeviceReport listDevices() {
  DeviceReport report;
  report.reason = "this build has no CUDA: nvcc was not found when it was configured";
  return report;
}

std::string whyUnavailable() { return listDevices().reason; }

}  // namespace warpscope::cuda

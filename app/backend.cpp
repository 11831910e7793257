// Choosing the hardware.
// See backend.h.
#include "app/backend.h"

#include "render/core/error.h"
#include "render/cuda/devices.h"
#include "render/march/marcher_cpu.h"

namespace warpscope {

std::string whyNoCuda() {
  const cuda::DeviceReport report = cuda::listDevices();
  if (!report.reason.empty()) return report.reason;
  return "this version marches and warps on the CPU only";
}

MarcherPtr makeMarcher(Backend backend, VolumePtr volume, TransferFunction transferFunction) {
  if (backend == Backend::cuda) throw InputError("the backend cuda cannot be used: " + whyNoCuda());
  return makeCpuMarcher(std::move(volume), std::move(transferFunction));
}

}  // namespace warpscope

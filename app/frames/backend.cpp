// Choosing the hardware.
// See backend.h.
#include "app/frames/backend.h"

#include <mutex>
#include <set>
#include <thread>

#include "app/frames/process_ranks.h"
#include "app/shell/log.h"
#include "render/base/error.h"
#include "render/codec/tiled/tiled_coder_cuda.h"
#include "render/cuda/devices.h"
#include "render/march/marcher_registry.h"
#include "render/march/piece_marcher_cuda.h"

namespace warpscope {

MarcherPtr makeMarcher(Backend backend, VolumePtr volume, TransferFunction transferFunction) {
  if (volume->ranks()) return makeRanksMarcher(leaderOf(volume, backend), std::move(transferFunction));
  return makeMarcher(backend, std::move(volume), std::move(transferFunction), reportFallback);
}

PieceMaker makePieces(Backend backend) {
  if (marchersFor(backend).front()->backend == Backend::cpu) return {};
  const bool mayFallBack = backend == Backend::automatic;
  try {
    return makeCudaPieces(mayFallBack, reportFallback);
  } catch (const DeviceError& error) {
    if (!mayFallBack) throw;
    reportFallback(error.what());
    return {};
  }
}

TiledCoderPtr makeTiledCoder(Backend backend) {
  if (backend == Backend::cpu || !cuda::whyUnavailable().empty()) return makeHostTiledCoder();
  return makeFallbackTiledCoder(makeCudaTiledCoder, reportFallback);
}

void reportFallback(const std::string& reason) {
  static std::mutex mutex;
  static std::set<std::string> reported;
  const std::scoped_lock lock(mutex);
  if (reported.insert(reason).second) printLine("warpscope: the GPU failed (" + reason + "); going on with the CPU");
}

std::string deviceText(Backend backend) {
  if (backend == Backend::cpu) return std::to_string(std::thread::hardware_concurrency()) + " CPU threads";
  const cuda::DeviceReport report = cuda::listDevices();
  if (report.devices.empty()) return "no device";
  const cuda::Device& device = report.devices.front();
  return device.name + ", CUDA driver " + report.driverVersion + ", " + std::to_string(device.clockMHz) + " MHz";
}

}  // namespace warpscope

// The device's side of cells_probe.h.
// Uploads what a marcher keeps on the device.
#include "tests/gpu/cells_probe.h"

#include "render/march/device_cells.h"
#include "render/march/device_octants.h"

namespace warpscope {

namespace {

/// What a table shows, in device memory.
class DeviceBins {
 public:
  DeviceBins(const TransferTable& table, cudaStream_t stream) : bins_{table.lookup(), nullptr} {
    alphas_.upload(table.alphas, stream);
    begins_.upload(table.begins, stream);
    refinements_.upload(table.refinements, stream);
    next_.upload(nextVisibleBins(table), stream);
    WARPSCOPE_CUDA_CHECK(cudaStreamSynchronize(stream));  // the list goes
    bins_.next = next_.data();
    bins_.table.entries = nullptr;
    bins_.table.unitAlphas = nullptr;
    bins_.table.alphas = alphas_.data();
    bins_.table.begins = begins_.data();
    bins_.table.refinements = refinements_.data();
  }
  const VisibleBins& bins() const { return bins_; }

 private:
  cuda::DeviceBuffer<float> alphas_, begins_;
  cuda::DeviceBuffer<TransferRefinement> refinements_;
  cuda::DeviceBuffer<int32_t> next_;
  VisibleBins bins_;
};

}  // namespace

std::vector<uint8_t> emptyDistancesOnDevice(const Macrocells& cells, const TransferTable& table) {
  const cuda::Stream stream;
  const DeviceBins bins(table, stream);
  const DeviceCells deviceCells(cells);
  cuda::DeviceBuffer<uint8_t> distances, scratch;
  deviceCells.findDistances(bins.bins(), distances, scratch, stream);
  return distances.download(deviceCells.count(), stream);
}

OctantMaps octantsOnDevice(const Volume& volume, const ValueScale& scale, const TransferTable& table) {
  const cuda::Stream stream;
  const DeviceBins bins(table, stream);
  const DeviceVolume deviceVolume(volume, scale);
  const DeviceOctants octants(deviceVolume, scale);
  cuda::DeviceBuffer<uint8_t> distances, scratch;
  octants.findDistances(bins.bins(), distances, scratch, stream);
  return {octants.dims(), octants.edge(), deviceVolume.isInCells(), distances.download(8 * octants.count(), stream)};
}

}  // namespace warpscope

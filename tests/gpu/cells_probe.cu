// The device's side of cells_probe.h.
// Uploads what a marcher keeps on the device.
#include "tests/gpu/cells_probe.h"

#include "render/march/device_cells.h"

namespace warpscope {

std::vector<uint8_t> emptyDistancesOnDevice(const Macrocells& cells, const TransferTable& table) {
  const cuda::Stream stream;
  cuda::DeviceBuffer<float> alphas, begins;
  cuda::DeviceBuffer<TransferRefinement> refinements;
  cuda::DeviceBuffer<int32_t> next;
  alphas.upload(table.alphas, stream);
  begins.upload(table.begins, stream);
  refinements.upload(table.refinements, stream);
  next.upload(nextVisibleBins(table), stream);
  VisibleBins bins{table.lookup(), next.data()};
  bins.table.entries = nullptr;
  bins.table.unitAlphas = nullptr;
  bins.table.alphas = alphas.data();
  bins.table.begins = begins.data();
  bins.table.refinements = refinements.data();
  const DeviceCells deviceCells(cells);
  cuda::DeviceBuffer<uint8_t> distances, scratch;
  deviceCells.findDistances(bins, distances, scratch, stream);
  return distances.download(deviceCells.count(), stream);
}

}  // namespace warpscope

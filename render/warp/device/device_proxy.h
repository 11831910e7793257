// The copy of the volume that comes with frames, in device memory. For .cu files.
// See proxy_fill.h.
#pragma once

#include <memory>

#include "render/cuda/memory.h"
#include "render/march/march_setup.h"
#include "render/march/proxy_march.h"
#include "render/volume/proxy.h"

namespace warpscope {

/// The copy of the volume, and how its values look, in device memory.
class DeviceProxy {
 public:
  /// Calls f(march) with `march`, which ProxyFill gave, by pointers to copies of what it points to.
  template <class March, class F>
  void visit(const ProxyPtr& proxy, March march, const std::shared_ptr<const BakedTransfer>& baked, cudaStream_t stream, const F& f) {
    if (proxy != proxy_) voxels_.upload({proxy->volume->voxelsAs<uint8_t>(), proxy->volume->voxelCount()}, stream);
    proxy_ = proxy;
    if (baked != baked_) {
      entries_.upload(baked->table.entries, stream);
      alphas_.upload(baked->table.alphas, stream);
      unitAlphas_.upload(baked->table.unitAlphas, stream);
      refinements_.upload(baked->table.refinements, stream);
      begins_.upload(baked->table.begins, stream);
      distances_.upload(baked->emptyDistances, stream);
      baked_ = baked;
    }
    march.view.voxels = voxels_.data();
    march.view.transfer.entries = entries_.data();
    march.view.transfer.alphas = alphas_.data();
    march.view.transfer.unitAlphas = unitAlphas_.data();
    march.view.transfer.refinements = refinements_.data();
    march.view.transfer.begins = begins_.data();
    march.view.cells.distances = distances_.data();
    f(march);
  }

 private:
  ProxyPtr proxy_;                              // whose voxels these are
  std::shared_ptr<const BakedTransfer> baked_;  // that the others are of
  cuda::DeviceBuffer<uint8_t> voxels_, distances_;
  cuda::DeviceBuffer<glm::vec4> entries_;
  cuda::DeviceBuffer<float> alphas_, unitAlphas_, begins_;
  cuda::DeviceBuffer<TransferRefinement> refinements_;
};

}  // namespace warpscope

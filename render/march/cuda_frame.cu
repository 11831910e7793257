// See cuda_frame.h.
#include "render/march/cuda_frame.h"

#include <algorithm>

#include "render/cuda/pinned_memory.h"
#include "render/march/compact.h"

namespace warpscope {
namespace {

/// In stream order; the vector has its size at once.
template <class T, class Held>
void fetch(TransferVector<T>& to, const cuda::DeviceBuffer<Held>& from, size_t count, cudaStream_t stream) {
  to = TransferVector<T>(TransferAllocator<T>(cuda::pinnedMemory()));
  to.resize(count * sizeof(Held) / sizeof(T));
  if (count > 0) WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(to.data(), from.data(), count * sizeof(Held), cudaMemcpyDeviceToHost, stream));
}

}  // namespace

void CudaFrame::copyTo(SampleFrame& frame) const {
  cuda::Event copied;
  copyTo(frame, memory_->stream, copied);
}

void CudaFrame::copyTo(SampleFrame& frame, cudaStream_t stream, cuda::Event& copied) const {
  CudaFrameBuffers& from = buffers();
  TransferVector<std::byte> layers, spreads;
  const cuda::Settled settled(stream);
  fetch(frame.samples, from.samples, sizes_.samples, stream);
  fetch(frame.colors, from.colors, sizes_.samples, stream);
  frame.segments = {};
  if (sizes_.rays > 0) {
    fetch(frame.segments.rays, from.rays, sizes_.rays, stream);
    fetch(frame.segments.depths, from.depths, sizes_.segments, stream);
    fetch(frame.segments.colors, from.segmentColors, sizes_.segments, stream);
    if (sizes_.hasNormals) fetch(frame.segments.normals, from.normals, sizes_.segments, stream);
  }
  if (sizes_.hasLayers) fetch(layers, from.layers, sizes_.samples, stream);
  if (sizes_.hasSpreads) fetch(spreads, from.spreads, sizes_.samples, stream);
  copied.record(stream);
  copied.synchronize();
  const auto plane = std::ranges::find(frame.planes, kLayerPlane, &SamplePlane::name);
  if (plane != frame.planes.end())
    plane->values = std::move(layers);  // whose head said that there is one, whatever is in it
  else
    setLayers(std::move(layers), frame);
  if (sizes_.hasSpreads) setSpreads(std::move(spreads), frame);
}

}  // namespace warpscope

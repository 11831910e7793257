// The device's side of core_probe.h.
// One thread an input.
#include "tests/gpu/core_probe.h"

#include "render/cuda/check.h"

namespace warpscope {
namespace {

__global__ void probe(const CoreProbeInput* inputs, CoreProbeResult* results, size_t count) {
  const size_t i = size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (i < count) results[i] = probeCore(inputs[i]);
}

}  // namespace

std::vector<CoreProbeResult> probeCoreOnDevice(const std::vector<CoreProbeInput>& inputs) {
  constexpr unsigned kThreads = 128;
  cuda::DeviceBuffer<CoreProbeInput> in(inputs);
  cuda::DeviceBuffer<CoreProbeResult> out(inputs.size());
  // The kernel leaves the gaps between members alone, and reading them back counts as reading what nobody wrote.
  WARPSCOPE_CUDA_CHECK(cudaMemset(out.data(), 0, out.size() * sizeof(CoreProbeResult)));
  probe<<<static_cast<unsigned>((inputs.size() + kThreads - 1) / kThreads), kThreads>>>(in.data(), out.data(), inputs.size());
  WARPSCOPE_CUDA_CHECK(cudaGetLastError());
  WARPSCOPE_CUDA_CHECK(cudaDeviceSynchronize());
  return out.toHost();
}

}  // namespace warpscope

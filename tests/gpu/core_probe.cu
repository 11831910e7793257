// The device's side of core_probe.h.
// One thread an input.
#include "tests/gpu/core_probe.h"

#include "render/cuda/memory.h"

namespace warpscope {
namespace {

__global__ void probe(const CoreProbeInput* inputs, CoreProbeResult* results, size_t count) {
  const size_t i = size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (i < count) results[i] = probeCore(inputs[i]);
}

__global__ void fail() { __trap(); }

}  // namespace

std::string loseDevice() {
  fail<<<1, 1>>>();
  const cudaError_t result = cudaDeviceSynchronize();
  return result == cudaSuccess ? "" : cudaGetErrorString(result);
}

std::vector<CoreProbeResult> probeCoreOnDevice(const std::vector<CoreProbeInput>& inputs) {
  constexpr unsigned kThreads = 128;
  const cuda::Stream stream;
  cuda::DeviceBuffer<CoreProbeInput> in;
  in.upload(inputs, stream);
  cuda::DeviceBuffer<CoreProbeResult> out(inputs.size());
  // The kernel leaves the gaps between members alone, and reading them back counts as reading what nobody wrote.
  WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(out.data(), 0, inputs.size() * sizeof(CoreProbeResult), stream));
  probe<<<cuda::blocksFor(inputs.size(), kThreads), kThreads, 0, stream>>>(in.data(), out.data(), inputs.size());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  return out.download(inputs.size(), stream);
}

}  // namespace warpscope

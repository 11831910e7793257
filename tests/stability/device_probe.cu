// The device's side of device_probe.h.
// One thread an input.
#include "tests/stability/device_probe.h"

#include "render/cuda/memory.h"
#include "tests/stability/probes.h"

namespace warpscope {
namespace {

template <class Probe>
__global__ void probe(const typename Probe::Input* inputs, typename Probe::Output* outputs, size_t count) {
  const size_t i = size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (i < count) outputs[i] = Probe::evaluate(inputs[i]);
}

}  // namespace

template <class Probe>
std::vector<typename Probe::Output> evaluateOnDevice(const std::vector<typename Probe::Input>& inputs) {
  if (inputs.empty()) return {};
  constexpr unsigned kThreads = 128;
  const cuda::Stream stream;
  cuda::DeviceBuffer<typename Probe::Input> in;
  in.upload(inputs, stream);
  cuda::DeviceBuffer<typename Probe::Output> out(inputs.size());
  // The kernel leaves the gaps between members alone, and reading them back counts as reading what nobody wrote.
  WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(out.data(), 0, inputs.size() * sizeof(typename Probe::Output), stream));
  probe<Probe><<<cuda::blocksFor(inputs.size(), kThreads), kThreads, 0, stream>>>(in.data(), out.data(), inputs.size());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  return out.download(inputs.size(), stream);
}

#define WARPSCOPE_PROBE(Probe) \
  template std::vector<Probe::Output> evaluateOnDevice<Probe>(const std::vector<Probe::Input>&);
WARPSCOPE_FOR_EACH_PROBE(WARPSCOPE_PROBE)

}  // namespace warpscope

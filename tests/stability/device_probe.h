// Evaluates a function over an array of inputs: on the CPU in a loop, on a CUDA device in a kernel, a thread an input.
// A probe is a struct with an Input, an Output and a WARPSCOPE_HD evaluate(); those that exist are in probes.h.
#pragma once

#include <stdexcept>
#include <vector>

#include "render/core/backend.h"

namespace warpscope {

/// In device_probe.cu, for the probes that it lists. Throws DeviceError.
template <class Probe>
std::vector<typename Probe::Output> evaluateOnDevice(const std::vector<typename Probe::Input>& inputs);

/// On `backend`, cpu or cuda.
template <class Probe>
std::vector<typename Probe::Output> evaluate(Backend backend, const std::vector<typename Probe::Input>& inputs) {
#if WARPSCOPE_STABILITY_CUDA
  if (backend == Backend::cuda) return evaluateOnDevice<Probe>(inputs);
#else
  if (backend == Backend::cuda) throw std::logic_error("CUDA is not in this build: its tests are skipped");
#endif
  std::vector<typename Probe::Output> outputs;
  outputs.reserve(inputs.size());
  for (const auto& input : inputs) outputs.push_back(Probe::evaluate(input));
  return outputs;
}

/// One input.
template <class Probe>
typename Probe::Output evaluate(Backend backend, const typename Probe::Input& input) {
  return evaluate<Probe>(backend, std::vector<typename Probe::Input>{input}).front();
}

}  // namespace warpscope

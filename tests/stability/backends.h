// Tests of what exists on the CPU and on a CUDA device: once on each, on the device skipped, visibly, where there is none.
// Marchers and techniques by backend; functions by device_probe.h.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "render/cuda/devices.h"
#include "render/march/marcher_cpu.h"
#include "render/march/marcher_cuda.h"
#include "render/warp/warp.h"

namespace warpscope {

class OnBackend : public testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    if (GetParam() != Backend::cuda) return;
    if (const std::string reason = cuda::whyUnavailable(); !reason.empty()) GTEST_SKIP() << "no GPU here: " << reason;
  }
};

/// Declares the suite of a case whose tests (TEST_P) run on both.
#define WARPSCOPE_CASE_ON_BACKENDS(Suite)                                                                   \
  class Suite : public OnBackend {};                                                                        \
  INSTANTIATE_TEST_SUITE_P(On, Suite, testing::Values(Backend::cpu, Backend::cuda),                         \
                           [](const testing::TestParamInfo<Backend>& info) { return std::string(nameOf(info.param)); })

inline MarcherPtr marcherOn(Backend backend, VolumePtr volume, TransferFunction function) {
  return backend == Backend::cuda ? makeCudaMarcher(std::move(volume), std::move(function))
                                  : makeCpuMarcher(std::move(volume), std::move(function));
}

/// A technique that needs no OpenGL.
inline std::unique_ptr<Warp> techniqueOn(Backend backend, std::string_view name) {
  WarpResources resources;
  resources.backend = backend;
  return makeWarp(findWarp(name), resources);
}

}  // namespace warpscope

// Tests of what exists on the CPU and on a CUDA device: once on each, on the device skipped, visibly, where there is
// none. Marchers and techniques by backend; functions by device_probe.h.
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

/// The suites of cases whose tests (TEST_P) run on both; cases.cpp instantiates them. A case may have tests in several
/// files.
#define WARPSCOPE_FOR_EACH_CASE_ON_BACKENDS(USE)                                                                      \
  USE(Case01)                                                                                                         \
  USE(Case02) USE(Case03) USE(Case04) USE(Case05) USE(Case06) USE(Case08) USE(Case09) USE(Case10) USE(Case11)         \
      USE(Case12) USE(Case13) USE(Case14) USE(Case15) USE(Case16) USE(Case17) USE(Case18) USE(Case19) USE(Case20)     \
          USE(Case21) USE(Case22) USE(Case23) USE(Case25) USE(Case26) USE(Case27) USE(Case28) USE(Case29) \
              USE(Case30) USE(Case31) USE(Case32) USE(Case33) USE(Case34) USE(Case35) USE(Case36) USE(Case37)         \
                  USE(Case38) USE(Case39) USE(Case40) USE(Case41) USE(Case42) USE(Case43) USE(Case44) USE(Case45)     \
                      USE(Case46) USE(Case47) USE(Case49) USE(Case50) USE(Case51) USE(Case52) USE(Case53) USE(Case54) \
                          USE(Case55) USE(Case56) USE(Case57) USE(Case58) USE(Case59) USE(Case60) USE(Case61)         \
                              USE(Case62) USE(Case63) USE(Case64) USE(Case65) USE(Case66)

#define WARPSCOPE_CASE_ON_BACKENDS(Suite) \
  class Suite : public OnBackend {};
WARPSCOPE_FOR_EACH_CASE_ON_BACKENDS(WARPSCOPE_CASE_ON_BACKENDS)
#undef WARPSCOPE_CASE_ON_BACKENDS

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

// Checked CUDA calls. For .cu files and what they include; every call is checked in Release builds too.
// CUDA Runtime API, error handling.
#pragma once

#include <cuda_runtime.h>

#include "render/base/error.h"

namespace warpscope::cuda {

/// Throws DeviceError naming the call and its place if `result` is a failure, which is then cleared where CUDA lets it be.
void check(cudaError_t result, const char* expression, const char* file, int line);

#define WARPSCOPE_CUDA_CHECK(expression) ::warpscope::cuda::check((expression), #expression, __FILE__, __LINE__)

/// Goes behind every kernel launch.
#define WARPSCOPE_CUDA_CHECK_LAUNCH() ::warpscope::cuda::check(cudaGetLastError(), "kernel launch", __FILE__, __LINE__)

}  // namespace warpscope::cuda

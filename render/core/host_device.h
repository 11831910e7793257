// Lets one header compile under a plain C++ compiler and under nvcc: include this first, mark shared functions WARPSCOPE_HD.
// GLM needs <cuda.h> before it and GLM_FORCE_CUDA to be usable in device code.
#pragma once

#if defined(__CUDACC__)
#include <cuda.h>
#define GLM_FORCE_CUDA
#define WARPSCOPE_HD __host__ __device__
#else
#define WARPSCOPE_HD
#endif

#include <glm/glm.hpp>

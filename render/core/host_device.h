// Lets one header compile under a plain C++ compiler and under nvcc: include this first, mark shared functions WARPSCOPE_HD, and WARPSCOPE_NOINLINE what is seldom called.
// GLM needs <cuda.h> before it and GLM_FORCE_CUDA to be usable in device code.
#pragma once

#if defined(__CUDACC__)
#include <cuda.h>
#define GLM_FORCE_CUDA
#define WARPSCOPE_HD __host__ __device__
#define WARPSCOPE_NOINLINE __noinline__
#else
#define WARPSCOPE_HD
#define WARPSCOPE_NOINLINE [[gnu::noinline]]
#endif

#include <glm/glm.hpp>

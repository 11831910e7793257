// Which hardware computes.
// CUDA C++ Programming Guide for what `cuda` asks of a machine.
#pragma once

#include <string_view>

namespace warpscope {

enum class Backend {
  automatic,  ///< CUDA where it works, else the CPU; a device that fails is left for the CPU
  cpu,        ///< every machine
  cuda,       ///< an NVIDIA GPU, or an error that says why not
};

/// As the command line says it.
constexpr std::string_view nameOf(Backend backend) {
  return backend == Backend::cpu ? "cpu" : backend == Backend::cuda ? "cuda" : "auto";
}

}  // namespace warpscope

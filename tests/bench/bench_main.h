// What the mains of benchmarks share: a failure is a sentence with the benchmark's name, and exit code 1.
#pragma once

#include <cstdio>
#include <exception>

namespace warpscope {

/// Calls run(). Returns main's exit code.
template <class Run>
int benchMain(const char* name, const Run& run) {
  try {
    run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 1;
  }
  return 0;
}

}  // namespace warpscope

// Which CUDA devices this machine has. Free of CUDA itself, so that everything can include it.
// CUDA Runtime API, device management.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace warpscope::cuda {

struct Device {
  std::string name;
  int computeMajor = 0;
  int computeMinor = 0;
  size_t memoryBytes = 0;
  int clockMHz = 0;  ///< highest of its multiprocessors
};

struct DeviceReport {
  std::vector<Device> devices;
  std::string driverVersion;  ///< "13.0": the newest CUDA that the driver knows; empty without one
  std::string reason;  ///< why there are none; empty if there are some
};

/// Least compute capability that the kernels are built for.
inline constexpr int kLeastComputeMajor = 7;
inline constexpr int kLeastComputeMinor = 5;

/// Why work on the first device is not possible here; empty if it is.
std::string whyUnavailable();

/// Never throws for want of a device or a driver: the report says what is missing.
DeviceReport listDevices();

}  // namespace warpscope::cuda

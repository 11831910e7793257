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
};

struct DeviceReport {
  std::vector<Device> devices;
  std::string reason;  ///< why there are none; empty if there are some
};

/// Never throws for want of a device or a driver: the report says what is missing.
DeviceReport listDevices();

}  // namespace warpscope::cuda

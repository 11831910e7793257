// What a frame holds in a device's memory, for those who go on with it there. Free of CUDA itself.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "render/core/host_device.h"
#include "render/core/sample.h"
#include "render/core/transfer_vector.h"

namespace warpscope {

struct SampleFrame;

/// The first segment of a pixel's ray: where it begins, as a depth code.
struct FirstSegment {
  uint32_t pixel, begin;
};

/// Of samples, and of pixels' rays, about so many tell where the grid of a frame's rays lies: at equal strides, from the first on.
inline constexpr size_t kFrameProbes = 256;
WARPSCOPE_HD inline size_t probeStride(size_t count) { return count < 2 * kFrameProbes ? 1 : count / kFrameProbes; }
/// There are never more.
inline constexpr size_t kMostFrameProbes = 2 * kFrameProbes;

/// Samples, colours, layers and segments of a frame. It keeps their memory; what is there no longer changes.
class FrameOnDevice {
 public:
  virtual ~FrameOnDevice() = default;

  virtual size_t sampleCount() const = 0;
  virtual size_t segmentCount() const = 0;
  /// Of segments.
  virtual bool hasNormals() const = 0;
  /// Every probeStride()-th sample. Of a frame that its marcher left there, as what follows.
  virtual const std::vector<PackedSample>& probedSamples() const = 0;
  /// Of every probeStride()-th pixel those that have segments.
  virtual const std::vector<FirstSegment>& probedSegments() const = 0;
  /// Fills the vectors of `frame` that are of such things, page-locked, and those of its planes that are there. Waits. Throws DeviceError.
  virtual void copyTo(SampleFrame& frame) const = 0;
};

using FrameOnDevicePtr = std::shared_ptr<const FrameOnDevice>;

/// The same frame where what it holds is away, in host memory alone. Throws DeviceError.
SampleFrame onHost(const SampleFrame& frame);

}  // namespace warpscope

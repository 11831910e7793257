// What a frame holds in a device's memory, for those who go on with it there. Free of CUDA itself.
#pragma once

#include <cstddef>
#include <memory>

#include "render/core/sample.h"
#include "render/core/transfer_vector.h"

namespace warpscope {

struct SampleFrame;

/// The first segment of a pixel's ray: where it begins, as a depth code.
struct FirstSegment {
  uint32_t pixel, begin;
};

/// Samples, colours, layers and segments of a frame. It keeps their memory; what is there no longer changes.
class FrameOnDevice {
 public:
  virtual ~FrameOnDevice() = default;

  virtual size_t sampleCount() const = 0;
  virtual size_t segmentCount() const = 0;
  /// Of segments.
  virtual bool hasNormals() const = 0;
  /// Every `stride`-th sample, from the first on. Waits. Throws DeviceError.
  virtual TransferVector<PackedSample> everySample(size_t stride) const = 0;
  /// Of every `stride`-th pixel, from the first on, those that have segments. Of a frame that its marcher left there. Waits. Throws DeviceError.
  virtual TransferVector<FirstSegment> firstSegments(size_t stride) const = 0;
  /// Fills the vectors of `frame` that are of such things, page-locked, and those of its planes that are there. Waits. Throws DeviceError.
  virtual void copyTo(SampleFrame& frame) const = 0;
};

using FrameOnDevicePtr = std::shared_ptr<const FrameOnDevice>;

/// The same frame where what it holds is away, in host memory alone. Throws DeviceError.
SampleFrame onHost(const SampleFrame& frame);

}  // namespace warpscope

// What a frame holds in a device's memory, for those who go on with it there. Free of CUDA itself.
#pragma once

#include <cstddef>
#include <memory>

#include "render/march/pixel_places.h"

namespace warpscope {

struct SampleFrame;

/// How samples and the borders of segments are placed along rays (frame_places.h).
struct FramePlacements {
  Placement samples = Placement::depth, borders = Placement::depth;

  bool operator==(const FramePlacements&) const = default;
};

/// Samples, colours, layers and segments of a frame. It keeps their memory; what is there no longer changes.
class FrameOnDevice {
 public:
  virtual ~FrameOnDevice() = default;

  virtual size_t sampleCount() const = 0;
  virtual size_t segmentCount() const = 0;
  /// Of segments.
  virtual bool hasNormals() const = 0;
  /// As its marcher found them, where it left the frame there.
  virtual FramePlacements placements() const = 0;
  /// Fills the vectors of `frame` that are of such things, page-locked, and those of its planes that are there. Waits. Throws DeviceError.
  virtual void copyTo(SampleFrame& frame) const = 0;
};

using FrameOnDevicePtr = std::shared_ptr<const FrameOnDevice>;

/// The same frame where what it holds is away, in host memory alone. Throws DeviceError.
SampleFrame onHost(const SampleFrame& frame);

}  // namespace warpscope

// What a frame holds in a device's memory, for those who go on with it there. Free of CUDA itself.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>

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
  FrameOnDevice() = default;
  virtual ~FrameOnDevice() = default;
  FrameOnDevice(const FrameOnDevice&) = delete;
  FrameOnDevice& operator=(const FrameOnDevice&) = delete;

  virtual size_t sampleCount() const = 0;
  virtual size_t segmentCount() const = 0;
  /// Of segments.
  virtual bool hasNormals() const = 0;
  /// Whether every sample has one; frames of marchers have.
  virtual bool haveRadii() const = 0;
  /// As its marcher or its decoder found them, where it left the frame there.
  virtual FramePlacements placements() const = 0;
  /// Fills the vectors of `frame` that are of such things, page-locked, and those of its planes that are there. Waits. Throws DeviceError.
  virtual void copyTo(SampleFrame& frame) const = 0;

 private:
  friend std::shared_ptr<const SampleFrame> onHost(const std::shared_ptr<const SampleFrame>& frame);

  mutable std::mutex mutex_;
  mutable std::weak_ptr<const SampleFrame> asked_;      // whose copy there is: others of the same samples may be of other settings
  mutable std::shared_ptr<const SampleFrame> here_;
};

using FrameOnDevicePtr = std::shared_ptr<const FrameOnDevice>;

/// The same frame where what it holds is away, in host memory alone. Throws DeviceError.
SampleFrame onHost(const SampleFrame& frame);
/// The frame itself where it is here, or null; else a copy as above, made once for all who ask, until another frame of the same samples is asked for or the last of them goes. Safe on any thread. Throws DeviceError.
std::shared_ptr<const SampleFrame> onHost(const std::shared_ptr<const SampleFrame>& frame);

}  // namespace warpscope

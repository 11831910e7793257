// What a frame looks like that was left on a device, without one.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>

#include "render/base/error.h"
#include "render/march/frame_places.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// In host memory after all; or lost.
class HeldFrame final : public FrameOnDevice {
 public:
  explicit HeldFrame(SampleFrame frame, bool isLost = false)
      : frame_(std::move(frame)), placements_{placementOf(frame_), borderPlacementOf(frame_)}, isLost_(isLost) {}
  /// Placed as its marcher may have found it.
  HeldFrame(SampleFrame frame, const FramePlacements& found) : frame_(std::move(frame)), placements_(found), isLost_(false) {}

  size_t sampleCount() const override { return frame_.size(); }
  size_t segmentCount() const override { return frame_.segments.size(); }
  bool hasNormals() const override { return !frame_.segments.normals.empty(); }
  bool haveRadii() const override { return std::ranges::none_of(frame_.samples, [](PackedSample sample) { return radiusCode(sample) == 0; }); }
  FramePlacements placements() const override { return placements_; }
  void copyTo(SampleFrame& frame) const override {
    requireDevice();
    frame.samples = frame_.samples;
    frame.colors = frame_.colors;
    frame.planes = frame_.planes;
    frame.segments = frame_.segments;
  }

 private:
  void requireDevice() const {
    if (isLost_) throw DeviceError("unplugged");
  }

  const SampleFrame frame_;
  const FramePlacements placements_;
  const bool isLost_;
};

/// The same frame as a marcher leaves it on a device.
inline SampleFrame leftOnDevice(SampleFrame frame, bool isLost = false) {
  SampleFrame left = frame;
  left.samples = {};
  left.colors = {};
  left.segments = {};
  for (SamplePlane& plane : left.planes) plane.values = {};
  left.device = std::make_shared<const HeldFrame>(std::move(frame), isLost);
  left.isAway = true;
  return left;
}

}  // namespace warpscope

// What a frame looks like that was left on a device, without one.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "render/base/error.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// In host memory after all; or lost.
class HeldFrame final : public FrameOnDevice {
 public:
  explicit HeldFrame(SampleFrame frame, bool isLost = false) : frame_(std::move(frame)), isLost_(isLost) {
    for (size_t i = 0; i < frame_.size(); i += probeStride(frame_.size())) samples_.push_back(frame_.samples[i]);
    size_t at = 0;
    for (size_t pixel = 0; pixel < frame_.segments.rays.size(); ++pixel) {
      const int count = frame_.segments.rays[pixel].count();
      if (pixel % probeStride(frame_.segments.rays.size()) == 0 && count > 0) segments_.push_back({static_cast<uint32_t>(pixel), frame_.segments.depths[at].begin});
      at += static_cast<size_t>(count);
    }
  }

  size_t sampleCount() const override { return frame_.size(); }
  size_t segmentCount() const override { return frame_.segments.size(); }
  bool hasNormals() const override { return !frame_.segments.normals.empty(); }
  const std::vector<PackedSample>& probedSamples() const override { return samples_; }
  const std::vector<FirstSegment>& probedSegments() const override { return segments_; }
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
  const bool isLost_;
  std::vector<PackedSample> samples_;
  std::vector<FirstSegment> segments_;
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

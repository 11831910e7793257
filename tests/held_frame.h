// What a frame looks like that was left on a device, without one.
#pragma once

#include <utility>

#include "render/base/error.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// In host memory after all; or lost.
class HeldFrame final : public FrameOnDevice {
 public:
  explicit HeldFrame(SampleFrame frame, bool isLost = false) : frame_(std::move(frame)), isLost_(isLost) {}

  size_t sampleCount() const override { return frame_.size(); }
  size_t segmentCount() const override { return frame_.segments.size(); }
  bool hasNormals() const override { return !frame_.segments.normals.empty(); }
  TransferVector<PackedSample> everySample(size_t stride) const override {
    requireDevice();
    TransferVector<PackedSample> samples;
    for (size_t i = 0; i < frame_.size(); i += stride) samples.push_back(frame_.samples[i]);
    return samples;
  }
  TransferVector<FirstSegment> firstSegments(size_t stride) const override {
    requireDevice();
    TransferVector<FirstSegment> first;
    size_t at = 0;
    for (size_t pixel = 0; pixel < frame_.segments.rays.size(); ++pixel) {
      const int count = frame_.segments.rays[pixel].count();
      if (pixel % stride == 0 && count > 0) first.push_back({static_cast<uint32_t>(pixel), frame_.segments.depths[at].begin});
      at += static_cast<size_t>(count);
    }
    return first;
  }
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

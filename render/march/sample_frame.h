// What a server sends for one camera: the samples that its rays found, without the pixels that found nothing.
// The format is explained in core/sample.h. A ray may have found several: they follow one another, near to far, and the plane `layer` says
// which are of one ray. Without that plane every sample is its ray's only one. Each ray is the one through the centre of a pixel of its own.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "render/core/camera.h"
#include "render/core/sample.h"
#include "render/core/transfer_vector.h"
#include "render/march/frame_on_device.h"
#include "render/march/frame_segments.h"
#include "render/march/march_settings.h"
#include "render/march/sample_planes.h"
#include "render/volume/proxy.h"

namespace warpscope {

/// Milliseconds that each stage took on the server.
struct ServerTimings {
  double marchMs = 0.0;
  double compactMs = 0.0;
  double copyMs = 0.0;  ///< from the device's memory to the host's; 0 where the CPU marched, or the frame stayed there
};

struct SampleFrame {
  uint64_t requestId = 0;
  Camera camera;  ///< that the samples were marched for; its size is the size of the server's image
  SampleQuantization quantization;
  MarchSettings settings;    ///< that the samples were marched with
  uint64_t functionVersion = 0;  ///< which of the transfer functions that its client has asked for; 0: the scene's. Not sent: the client's own
  VolumeGeometry geometry;   ///< of the volume: where lights that stay in the world are from it
  float voxelRadius = 1.0f;  ///< half the diagonal of a voxel, volume units: with the settings it tells how large a sample should be
  ServerTimings timings;

  TransferVector<PackedSample> samples;  ///< pixels in the picture, row by row; near to far of a ray; no radius code is 0
  TransferVector<Rgba8> colors;          ///< one for each sample: of several of a ray, those over one another are the ray's
  std::vector<SamplePlane> planes;       ///< kLayerPlane among them if a ray has more than one sample
  FrameSegments segments;                ///< of the same rays, where the settings ask for some
  ProxyPtr proxy;                        ///< what the frame is of, coarsely: the same object for all frames of a scene; null where nobody asked for it
  FrameOnDevicePtr device;               ///< where samples, colours, layers and segments are as well; null: nowhere. Who changes them here takes it away
  bool isAway = false;                   ///< they are there alone (Marcher::marchToCode, DecodedPlace::device): vectors of them are empty

  size_t size() const { return isAway ? device->sampleCount() : samples.size(); }
  /// What the frame's samples take on the wire in this format; of one that is away, nothing.
  size_t sizeBytes() const {
    size_t bytes = samples.size() * (sizeof(PackedSample) + sizeof(Rgba8));
    for (const SamplePlane& plane : planes) bytes += plane.values.size();
    return bytes + segments.sizeBytes();
  }
  /// For unpackSample(): make it once, not for each sample.
  SampleGrid grid() const { return makeSampleGrid(camera, quantization); }
  /// Null if the frame has none of that name.
  const SamplePlane* plane(std::string_view name) const {
    for (const SamplePlane& plane : planes)
      if (plane.name == name) return &plane;
    return nullptr;
  }
  /// The values of kLayerPlane, all less than settings.sample.samplesPerRay; empty if every sample is its ray's only one.
  std::span<const uint8_t> layers() const {
    const SamplePlane* const plane = this->plane(kLayerPlane);
    if (plane == nullptr || plane->element != PlaneElement::uint8) return {};
    return {reinterpret_cast<const uint8_t*>(plane->values.data()), plane->values.size()};
  }
};

/// One past the last sample of the ray whose first is `first`. `layers` as SampleFrame::layers() gives them.
inline size_t endOfRay(std::span<const uint8_t> layers, size_t first) {
  size_t end = first + 1;
  while (end < layers.size() && layers[end] != 0) ++end;
  return end;
}

using SampleFramePtr = std::shared_ptr<const SampleFrame>;

}  // namespace warpscope

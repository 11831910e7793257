// What a server sends for one camera: the samples that its rays found, without the pixels that found nothing.
// The format is explained in core/sample.h; frames keep no link to the pixel a sample came from but the order.
#pragma once

#include <cstdint>
#include <memory>

#include "render/core/camera.h"
#include "render/core/sample.h"
#include "render/core/transfer_vector.h"
#include "render/march/march_settings.h"

namespace warpscope {

/// Milliseconds that each stage took on the server.
struct ServerTimings {
  double marchMs = 0.0;
  double compactMs = 0.0;
  double copyMs = 0.0;  ///< from the device's memory to the host's; 0 where the CPU marched
};

struct SampleFrame {
  uint64_t requestId = 0;
  Camera camera;  ///< that the samples were marched for; its size is the size of the server's image
  SampleQuantization quantization;
  MarchSettings settings;    ///< that the samples were marched with
  float voxelRadius = 1.0f;  ///< half the diagonal of a voxel, volume units: with the settings it tells how large a sample should be
  ServerTimings timings;

  TransferVector<PackedSample> samples;  ///< in pixel order, row by row; no code is 0
  TransferVector<Rgba8> colors;          ///< one for each sample

  size_t size() const { return samples.size(); }
  /// What the frame's samples take on the wire in this format.
  size_t sizeBytes() const { return samples.size() * (sizeof(PackedSample) + sizeof(Rgba8)); }
  Sphere sphere(size_t i) const { return unpackSample(samples[i], quantization); }
};

using SampleFramePtr = std::shared_ptr<const SampleFrame>;

}  // namespace warpscope

// A frame's samples in device memory as surfacesOf() wants them. For .cu files.
// See surface_hits.h.
#pragma once

#include "render/core/color.h"
#include "render/core/sample.h"

namespace warpscope {

struct SamplesOnDevice {
  const PackedSample* samples;
  const Rgba8* colors;
  const ColorTables* tables;
  SampleGrid grid;

  __device__ Sphere sphere(uint32_t id) const { return unpackSample(samples[id], grid); }
  __device__ uint32_t pixel(uint32_t id) const { return pixelKey(samples[id]); }
  __device__ glm::vec4 color(uint32_t id) const { return tables->decode(colors[id]); }
};

}  // namespace warpscope

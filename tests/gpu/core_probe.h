// Everything that render/core and render/march promise to compute alike on the host and on a device, in one function of plain data.
// Compiled by both compilers; the device's answers must be the host's, bit for bit.
#pragma once

#include <string>
#include <vector>

#include "render/core/box.h"
#include "render/core/camera.h"
#include "render/core/morton.h"
#include "render/core/ray_sphere.h"
#include "render/core/sample.h"
#include "render/core/transfer_table.h"
#include "render/march/depth_heuristic.h"
#include "render/march/lattice.h"
#include "render/march/ray_state.h"
#include "render/march/transmittance.h"
#include "render/volume/voxel_access.h"

namespace warpscope {

struct CoreProbeInput {
  Camera camera;
  glm::vec2 pixel;
  glm::vec3 point;
  float radius;
  float step;
  float alphas[8];
  SampleQuantization quantization;
  SampleGrid grid;
};

struct CoreProbeResult {
  Ray ray;
  PixelRay pixelRay;
  float sphereT;
  RayInterval interval;
  Projection projection;
  uint64_t packed;
  Sphere unpacked;
  uint64_t morton;
  int latticeCount;
  float latticeLast;
  float depths[10];
  float transmittance;
  float trilinear;
  int tableIndex;
  int axisIndex;
  float axisWeight;
  float partialOpacity;
  float combinedDepths[10];
  glm::dvec3 combinedColor;
  double combinedTransmittance;
};

template <class Depth>
WARPSCOPE_HD inline float probeDepth(const CoreProbeInput& in) {
  ProfileFold profile;
  CountingSample samples[8];
  Transmittance transmittance;
  for (int i = 0; i < 8; ++i) {
    samples[i] = CountingSample::behind(transmittance.exact(), in.step * (static_cast<float>(i) + 0.5f), in.step, in.alphas[i]);
    transmittance.pass(in.alphas[i]);
    profile.add(samples[i]);
  }
  auto fold = Depth::start(0.8f, profile);
  for (int i = 0; i < 8; ++i) fold.add(samples[i]);
  return Depth::result(fold).depth;
}

/// Two pieces of a ray, put together.
template <class Depth>
WARPSCOPE_HD inline RayState<Depth> probeState(const CoreProbeInput& in) {
  ProfileFold profile;
  RayState<Depth> pieces[2];
  Transmittance transmittance;
  for (int pass = 0; pass < 2; ++pass) {
    transmittance = Transmittance();
    for (int i = 0; i < 8; ++i) {
      RayState<Depth>& piece = pieces[i / 4];
      if (pass == 1 && i % 4 == 0) piece.fold = Depth::start(0.8f, profile);
      const auto sample = CountingSample::behind(transmittance.exact(), in.step * (static_cast<float>(i) + 0.5f), in.step, in.alphas[i]);
      if (pass == 0)
        profile.add(sample);
      else
        piece.fold.add(sample);
      transmittance.pass(in.alphas[i]);
    }
  }
  for (int i = 0; i < 8; ++i) {
    RayLight& light = pieces[i / 4].light;
    light = RayLight::combine(
        light, {glm::dvec3(in.alphas[i]) * glm::dvec3(in.point), 1.0 - static_cast<double>(in.alphas[i])});
  }
  return RayState<Depth>::combine(pieces[0], pieces[1]);
}

WARPSCOPE_HD inline CoreProbeResult probeCore(const CoreProbeInput& in) {
  CoreProbeResult out{};
  out.ray = pixelRay(in.camera, in.pixel);
  out.sphereT = intersectSphere(out.ray, in.point, in.radius);
  out.interval = intersectBox(reciprocalOf(out.ray.origin, out.ray.direction), in.quantization.bounds, 0.0f, kNoHit);
  out.projection = project(in.camera, in.point);
  const auto column = static_cast<uint32_t>(in.pixel.x), row = static_cast<uint32_t>(in.pixel.y);
  out.pixelRay = in.grid.pixels.ray(column, row);
  out.packed = packSample(column, row, in.radius, in.radius, in.quantization);
  out.unpacked = unpackSample(out.packed, in.grid);
  out.morton = mortonCode(static_cast<uint32_t>(out.packed) & 0x1fffff, static_cast<uint32_t>(out.packed >> 18) & 0x1fffff,
                          static_cast<uint32_t>(out.packed >> 36) & 0x1fffff);
  const RayLattice lattice = makeLattice(out.interval, in.step);
  out.latticeCount = lattice.count;
  out.latticeLast = lattice.count > 0 ? lattice.t(lattice.count - 1) : 0.0f;
  out.depths[0] = probeDepth<EntranceDepth>(in);
  out.depths[1] = probeDepth<ExitDepth>(in);
  out.depths[2] = probeDepth<MidpointDepth>(in);
  out.depths[3] = probeDepth<ThresholdDepth>(in);
  out.depths[4] = probeDepth<PeakDepth>(in);
  out.depths[5] = probeDepth<GradientDepth>(in);
  out.depths[6] = probeDepth<RelThresholdDepth>(in);
  out.depths[7] = probeDepth<EnExMeanDepth>(in);
  out.depths[8] = probeDepth<MedianDepth>(in);
  out.depths[9] = probeDepth<ExpectedDepth>(in);
  Transmittance transmittance;
  for (int i = 0; i < 8; ++i) transmittance.pass(in.alphas[i]);
  out.transmittance = transmittance.value();
  out.trilinear = trilinear(in.alphas, in.alphas[0], in.alphas[3], in.alphas[6]);
  TransferLookup table;
  table.scale = 512.0f * in.step;
  table.offset = -100.0f * in.alphas[1];
  table.bins = 256;
  out.tableIndex = table.binOf(out.trilinear);
  axisCell(in.point.x, axisEndsOf(100), out.axisIndex, out.axisWeight);
  out.combinedDepths[0] = probeState<EntranceDepth>(in).depth().depth;
  out.combinedDepths[1] = probeState<ExitDepth>(in).depth().depth;
  out.combinedDepths[2] = probeState<MidpointDepth>(in).depth().depth;
  out.combinedDepths[3] = probeState<ThresholdDepth>(in).depth().depth;
  out.combinedDepths[4] = probeState<PeakDepth>(in).depth().depth;
  out.combinedDepths[5] = probeState<GradientDepth>(in).depth().depth;
  out.combinedDepths[6] = probeState<RelThresholdDepth>(in).depth().depth;
  out.combinedDepths[7] = probeState<EnExMeanDepth>(in).depth().depth;
  out.combinedDepths[8] = probeState<MedianDepth>(in).depth().depth;
  out.combinedDepths[9] = probeState<ExpectedDepth>(in).depth().depth;
  const RayLight combined = probeState<EntranceDepth>(in).light;
  out.combinedColor = combined.color;
  out.combinedTransmittance = combined.transmittance;
  out.partialOpacity = correctOpacity(in.alphas[1], in.alphas[2]);
  return out;
}

/// Evaluates probeCore on the first CUDA device. Throws InputError if that fails.
std::vector<CoreProbeResult> probeCoreOnDevice(const std::vector<CoreProbeInput>& inputs);

/// Makes a kernel fail in a way that leaves the device useless to this process; returns CUDA's word for it.
std::string loseDevice();

}  // namespace warpscope

// Preparing to march.
// See march_setup.h.
#include "render/march/march_setup.h"

#include <algorithm>
#include <string>

#include "render/base/error.h"
#include "render/core/image.h"

namespace warpscope {

namespace {

BakedTransfer bakeTable(const MarchedVolume& marched, const RenderSettings& settings) {
  BakedTransfer baked;
  baked.arithmetic = settings.arithmetic;
  baked.table =
      bakeTransferTable(marched.transferFunction, *marched.volume, marched.scale, settings.step, settings.arithmetic);
  for (const float alpha : baked.table.alphas) baked.mostOpacity = std::max(baked.mostOpacity, alpha);
  return baked;
}

}  // namespace

BakedTransfer bakeTransfer(const MarchedVolume& marched, const RenderSettings& settings) {
  BakedTransfer baked = bakeTable(marched, settings);
  baked.emptyDistances = marched.macrocells.emptyDistances(baked.table);
  baked.visibleCells = static_cast<size_t>(std::ranges::count(baked.emptyDistances, 0));
  return baked;
}

EffectPlan planFor(const MarchedVolume& marched, const BakedTransfer& baked, size_t visibleCells, const RenderSettings& settings,
                   const std::optional<SampleSettings>& sample) {
  PlannedScene scene;
  scene.cells = marched.macrocells.count();
  scene.visibleCells = visibleCells;
  scene.missingVoxels = marched.volume->statistics().nonFinite;
  scene.isRefined = !baked.table.refinements.empty();
  scene.mostOpacity = baked.mostOpacity;
  scene.mostSamples = glm::length(glm::dvec3(marched.volume->bounds().extent())) / settings.step + 2.0;
#if WARPSCOPE_COUNTERS
  return EffectPlan(scene, settings, sample, decidedStage);
#else
  return EffectPlan(scene, settings, sample);
#endif
}

void requireMarchable(const Volume& volume, const Camera& camera, const RenderSettings& settings) {
  validate(settings);
  requireUsable(camera);
  const double longest = glm::length(glm::dvec3(volume.bounds().extent()));
  if (longest / settings.step > kMaxSamplesPerRay) throw UsageError("the step is too small for a volume of this size");
}

void requireMarchable(const Volume& volume, const Camera& camera, const MarchSettings& settings) {
  validate(settings);
  requireMarchable(volume, camera, settings.render);
}

std::shared_ptr<const BakedTransfer> MarchedVolume::bakedFor(const RenderSettings& settings) const {
  const std::scoped_lock lock(mutex_);
  if (!baked_ || !baked_->isFor(settings) || baked_->emptyDistances.empty())
    baked_ = std::make_shared<const BakedTransfer>(bakeTransfer(*this, settings));
  return baked_;
}

std::shared_ptr<const BakedTransfer> MarchedVolume::tableFor(const RenderSettings& settings) const {
  const std::scoped_lock lock(mutex_);
  if (!baked_ || !baked_->isFor(settings)) baked_ = std::make_shared<const BakedTransfer>(bakeTable(*this, settings));
  return baked_;
}

PixelGrid pixelsFor(const Volume& volume, const Camera& camera, const RenderSettings& settings) {
  const bool fromEye = settings.arithmetic == Arithmetic::textbook;
  return makePixelGrid(camera, fromEye ? 0.0f : depthRangeOf(camera, volume.bounds()).nearDepth);
}

SampleRule sampleRuleFor(const Volume& volume, const Camera& camera, const SampleSettings& settings) {
  validate(settings);
  // Each ray has a place for each of its samples, 12 bytes of memory, before it is known how many there are.
  constexpr uint64_t kMostPlaces = uint64_t{kMaxImageSide} * kMaxImageSide;
  const uint64_t rays = uint64_t{camera.width} * camera.height;
  if (rays * static_cast<uint64_t>(settings.samplesPerRay) > kMostPlaces)
    throw UsageError("a picture of " + std::to_string(camera.width) + "x" + std::to_string(camera.height) + " pixels may have at most " +
                     std::to_string(kMostPlaces / rays) + " samples a ray, not " + std::to_string(settings.samplesPerRay));
  SampleRule rule;
  rule.policy = settings.radiusPolicy;
  rule.voxelRadius = 0.5f * glm::length(volume.geometry().voxelEdges());
  rule.scale = settings.radiusScale;
  const Box& bounds = volume.bounds();
  const float farthest = glm::length(camera.eye - bounds.center()) + 0.5f * glm::length(bounds.extent());
  rule.quantization = quantizationFor(camera, bounds, radiusUnitFor(sampleRadius(rule, pixelEdge(camera), farthest, 1.0f)));
  return rule;
}

SampleFrame emptyFrame(const Camera& camera, const MarchSettings& settings, const SampleRule& rule) {
  SampleFrame frame;
  frame.camera = camera;
  frame.quantization = rule.quantization;
  frame.settings = settings;
  frame.voxelRadius = rule.voxelRadius;
  return frame;
}

}  // namespace warpscope

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
  baked.isoValues = isoValuesOf(settings);
  baked.surfaces = prepareIsosurfaces(baked.isoValues, marched.transferFunction, marched.scale);
  baked.table =
      bakeTransferTable(marched.transferFunction, *marched.volume, marched.scale, settings.step, settings.arithmetic);
  for (const float alpha : baked.table.alphas) baked.mostOpacity = std::max(baked.mostOpacity, alpha);
  if (!wantsSegments(settings)) return baked;
  baked.segments = bakeSegmentTable(marched.transferFunction, *marched.volume, marched.scale, settings.step);
  baked.visibleSegments = visibleBySegments(baked.segments);
  baked.mostOpacity = std::max(baked.mostOpacity, baked.segments.mostOpacity);
  return baked;
}

}  // namespace

BakedTransfer bakeTransfer(const MarchedVolume& marched, const RenderSettings& settings) {
  BakedTransfer baked = bakeTable(marched, settings);
  baked.emptyDistances =
      settings.effects.mode == RenderMode::isosurface ? surfaceDistances(marched.macrocells, baked.surfaces) : marched.macrocells.emptyDistances(baked.visible());
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
  scene.dims = marched.volume->dims();
  scene.mostSamples = glm::length(glm::dvec3(marched.volume->bounds().extent())) / settings.step + 2.0;
#if WARPSCOPE_COUNTERS
  return EffectPlan(scene, settings, sample, decidedStage);
#else
  return EffectPlan(scene, settings, sample);
#endif
}

LightVolumeJob lightVolumeFor(const MarchedVolume& marched, const Camera& camera, const RenderSettings& settings, const EffectPlan& plan) {
  LightVolumeJob job;
  if (!plan.has(PlanStage::lightVolume)) return job;
  const Volume& volume = *marched.volume;
  const Shadows& shadows = settings.effects.shadows;
  job.shading = shadingFor(marched, camera, settings, plan);
  int ofLight[Lights::kMost], channels = 0;
  for (int i = 0; i < static_cast<int>(Lights::kMost); ++i) {
    const bool casts = plan.has(PlanStage::shadows) && i < job.shading.lightCount && job.shading.lights[i].kind != LightKind::headlight;
    ofLight[i] = casts ? channels++ : -1;
  }
  const int ofAmbient = plan.has(PlanStage::occlusion) ? channels++ : -1;
  if (channels == 0) return job;
  job.volume = lightVolumeLayout(volume.dims(), channels, shadows.gridEdge);
  std::ranges::copy(ofLight, job.volume.ofLight);
  job.volume.ofAmbient = ofAmbient;
  job.volume.shadowStrength = shadows.strength;
  job.volume.occlusionStrength = shadows.occlusion;
  job.volume.radius = shadows.occlusionRadius;
  job.clip = prepareClip(settings.effects.clip, volume, camera);
  job.lower = volume.bounds().lower;
  job.voxelEdges = glm::vec3(volume.geometry().voxelEdges());
  job.step = settings.step;
  if (plan.has(PlanStage::segments)) job.besideVisible = 0.5f * settings.step / std::min({job.voxelEdges.x, job.voxelEdges.y, job.voxelEdges.z});
  return job;
}

std::vector<float> lightVolumeKey(const LightVolumeJob& job, const RenderSettings& settings, const EffectPlan& plan) {
  const LightVolume& volume = job.volume;
  std::vector<float> key{volume.edge, static_cast<float>(volume.channels), job.step, settings.arithmetic == Arithmetic::textbook ? 1.0f : 0.0f,
                         plan.has(PlanStage::skipping) ? 1.0f : 0.0f, job.besideVisible};
  const auto add = [&](const glm::vec3& v) { key.insert(key.end(), {v.x, v.y, v.z}); };
  key.push_back(volume.ofAmbient >= 0 ? volume.radius : 0.0f);
  for (int i = 0; i < job.shading.lightCount; ++i) {
    if (volume.ofLight[i] < 0) continue;
    key.push_back(job.shading.lights[i].kind == LightKind::point ? 1.0f : 0.0f);
    add(job.shading.lights[i].vector);
  }
  add(job.clip.bounds.lower);
  add(job.clip.bounds.upper);
  for (int i = 0; i < job.clip.count; ++i) {
    add(job.clip.planes[i].normal);
    key.push_back(job.clip.planes[i].offset);
  }
  return key;
}

void requireFitting(const Volume& volume, const RenderSettings& settings) {
  validate(settings);
  const RenderMode mode = settings.effects.mode;
  if (wantsSegments(settings) && settings.arithmetic != Arithmetic::stable) throw UsageError("pre-integrated classification has no textbook arithmetic");
  if (mode != RenderMode::composite && settings.arithmetic != Arithmetic::stable)
    throw UsageError("the mode " + std::string(nameOf(mode)) + " has no textbook arithmetic; only " + std::string(nameOf(RenderMode::composite)) + " has");
  if (mode == RenderMode::isosurface) requireIsoValues(settings.effects.isoValues, volume);
}

void requireMarchable(const Volume& volume, const Camera& camera, const RenderSettings& settings) {
  requireFitting(volume, settings);
  requireUsable(camera);
  const double longest = glm::length(glm::dvec3(volume.bounds().extent()));
  if (longest / settings.step > kMaxSamplesPerRay) throw UsageError("the step is too small for a volume of this size");
}

void requireMarchable(const Volume& volume, const Camera& camera, const MarchSettings& settings) {
  validate(settings);
  requireMarchable(volume, camera, settings.render);
}

EffectPlan planFor(const MarchedVolume& marched, const RenderSettings& settings, const std::optional<SampleSettings>& sample) {
  requireFitting(*marched.volume, settings);
  const std::shared_ptr<const BakedTransfer> baked = marched.bakedFor(settings);
  return planFor(marched, *baked, baked->visibleCells, settings, sample);
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

ProxyPtr MarchedVolume::proxyFor(int longest, const std::stop_token& stop) const {
  const std::scoped_lock lock(proxyMutex_);
  if (!proxy_ || proxyLongest_ != longest) {
    proxy_ = std::make_shared<const Proxy>(makeProxy(*volume, transferFunction, longest, CopyFilter::leastSquares, stop));
    proxyLongest_ = longest;
  }
  return proxy_;
}

PixelGrid pixelsFor(const Volume& volume, const Camera& camera, const RenderSettings& settings) {
  const bool fromEye = settings.arithmetic == Arithmetic::textbook;
  return makePixelGrid(camera, fromEye ? 0.0f : depthRangeOf(camera, volume.bounds()).nearDepth);
}

MipSetup mipFor(const MarchedVolume& marched, const TransferTable& table, const EffectPlan& plan) {
  MipSetup setup;
  if (!plan.has(PlanStage::skipping)) return setup;
  setup.highest = marched.macrocells.highest();
  setup.lowest = marched.macrocells.lowest();
  const auto first = std::ranges::find_if(table.visibleBefore, [](int32_t bins) { return bins > 0; });
  setup.leastShown = leastShownValue(table.lookup(), static_cast<int>(first - table.visibleBefore.begin()) - 1);
  setup.hidesBelow = table.visibleBefore.back() == table.visibleBefore.end() - first;  // as many bins as there are from the first one on
  return setup;
}

SampleRule sampleRuleFor(const Volume& volume, const Camera& camera, const SampleSettings& settings) {
  validate(settings);
  // Each ray has a place for each of its samples, 12 bytes of memory, before it is known how many there are.
  constexpr uint64_t kMostPlaces = uint64_t{kMaxImageSide} * kMaxImageSide;
  const uint64_t rays = uint64_t{camera.width} * camera.height;
  const auto requirePlaces = [&](int perRay, uint64_t most, const char* what) {
    if (rays * static_cast<uint64_t>(perRay) > most)
      throw UsageError("a picture of " + std::to_string(camera.width) + "x" + std::to_string(camera.height) + " pixels may have at most " +
                       std::to_string(most / rays) + " " + what + " a ray, not " + std::to_string(perRay));
  };
  requirePlaces(settings.samplesPerRay, kMostPlaces, "samples");
  requirePlaces(settings.segments, kMostFrameSegments, "segments");
  SampleRule rule;
  rule.policy = settings.radiusPolicy;
  rule.voxelRadius = 0.5f * glm::length(volume.geometry().voxelEdges());
  rule.scale = settings.radiusScale;
  const Box& bounds = volume.bounds();
  const float farthest = glm::length(camera.eye - bounds.center()) + 0.5f * glm::length(bounds.extent());
  rule.quantization = quantizationFor(camera, bounds, radiusUnitFor(sampleRadius(rule, pixelEdge(camera), farthest, 1.0f, std::numeric_limits<float>::infinity())));
  return rule;
}

SampleFrame emptyFrame(const Volume& volume, const Camera& camera, const MarchSettings& settings, const SampleRule& rule) {
  SampleFrame frame;
  frame.camera = camera;
  frame.quantization = rule.quantization;
  frame.settings = settings;
  frame.geometry = volume.geometry();
  frame.voxelRadius = rule.voxelRadius;
  return frame;
}

}  // namespace warpscope

// What every marcher prepares before its rays start: checks, the baked transfer function, what is empty, the frame's head. Host only.
// See marcher.h for the errors.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "render/core/segment_table.h"
#include "render/effects/effect_plan.h"
#include "render/effects/isosurface_setup.h"
#include "render/effects/mip.h"
#include "render/effects/light_volume_march.h"
#include "render/effects/shading_setup.h"
#include "render/march/march.h"
#include "render/march/march_settings.h"
#include "render/march/sample_frame.h"
#include "render/march/sample_radius.h"
#include "render/march/volume_view.h"
#include "render/volume/macrocells.h"

namespace warpscope {

struct BakedTransfer;

/// Of surfaces that are looked for: none in other modes.
inline IsoValues isoValuesOf(const RenderSettings& settings) {
  return settings.effects.mode == RenderMode::isosurface ? settings.effects.isoValues : IsoValues();
}

/// Whether a march by these settings classifies steps by their ends, if the volume lets it.
inline bool wantsSegments(const RenderSettings& settings) { return settings.effects.preIntegration && settings.effects.mode == RenderMode::composite; }

/// A volume and how its values look: what marchers of the same scene share. Nothing that can be seen of it changes.
struct MarchedVolume {
  MarchedVolume(VolumePtr theVolume, TransferFunction theTransferFunction)
      : volume(std::move(theVolume)),
        transferFunction(std::move(theTransferFunction)),
        scale(valueScaleOf(volume->type(), volume->statistics(), transferFunction)),
        macrocells(*volume, scale) {}
  /// The same volume by another function. Reads no voxels; shares what does not depend on the function.
  MarchedVolume(const MarchedVolume& other, TransferFunction theTransferFunction)
      : volume(other.volume),
        transferFunction(std::move(theTransferFunction)),
        scale(valueScaleOf(volume->type(), volume->statistics(), transferFunction)),
        macrocells(other.macrocells.scaledBy(scale)) {}

  /// bakeTransfer, kept for whoever asks for the same next. Safe on any thread.
  std::shared_ptr<const BakedTransfer> bakedFor(const RenderSettings& settings) const;
  /// The same, for those who find empty cells elsewhere: emptyDistances may be missing.
  std::shared_ptr<const BakedTransfer> tableFor(const RenderSettings& settings) const;

  /// The coarse copy with so many voxels along its longest edge, by the same function; kept for whoever asks for the same next. Safe on any thread.
  ProxyPtr proxyFor(int longest, const std::stop_token& stop) const;

  VolumePtr volume;
  TransferFunction transferFunction;
  ValueScale scale;
  Macrocells macrocells;

 private:
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const BakedTransfer> baked_;  // the last one that was asked for
  mutable std::mutex proxyMutex_;  // of the following: making one reads the whole volume, and marches do not wait for that
  mutable ProxyPtr proxy_;         // likewise
  mutable int proxyLongest_ = 0;
};

using MarchedVolumePtr = std::shared_ptr<const MarchedVolume>;

/// What is derived from the transfer function for one step length and one arithmetic.
struct BakedTransfer {
  TransferTable table;
  Arithmetic arithmetic = Arithmetic::stable;
  float mostOpacity = 0.0f;             ///< of a sample
  std::vector<uint8_t> emptyDistances;  ///< empty where nobody asked for them
  size_t visibleCells = 0;              ///< at a distance of 0, likewise
  IsosurfaceSetup surfaces;             ///< where there are any, distances are those to them
  IsoValues isoValues;                  ///< of these
  SegmentTable segments;                ///< where steps are classified by their ends, else without nodes
  TransferTable visibleSegments;        ///< likewise: what shows anything by them

  bool hasSegments() const { return segments.nodes > 0; }
  /// What cells show anything by.
  const TransferTable& visible() const { return hasSegments() ? visibleSegments : table; }

  /// True if this is what a march by `settings` needs.
  bool isFor(const RenderSettings& settings) const {
    return !table.entries.empty() && table.step == settings.step && arithmetic == settings.arithmetic && isoValues == isoValuesOf(settings) &&
           hasSegments() == wantsSegments(settings);
  }
};

BakedTransfer bakeTransfer(const MarchedVolume& marched, const RenderSettings& settings);

/// Whatever settings ask of a volume. Throws UsageError.
void requireFitting(const Volume& volume, const RenderSettings& settings);

/// Each throws UsageError for settings out of range, InputError for a camera that isUsable() refuses.
void requireMarchable(const Volume& volume, const Camera& camera, const RenderSettings& settings);
void requireMarchable(const Volume& volume, const Camera& camera, const MarchSettings& settings);

/// The rays of a picture of the volume. Textbooks' begin at the eye.
PixelGrid pixelsFor(const Volume& volume, const Camera& camera, const RenderSettings& settings);

/// What of it has to be done. `visibleCells`: those in which something is shown. `sample`: what is sent, or nothing where the picture alone is wanted.
EffectPlan planFor(const MarchedVolume& marched, const BakedTransfer& baked, size_t visibleCells, const RenderSettings& settings,
                   const std::optional<SampleSettings>& sample);
/// The same of what marchers of it are asked for. Throws as requireFitting().
EffectPlan planFor(const MarchedVolume& marched, const RenderSettings& settings, const std::optional<SampleSettings>& sample);

/// The light of a picture, as far as the plan has it.
inline ShadingSetup shadingFor(const MarchedVolume& marched, const Camera& camera, const RenderSettings& settings, const EffectPlan& plan) {
  ShadingSetup setup = prepareShading(settings.effects.shading, settings.effects.lights, *marched.volume, marched.scale, camera);
  setup.isLit = plan.has(PlanStage::gradient);
  setup.hasDiffuse = plan.has(PlanStage::diffuse);
  setup.hasHighlights = plan.has(PlanStage::specular);
  setup.hasHalfVectors = plan.has(PlanStage::halfVector);
  return setup;
}

/// How a ray finds its greatest value, by memory of the host.
MipSetup mipFor(const MarchedVolume& marched, const TransferTable& table, const EffectPlan& plan);
/// What the values of the picture's light volume are found out by; without channels where the plan has none. Its values are for the caller to fill.
LightVolumeJob lightVolumeFor(const MarchedVolume& marched, const Camera& camera, const RenderSettings& settings, const EffectPlan& plan);
/// Equal where the values are, of one marched volume.
std::vector<float> lightVolumeKey(const LightVolumeJob& job, const RenderSettings& settings, const EffectPlan& plan);
#if WARPSCOPE_COUNTERS
/// What every plan of a marcher has decided, for tests.
inline std::optional<DecidedStage> decidedStage;
#endif

/// How a frame of this volume seen by this camera sizes and quantises its samples. Throws UsageError for settings out of range.
SampleRule sampleRuleFor(const Volume& volume, const Camera& camera, const SampleSettings& settings);

/// A frame without samples and timings.
SampleFrame emptyFrame(const Volume& volume, const Camera& camera, const MarchSettings& settings, const SampleRule& rule);

/// The rule that the frame's samples were made by.
inline SampleRule sampleRuleOf(const SampleFrame& frame) {
  return {frame.settings.sample.radiusPolicy, frame.voxelRadius, frame.settings.sample.radiusScale, frame.quantization};
}

inline RayLimits limitsOf(const RenderSettings& settings) {
  return {settings.contribution, settings.terminateEarly ? settings.contribution : 0.0f};
}
/// As far as the plan needs them. A ray that an opaque surface ends has ended as others have: nothing is left of it, which is less than the least.
inline RayLimits limitsOf(const RenderSettings& settings, const EffectPlan& plan) {
  const float least = plan.has(PlanStage::surfaces) ? std::numeric_limits<float>::min() : 0.0f;
  return {settings.contribution, plan.has(PlanStage::earlyEnd) ? settings.contribution : least};
}

/// A view of `marched` whose pointers are for the caller to fill.
template <class Voxel>
VolumeView<Voxel> makeVolumeView(const MarchedVolume& marched) {
  const Volume& volume = *marched.volume;
  VolumeView<Voxel> view;
  view.dims = glm::ivec3(volume.dims());
  for (int axis = 0; axis < 3; ++axis) view.ends[axis] = axisEndsOf(view.dims[axis]);
  view.scale = marched.scale;
  view.lower = volume.bounds().lower;
  view.voxelsPerUnit = 1.0f / volume.geometry().voxelEdges();
  view.cells.dims = marched.macrocells.dims();
  view.cells.edgeBits = std::countr_zero(static_cast<uint32_t>(marched.macrocells.edge()));
  return view;
}

}  // namespace warpscope

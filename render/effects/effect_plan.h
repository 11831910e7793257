// What a march has to do for one picture: the smallest set of stages that can change a pixel, each with the reason for which it is in or out. As data,
// so that marchers go by it, tests hold it to account and people read it.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "render/march/march_settings.h"

namespace warpscope {

/// In the order in which a sample meets them.
enum class PlanStage {
  march,          ///< rays at all
  jitter,         ///< of the places of samples
  maximum,        ///< of the values along a ray
  surfaces,       ///< that a ray crosses
  clip,           ///< of rays to what is kept
  skipping,       ///< of cells that show nothing
  missingVoxels,  ///< leaving voxels out of interpolation that are not finite
  segments,       ///< classifying what lies between the ends of a step
  refinement,     ///< telling bins of the transfer function apart further
  correction,     ///< of opacities to the step
  gradient,       ///< at samples that are seen
  diffuse,        ///< light that surfaces send everywhere
  specular,       ///< and where they mirror a light
  halfVector,     ///< between eye and light
  shadows,        ///< of matter before lights
  occlusion,      ///< of ambient light
  lightVolume,    ///< the grid that both are read from
  earlyEnd,       ///< of rays
  secondPass,     ///< of a heuristic that wants to know the whole ray first
  severalSamples, ///< the ray's parts once more, one after the other
  spread,         ///< of depth about what stands for it
  raySegments,    ///< that a ray's samples are merged into
};

struct StageDescriptor {
  PlanStage stage;
  std::string_view name;     ///< as the command line and JSON say it
  std::string_view summary;  ///< what it is
};

/// Every stage, in their order.
inline constexpr std::array<StageDescriptor, 22> kStages{{
    {PlanStage::march, "march", "rays through the volume"},
    {PlanStage::jitter, "jitter", "moving each ray's samples by noise"},
    {PlanStage::maximum, "maximum", "the greatest value along a ray"},
    {PlanStage::surfaces, "surfaces", "where rays cross iso-values"},
    {PlanStage::clip, "clip", "cutting rays to what is kept"},
    {PlanStage::skipping, "skipping", "leaping over cells that show nothing"},
    {PlanStage::missingVoxels, "missing-voxels", "leaving out voxels that are not finite"},
    {PlanStage::segments, "pre-integration", "classifying steps by the values at both ends"},
    {PlanStage::refinement, "refinement", "telling entries of the transfer table apart further"},
    {PlanStage::correction, "correction", "opacity corrected to the step"},
    {PlanStage::gradient, "gradient", "central differences where a sample is seen"},
    {PlanStage::diffuse, "diffuse", "light that surfaces send everywhere, beside the ambient"},
    {PlanStage::specular, "specular", "highlights"},
    {PlanStage::halfVector, "half-vector", "the half vector of each sample and light"},
    {PlanStage::shadows, "shadows", "light that matter keeps from a sample"},
    {PlanStage::occlusion, "ambient-occlusion", "ambient light that matter around keeps from a sample"},
    {PlanStage::lightVolume, "light-volume", "finding out at places of a grid how much light arrives"},
    {PlanStage::earlyEnd, "early-end", "ending rays where hardly any light is left"},
    {PlanStage::secondPass, "second-pass", "marching again once the ray's whole opacity is known"},
    {PlanStage::severalSamples, "several-samples", "marching again for the samples of a ray's parts"},
    {PlanStage::spread, "spread", "how far each sample's depth is spread along its ray"},
    {PlanStage::raySegments, "ray-segments", "merging each ray's samples into segments"},
}};

struct PlannedStage {
  bool isIn = false;
  std::string reason;  ///< why: half a sentence
};

/// What of a volume and its transfer function a plan wants to know.
struct PlannedScene {
  size_t cells = 0;          ///< of empty space skipping
  size_t visibleCells = 0;   ///< those in which something is shown
  size_t missingVoxels = 0;  ///< not finite
  bool isRefined = false;    ///< the transfer table has pieces
  float mostOpacity = 1.0f;  ///< of a sample
  double mostSamples = 0.0;  ///< along a ray
  glm::uvec3 dims{1};        ///< voxels
};

/// A stage that is in or out whatever its rule says: for tests, which see by it that no rule is idle.
struct DecidedStage {
  PlanStage stage;
  bool isIn;
};

class EffectPlan {
 public:
  /// `sample`: what is sent, or nothing where the picture alone is wanted.
  EffectPlan(const PlannedScene& scene, const RenderSettings& settings, const std::optional<SampleSettings>& sample,
             const std::optional<DecidedStage>& decided = std::nullopt);

  bool has(PlanStage stage) const { return (*this)[stage].isIn; }
  const PlannedStage& operator[](PlanStage stage) const { return stages_[static_cast<size_t>(stage)]; }

 private:
  std::array<PlannedStage, kStages.size()> stages_;
};

}  // namespace warpscope

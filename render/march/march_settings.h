// The server's knobs, in two parts: what the picture is, and what is sent of it.
// Heuristics after Zellmann, Aumueller, Lang 2012 and Zellmann 2020; radius policies are explained at each name.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "render/base/named_value.h"
#include "render/base/range.h"
#include "render/core/arithmetic.h"
#include "render/effects/effects.h"

namespace warpscope {

/// Which point of a ray stands for the pixel. Exact definitions: depth_heuristic.h.
enum class Heuristic {
  entrance, exit, midpoint, threshold, peak, gradient, relThreshold, enExMean, median, expected
};

/// How large a sample is, in volume space, before the scale.
enum class RadiusPolicy {
  voxel,     ///< half the diagonal of a voxel (Zellmann 2020)
  constant,  ///< half the smallest voxel edge
  pixel,     ///< half the edge of a pixel at the sample's depth: a sphere that just fits into its pixel
  opacity,   ///< from `pixel` for a transparent pixel to `voxel` for an opaque one, by the pixel's opacity
  uncertainty,  ///< from `voxel` for a certain depth, growing with its standard deviation along the ray (after Zellmann 2020, who would smear such samples)
};

inline constexpr std::array<NamedValue<Heuristic>, 10> kHeuristics{{
    {Heuristic::entrance, "entrance", "first sample that counts"},
    {Heuristic::exit, "exit", "last sample that counts"},
    {Heuristic::midpoint, "midpoint", "middle between entrance and exit"},
    {Heuristic::threshold, "threshold", "where accumulated opacity crosses the threshold"},
    {Heuristic::peak, "peak", "most opaque sample"},
    {Heuristic::gradient, "gradient", "sample that contributes most: the steepest rise of accumulated opacity"},
    {Heuristic::relThreshold, "rel-threshold", "where accumulated opacity crosses the threshold's share of its final value"},
    {Heuristic::enExMean, "en-ex-mean", "where accumulated opacity crosses the mean opacity of entrance and exit"},
    {Heuristic::median, "median", "where accumulated opacity crosses half its final value"},
    {Heuristic::expected, "expected", "mean depth, weighted by contribution"},
}};

inline constexpr std::array<NamedValue<RadiusPolicy>, 5> kRadiusPolicies{{
    {RadiusPolicy::voxel, "voxel", "half a voxel's diagonal"},
    {RadiusPolicy::constant, "constant", "half the smallest voxel edge"},
    {RadiusPolicy::pixel, "pixel", "half a pixel's edge at the sample's depth"},
    {RadiusPolicy::opacity, "opacity", "from pixel (transparent) to voxel (opaque) by the pixel's opacity"},
    {RadiusPolicy::uncertainty, "uncertainty", "the standard deviation of depth along the ray; half a voxel's diagonal at least, twice that at most"},
}};

inline std::string_view nameOf(Heuristic heuristic) { return nameOf(kHeuristics, heuristic); }
inline std::string_view nameOf(RadiusPolicy policy) { return nameOf(kRadiusPolicies, policy); }

/// What the picture is: all that changes the colours which are rendered. Ground truth takes it whole.
struct RenderSettings {
  float step = 0.5f;                 ///< distance of samples along a ray, volume units (smallest voxel edges)
  float contribution = 1.0f / 1024;  ///< least contribution that lets a sample count; marching stops at this transmittance
  bool skipEmpty = true;             ///< leave out what the transfer function hides; never changes the picture
  bool terminateEarly = true;        ///< stop where hardly any light is left; never changes a depth
  /// Of pictures (Marcher::render). No knob of the marching: ground truth and samples are `stable`, and what is compared
  /// with them asks for another.
  Arithmetic arithmetic = Arithmetic::stable;
  Effects effects{};                 ///< each out by itself

  bool operator==(const RenderSettings&) const = default;
};

/// What is sent of it: which points stand for a ray, and how large they are.
struct SampleSettings {
  Heuristic heuristic = Heuristic::gradient;
  float threshold = 0.8f;          ///< parameter of `threshold` and `rel-threshold`
  RadiusPolicy radiusPolicy = RadiusPolicy::voxel;
  float radiusScale = 1.0f;        ///< factor on the policy's radius
  int samplesPerRay = 1;           ///< at most
  bool sendsSpread = false;        ///< of each sample how far its depth is spread along its ray: kSpreadPlane
  int proxy = 0;                   ///< voxels along the longest edge of a coarse copy of the volume (proxy.h) that goes with frames; 0: none
  int segments = 0;                ///< of a ray that are sent beside its samples, at most (frame_segments.h); 0: none

  bool operator==(const SampleSettings&) const = default;
};

/// Everything that a march depends on besides the volume, its transfer function and the camera.
struct MarchSettings {
  RenderSettings render;
  SampleSettings sample;

  bool operator==(const MarchSettings&) const = default;
};

// What the settings may be; whoever reads them from somewhere says so with these.
inline constexpr Range kStepRange{1e-3, 1e3};
inline constexpr Range kRadiusScaleRange{1e-3, 1e3};
inline constexpr Range kContributionRange{1e-6, 0.5};
inline constexpr Range kThresholdRange{1e-3, 1.0};
inline constexpr Range kSamplesPerRayRange{1, 8};
inline constexpr Range kSegmentsRange{0, 16};
inline constexpr int kUsualSegments = 4;  ///< of scenes that do not say how many
inline constexpr Range kProxyRange{0, 256};  ///< voxels along the longest edge of the copy; 0: none

/// Each throws UsageError naming the setting that is out of range.
void validate(const RenderSettings& settings);
void validate(const SampleSettings& settings);
void validate(const MarchSettings& settings);

}  // namespace warpscope

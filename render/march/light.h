// What light makes of a sample, between classification and compositing. For host and device.
// A policy known at compile time, which costs nothing where it does nothing (cf. Engel et al. 2006, chapter 5).
#pragma once

#include <cstdint>

#include "render/core/ray.h"
#include "render/core/host_device.h"

namespace warpscope {

/// A sample as the transfer function sees it.
struct ClassifiedSample {
  int i = 0;              ///< place in the ray's lattice
  float t = 0.0f;         ///< centre of the step, distance along the ray, volume units
  float ds = 0.0f;        ///< length of the step
  float alpha = 0.0f;     ///< opacity, corrected to the step
  glm::vec3 color{0.0f};  ///< linear, times the opacity
};

/// A sample that stands for a place of the ray, and for no length of it.
struct PointSample : ClassifiedSample {};

/// The transfer function's colours as they are.
///
/// Any light has this one function, which returns the colour that the sample sends along the ray, linear and times its
/// opacity; opacity stays what it is. `ray.at(sample.t)` is the sample's place in volume space, `ray.direction` has
/// unit length. `source` is what the march reads the volume through (march.h): `source.view()` has the voxels, for
/// gradients. `k` is the sample's place among those that the source looked at. A light may hold what is the same for
/// all rays of a picture, by value: it is copied to the device as it is. The other lights: render/effects/shading.h.
struct Unlit {
  template <class Source>
  WARPSCOPE_HD glm::vec3 shade(const ClassifiedSample& sample, const Ray&, const Source&, int /*k*/) const {
    return sample.color;
  }
};

/// How a march asks a light: sample by sample. A source that looks at many samples at once may have it asked for all of them (shading_batch.h).
template <class Light, class Source>
struct LightOnSource {
  const Light& light;

  /// Called once the source has looked at samples i + k of the path's lattice, of which bit k of `visible` is set.
  template <class Path>
  WARPSCOPE_HD void look(const Path&, const Source&, int /*i*/, uint32_t /*visible*/) {}
  /// Of a sample among those.
  WARPSCOPE_HD glm::vec3 shade(const ClassifiedSample& sample, const Ray& ray, const Source& source, int k) const {
    return light.shade(sample, ray, source, k);
  }
};

}  // namespace warpscope

// Single rays through small volumes, by the sources of the modes, and the same field in double.
// What the marchers do with rays is tested by pictures; what rays find, here.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "marcher_cases.h"
#include "render/core/floating_point.h"
#include "render/march/march_setup.h"
#include "test_volumes.h"

namespace warpscope {

/// One in eleven voxels is no number.
inline FieldFunction withHoles(const FieldFunction& field) {
  return [field](const glm::ivec3& p) { return (p.x * 7 + p.y * 5 + p.z * 3) % 11 == 0 ? std::nan("") : field(p); };
}

/// A volume prepared for rays. `function` is white and opaque unless it is given.
template <class Voxel, bool kHasHoles>
struct ModeRays {
  ModeRays(VolumePtr volume, const RenderSettings& theSettings, const TransferFunction& function = everywhere(1.0f))
      : marched(std::move(volume), function),
        settings(theSettings),
        baked(bakeTransfer(marched, settings)),
        plan(planFor(marched, baked, baked.visibleCells, settings, std::nullopt)),
        view(makeVolumeView<Voxel>(marched)),
        greatest(mipFor(marched, baked.table, plan)) {
    view.voxels = marched.volume->template voxelsAs<Voxel>();
    view.transfer = baked.table.lookup();
    view.cells.distances = plan.has(PlanStage::skipping) ? baked.emptyDistances.data() : nullptr;
  }

  /// The part of a ray that is in the volume, at least `inset` behind its border.
  RayPath pathOf(const Ray& ray, float inset = 0.0f) const {
    Box bounds = marched.volume->bounds();
    bounds.lower += inset;
    bounds.upper -= inset;
    const RayInterval inside = exceptionsExpected([&] {
      return intersectBox(reciprocalOf(ray.origin, ray.direction), bounds, 0.0f,
                          std::numeric_limits<float>::infinity());
    });
    return {ray, makeLattice(inside, settings.step)};
  }

  /// Every surface along the ray that counts, near to far.
  std::vector<CountingSample> surfacesAlong(const Ray& ray) const { return surfacesAlong(pathOf(ray)); }
  std::vector<CountingSample> surfacesAlong(const RayPath& path) const {
    const ModeView<Voxel, IsosurfaceSetup> modeView{view, baked.surfaces};
    auto source =
        exceptionsExpected([&] { return IsosurfaceSource<Voxel, kHasHoles, false>(modeView, path.ray, path.lattice); });
    std::vector<CountingSample> met;
    RayColor color;
    marchRay(path, 0, path.lattice.count, source, Unlit{}, {1e-6f, 0.0f}, color, [&](const CountingSample& sample) {
      met.push_back(sample);
      return true;
    });
    return met;
  }

  GreatestValue greatestAlong(const Ray& ray) const {
    const RayPath path = pathOf(ray);
    const ModeView<Voxel, MipSetup> modeView{view, greatest};
    return exceptionsExpected([&] { return MipSource<Voxel, kHasHoles, false>(modeView, path.ray, path.lattice); })
        .find(0, path.lattice.count);
  }

  /// The interpolated value at volume coordinates, by the definition; NaN where there is none.
  double valueAt(const glm::dvec3& place) const {
    const glm::dvec3 last = glm::dvec3(view.dims - 1);
    const glm::dvec3 p =
        glm::clamp((place - glm::dvec3(view.lower)) * glm::dvec3(view.voxelsPerUnit) - 0.5, glm::dvec3(0.0), last);
    const glm::ivec3 low = glm::min(glm::ivec3(p), glm::max(view.dims - 2, glm::ivec3(0)));
    double sum = 0.0, weights = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::ivec3 upper(corner & 1, corner >> 1 & 1, corner >> 2);
      double weight = 1.0;
      for (int axis = 0; axis < 3; ++axis) weight *= upper[axis] ? p[axis] - low[axis] : 1.0 - (p[axis] - low[axis]);
      const glm::ivec3 v = glm::min(low + upper, view.dims - 1);
      const auto voxel =
          static_cast<double>(view.voxels[(static_cast<size_t>(v.z) * view.dims.y + v.y) * view.dims.x + v.x]);
      if (!std::isfinite(voxel)) continue;
      sum += weight * voxel;
      weights += weight;
    }
    return weights > 0.5 ? sum / weights : std::nan("");
  }
  double valueAt(const Ray& ray, double t) const {
    return valueAt(glm::dvec3(ray.origin) + t * glm::dvec3(ray.direction));
  }

  MarchedVolume marched;
  RenderSettings settings;
  BakedTransfer baked;
  EffectPlan plan;
  VolumeView<Voxel> view;
  MipSetup greatest;
};

/// Rays from all around, through a cube of that edge about the centre, and from inside it.
inline std::vector<Ray> raysThrough(float edge, int count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    const glm::vec3 from(unit(random), unit(random), unit(random)), to(unit(random), unit(random), unit(random));
    const glm::vec3 origin = (i % 5 == 0 ? 0.4f : 2.0f) * edge * from;
    rays.push_back({origin, glm::normalize(0.5f * edge * to - origin)});
  }
  rays.push_back({{0.3f, -0.2f, 2.0f * edge}, {0.0f, 0.0f, -1.0f}});
  return rays;
}

inline RenderSettings inMode(RenderMode mode, std::string_view isoValues = "none") {
  RenderSettings settings;
  settings.effects.mode = mode;
  settings.effects.isoValues = parseIsoValues(isoValues, "it");
  return settings;
}
inline MarchSettings marchInMode(RenderMode mode, std::string_view isoValues = "none") {
  return {inMode(mode, isoValues), {}};
}

/// Pictures and frames are the same with and without what leaves work out.
inline bool isTheSameSkipped(Marcher& marcher, const Camera& camera, MarchSettings settings) {
  settings.render.skipEmpty = true;
  const Image<glm::vec4> image = rendered(marcher, camera, settings);
  const SampleFrame frame = marcher.march(camera, settings);
  settings.render.skipEmpty = false;
  return sameBits(image, rendered(marcher, camera, settings)) && sameFrame(frame, marcher.march(camera, settings));
}

}  // namespace warpscope

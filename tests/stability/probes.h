// The functions that the suite evaluates on either backend, as plain data in and plain data out.
// Compiled by both compilers; each is one call of what it is named after.
#pragma once

#include "render/core/box.h"
#include "render/core/camera.h"
#include "render/core/pixel_grid.h"
#include "render/core/ray_sphere.h"
#include "render/core/sample.h"
#include "render/core/transfer_function.h"
#include "render/march/depth_heuristic.h"
#include "render/march/lattice.h"
#include "render/march/march.h"
#include "render/march/volume_view.h"
#include "render/volume/voxel_access.h"
#include "render/warp/lbvh/lbvh.h"

namespace warpscope {

/// intersectSphere.
struct SphereProbe {
  struct Input {
    Ray ray;
    glm::vec3 center;
    float radius;
  };
  using Output = float;
  WARPSCOPE_HD static Output evaluate(const Input& in) { return intersectSphere(in.ray, in.center, in.radius); }
};

/// intersectBox over all of a ray.
struct BoxProbe {
  struct Input {
    glm::vec3 origin, direction;
    Box box;
  };
  using Output = RayInterval;
  WARPSCOPE_HD static Output evaluate(const Input& in) {
    return intersectBox(reciprocalOf(in.origin, in.direction), in.box, 0.0f, kNoHit);
  }
};

/// The box test that culls: entryDistance of a hierarchy of that box.
struct CullProbe {
  using Input = BoxProbe::Input;
  using Output = float;
  WARPSCOPE_HD static Output evaluate(const Input& in) {
    return entryDistance(lbvhRayOf({in.origin, in.direction}, reachOf(in.box)), in.box, kNoHit);
  }
};

/// pixelRay.
struct PixelRayProbe {
  struct Input {
    Camera camera;
    glm::vec2 pixel;
  };
  using Output = Ray;
  WARPSCOPE_HD static Output evaluate(const Input& in) { return pixelRay(in.camera, in.pixel); }
};

/// project, and the same by clipFromVolume.
struct ProjectProbe {
  struct Input {
    Camera camera;
    glm::vec3 point;
    float nearDepth;
  };
  struct Output {
    Projection projection;
    glm::vec4 clip;
  };
  WARPSCOPE_HD static Output evaluate(const Input& in) {
    return {project(in.camera, in.point), clipFromVolume(in.camera, in.nearDepth) * glm::vec4(in.point, 1.0f)};
  }
};

/// A sample's way into its code and back.
struct SampleProbe {
  struct Input {
    SampleGrid grid;
    uint32_t column, row;
    float behind, radius;
  };
  struct Output {
    PackedSample packed;
    float behind, radius;
    glm::vec3 onRay;  ///< before it is clamped to the bounds
    Sphere sphere;
  };
  WARPSCOPE_HD static Output evaluate(const Input& in) {
    const SampleQuantization q{in.grid.bounds, in.grid.radiusUnit, in.grid.pixels.nearDepth, in.grid.depthStep};
    Output out{};
    out.packed = packSample(in.column, in.row, in.behind, in.radius, q);
    out.behind = decodeDepth(depthCode(out.packed), in.grid.depthStep);
    out.radius = decodeRadius(radiusCode(out.packed), in.grid.radiusUnit);
    out.onRay = in.grid.pixels.at(in.column, in.row, out.behind);
    out.sphere = unpackSample(out.packed, in.grid);
    return out;
  }
};

/// correctOpacity.
struct OpacityProbe {
  struct Input {
    float alpha, ds;
  };
  using Output = float;
  WARPSCOPE_HD static Output evaluate(const Input& in) { return correctOpacity(in.alpha, in.ds); }
};

/// makeLattice, and its i-th sample.
struct LatticeProbe {
  struct Input {
    RayInterval interval;
    float dt;
    int i;
  };
  struct Output {
    int count;
    float length, t, stepLength;
  };
  WARPSCOPE_HD static Output evaluate(const Input& in) {
    const RayLattice lattice = makeLattice(in.interval, in.dt);
    return {lattice.count, lattice.length, lattice.t(in.i), lattice.stepLength(in.i)};
  }
};

/// trilinear.
struct TrilinearProbe {
  struct Input {
    float corners[8];
    glm::vec3 weight;
  };
  using Output = float;
  WARPSCOPE_HD static Output evaluate(const Input& in) {
    return trilinear(in.corners, in.weight.x, in.weight.y, in.weight.z);
  }
};

/// The place of a ray's point in voxel coordinates.
struct VoxelPlaceProbe {
  struct Input {
    Ray ray;
    glm::vec3 lower, voxelsPerUnit;
    float t;
  };
  using Output = glm::vec3;
  WARPSCOPE_HD static Output evaluate(const Input& in) {
    VolumeView<uint8_t> view;
    view.lower = in.lower;
    view.voxelsPerUnit = in.voxelsPerUnit;
    const glm::vec3 origin = view.voxelOrigin(in.ray), direction = view.voxelDirection(in.ray);
    glm::vec3 place;
    for (int axis = 0; axis < 3; ++axis) place[axis] = mulAdd(in.t, direction[axis], origin[axis]);
    return place;
  }
};

/// marchRay through a ray whose samples are all alike.
struct MarchProbe {
  struct Input {
    float alpha;  ///< of a whole step
    float unitAlpha;
    float length, dt;
    float stopBelow;
  };
  struct Output {
    glm::vec4 premultiplied;  ///< of white, half and quarter
    double transmittance;
    int samples;
  };
  struct Homogeneous {
    static constexpr int kBatch = 8;
    float ofStep, ofUnit;
    int looked = 0;
    WARPSCOPE_HD int skip(int i) const { return i; }
    WARPSCOPE_HD uint32_t classify(int, int n) {
      looked += n;
      return ofStep > 0.0f ? (uint32_t{2} << (n - 1)) - 1 : 0;
    }
    WARPSCOPE_HD bool classifyLast() {
      ++looked;
      return ofStep > 0.0f;
    }
    WARPSCOPE_HD float alpha(int) const { return ofStep; }
    WARPSCOPE_HD float unitAlpha(int) const { return ofUnit; }
    WARPSCOPE_HD glm::vec3 color(int) const { return ofStep * glm::vec3(1.0f, 0.5f, 0.25f); }
  };
  WARPSCOPE_HD static Output evaluate(const Input& in) {
    const RayPath path{{glm::vec3(0.0f), {0.0f, 0.0f, 1.0f}}, makeLattice({0.0f, in.length}, in.dt)};
    Homogeneous source{in.alpha, in.unitAlpha};
    RayColor color;
    marchRay(path, 0, path.lattice.count, source, Unlit{}, {1.0f / 1024, in.stopBelow}, color,
             [](const CountingSample&) { return true; });
    return {color.premultiplied(), color.transmittance.exact(), source.looked};
  }
};

/// Every heuristic's depth of a ray's samples, folded at once and in two pieces.
struct FoldProbe {
  static constexpr int kSamples = 16;
  struct Input {
    int count, cut;
    float t0, dt, threshold;
    float alphas[kSamples];
  };
  struct Output {
    DepthResult whole[10], cut[10];
  };
  template <class Depth>
  WARPSCOPE_HD static void fold(const Input& in, DepthResult& whole, DepthResult& cut) {
    CountingSample samples[kSamples];
    double transmittance = 1.0;
    ProfileFold profile;
    for (int i = 0; i < in.count; ++i) {
      samples[i] = CountingSample::behind(transmittance, mulAdd(static_cast<float>(i) + 0.5f, in.dt, in.t0), in.dt,
                                          in.alphas[i]);
      transmittance *= 1.0 - static_cast<double>(in.alphas[i]);
      profile.add(samples[i]);
    }
    auto all = Depth::start(in.threshold, profile), front = all, back = all;
    for (int i = 0; i < in.count; ++i) {
      all.add(samples[i]);
      (i < in.cut ? front : back).add(samples[i]);
    }
    whole = Depth::result(all);
    cut = Depth::result(Depth::Fold::combine(front, back));
  }
  WARPSCOPE_HD static Output evaluate(const Input& in) {
    Output out{};
    fold<EntranceDepth>(in, out.whole[0], out.cut[0]);
    fold<ExitDepth>(in, out.whole[1], out.cut[1]);
    fold<MidpointDepth>(in, out.whole[2], out.cut[2]);
    fold<ThresholdDepth>(in, out.whole[3], out.cut[3]);
    fold<PeakDepth>(in, out.whole[4], out.cut[4]);
    fold<GradientDepth>(in, out.whole[5], out.cut[5]);
    fold<RelThresholdDepth>(in, out.whole[6], out.cut[6]);
    fold<EnExMeanDepth>(in, out.whole[7], out.cut[7]);
    fold<MedianDepth>(in, out.whole[8], out.cut[8]);
    fold<ExpectedDepth>(in, out.whole[9], out.cut[9]);
    return out;
  }
};

#define WARPSCOPE_FOR_EACH_PROBE(USE)                                                                  \
  USE(SphereProbe)                                                                                     \
  USE(BoxProbe) USE(CullProbe) USE(PixelRayProbe) USE(ProjectProbe) USE(SampleProbe) USE(OpacityProbe) \
      USE(LatticeProbe) USE(TrilinearProbe) USE(VoxelPlaceProbe) USE(MarchProbe) USE(FoldProbe)

}  // namespace warpscope

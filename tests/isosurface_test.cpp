// Surfaces where the field crosses their values: planes and balls in closed form, any field by brute force in double;
// their order, opacity, light; and what leaving out cells without any changes: nothing. Mirrors
// render/effects/isosurface.h and isosurface_setup.h.
#include "render/effects/isosurface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mode_rays.h"
#include "view_cells.h"
#include "render/base/error.h"
#include "render/march/ray_samples.h"

namespace warpscope {
namespace {

constexpr glm::uvec3 kDims(40, 36, 33);
constexpr double kTolerance = double{kSurfaceTolerance};

TEST(Isosurface, PlanesAreWhereTheyAre) {
  // 10 a voxel along a slanted direction: trilinear interpolation of it is exact.
  const glm::dvec3 slope(7.0, -3.0, 5.0);
  const VolumePtr volume = makeTestVolume(VoxelType::float32, kDims, [&](const glm::ivec3& p) {
    return glm::dot(slope, glm::dvec3(p) - 0.5 * (glm::dvec3(kDims) - 1.0));
  });
  for (const float step : {0.25f, 0.5f, 3.0f, 20.0f}) {
    RenderSettings settings = inMode(RenderMode::isosurface, "-20.5 31.25@0.5");
    settings.step = step;
    const ModeRays<float, false> rays(volume, settings);
    int crossings = 0;
    for (const Ray& ray : raysThrough(20.0f, 400, 3)) {
      // Beyond the outermost voxels' middles the field is constant: inside them alone it is the plane's.
      const RayPath path = rays.pathOf(ray, 0.5f);
      const double enters = double{path.lattice.t0}, leaves = enters + double{path.lattice.length},
                   along = glm::dot(slope, glm::dvec3(ray.direction));
      if (std::abs(along) < 1.0 || path.lattice.count == 0)
        continue;  // hardly any slope along the ray, and rounding decides
      std::vector<double> expected;
      bool isAtAnEnd = false;
      for (const double value : {-20.5, 31.25}) {
        const double t = (value - glm::dot(slope, glm::dvec3(ray.origin))) / along;
        isAtAnEnd = isAtAnEnd || std::min(std::abs(t - enters), std::abs(t - leaves)) < 1e-2;
        if (t > enters && t < leaves) expected.push_back(t);
      }
      if (isAtAnEnd) continue;
      std::ranges::sort(expected);
      const std::vector<CountingSample> met = rays.surfacesAlong(path);
      // One that is opaque ends the ray.
      ASSERT_LE(met.size(), expected.size());
      if (!expected.empty()) ASSERT_FALSE(met.empty());
      for (size_t i = 0; i < met.size(); ++i, ++crossings) EXPECT_NEAR(met[i].t, expected[i], kTolerance + 2e-4);
      if (met.size() < expected.size()) EXPECT_EQ(met.back().alpha, 1.0f);
    }
    EXPECT_GT(crossings, 200);
  }
}

TEST(Isosurface, OpaqueOnesEndTheirRays) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, kDims, [](const glm::ivec3& p) { return 6.0 * p.z; });
  const MarcherPtr marcher = makeCpuMarcher(volume, everywhere(0.5f));
  const Camera camera = lookingFrom({5.0f, 4.0f, 60.0f}, {}, 24, 24);
  const auto ended = [&](const char* values, bool terminatesEarly) {
    MarchSettings settings;
    settings.render = inMode(RenderMode::isosurface, values);
    settings.render.terminateEarly = terminatesEarly;
    settings.sample.segments = 4;
    const SampleFrame frame = marcher->march(camera, settings);
    size_t rays = 0;
    for (const RaySegmentCount& ray : frame.segments.rays) rays += ray.isEnded();
    EXPECT_GT(frame.size(), 100u);
    return rays == frame.size();
  };
  for (const bool terminatesEarly : {true, false}) EXPECT_TRUE(ended("100", terminatesEarly)) << "behind them nothing is known";
  EXPECT_TRUE(ended("100@0.9999", true));
  EXPECT_FALSE(ended("100@0.5", true));
}

TEST(Isosurface, BallsAreAsLargeAsTheyAre) {
  // The squared distance from the middle, of which interpolation is off by at most a quarter of a voxel's edge squared
  // along each axis.
  const glm::dvec3 middle = 0.5 * (glm::dvec3(kDims) - 1.0);
  const VolumePtr volume = makeTestVolume(VoxelType::float32, kDims, [&](const glm::ivec3& p) {
    return glm::dot(glm::dvec3(p) - middle, glm::dvec3(p) - middle);
  });
  const ModeRays<float, false> rays(volume, inMode(RenderMode::isosurface, "144@0.5"));
  int crossings = 0;
  for (const Ray& ray : raysThrough(20.0f, 400, 4)) {
    for (const CountingSample& sample : rays.surfacesAlong(ray)) {
      const double radius = glm::length(glm::dvec3(ray.origin) + double{sample.t} * glm::dvec3(ray.direction));
      // Of 144 the field has less than it should have, by 0.75 at most: its surface is that much farther inside.
      EXPECT_LE(radius, 12.0 + 2e-3);
      EXPECT_GE(radius, std::sqrt(144.0 - 0.75) - 2e-3);
      ++crossings;
    }
  }
  EXPECT_GT(crossings, 200);
  const auto met = rays.surfacesAlong({{0.0f, 0.0f, 60.0f}, {0.0f, 0.0f, -1.0f}});
  ASSERT_EQ(met.size(), 2u);
  EXPECT_NEAR(met[1].t - met[0].t, 24.0, 0.1);
}

/// Every interval of the lattice whose ends lie on different sides has a surface in it, where the field changes sides
/// within the tolerance; no other has one.
template <class Voxel, bool kHasHoles>
void expectByBruteForce(VoxelType type, const FieldFunction& field, float step, bool skips) {
  RenderSettings settings = inMode(RenderMode::isosurface, "33.3@0.1 70@0.2 10.5@0.1");
  settings.step = step;
  settings.skipEmpty = skips;
  const ModeRays<Voxel, kHasHoles> rays(makeTestVolume(type, kDims, field), settings);
  int crossings = 0, compared = 0;
  for (const Ray& ray : raysThrough(33.0f, 500, 9)) {
    const RayLattice lattice = rays.pathOf(ray).lattice;
    const std::vector<CountingSample> met = rays.surfacesAlong(ray);
    EXPECT_TRUE(std::ranges::is_sorted(met, {}, &CountingSample::t));
    size_t next = 0;
    for (int i = 0; i <= lattice.count && lattice.count > 0; ++i) {
      const auto placeOf = [&](int k) {
        return k < 0 ? lattice.t0 : k < lattice.count ? lattice.t(k) : lattice.t0 + lattice.length;
      };
      const double a = double{placeOf(i - 1)}, b = double{placeOf(i)}, atA = rays.valueAt(ray, a),
                   atB = rays.valueAt(ray, b);
      int expected = 0, uncertain = 0;
      for (const double value : {33.3, 70.0, 10.5}) {
        if (std::isfinite(atA) && std::isfinite(atB)) expected += (atA >= value) != (atB >= value) ? 1 : 0;
        uncertain += std::abs(atA - value) < 2e-3 || std::abs(atB - value) < 2e-3 ? 1 : 0;  // places are rounded
      }
      int found = 0;
      for (; next < met.size() && double{met[next].t} <= b; ++next, ++found) {
        const CountingSample& sample = met[next];
        // By dense search: some value is crossed within the tolerance.
        bool isCrossed = false;
        for (const double value : {33.3, 70.0, 10.5}) {
          const auto at = [&](double t) { return rays.valueAt(ray, std::clamp(t, a, b)) - value; };
          double least = 1e300, most = -1e300;
          for (int k = -24; k <= 24; ++k) {
            const double difference = at(double{sample.t} + k * (kTolerance + 1e-4) / 24.0);
            if (!std::isfinite(difference)) continue;
            least = std::min(least, difference), most = std::max(most, difference);
          }
          isCrossed = isCrossed || (least <= 2e-3 && most >= -2e-3);
        }
        EXPECT_TRUE(isCrossed) << nameOf(type) << " at " << sample.t;
      }
      // A root that is looked for in a hole may be lost.
      bool hasHole = false;
      for (int k = 0; kHasHoles && k <= 64; ++k) hasHole = hasHole || !std::isfinite(rays.valueAt(ray, a + (b - a) * k / 64.0));
      if (uncertain == 0 && !hasHole) {
        EXPECT_EQ(found, expected) << nameOf(type) << " " << step << " " << skips;
        compared += expected;
      }
      EXPECT_LE(found, expected + uncertain);
      crossings += found;
    }
    EXPECT_EQ(next, met.size());
  }
  EXPECT_GT(crossings, 300);
  EXPECT_GT(compared, 100);
}

TEST(Isosurface, AreWhereBruteForceFindsThem) {
  for (const bool skips : {false, true}) {
    for (const float step : {0.5f, 2.0f, 9.0f}) {
      expectByBruteForce<uint8_t, false>(VoxelType::uint8, blobs(kDims, 3), step, skips);
      expectByBruteForce<float, false>(VoxelType::float32, blobs(kDims, 5), step, skips);
    }
    expectByBruteForce<int16_t, false>(VoxelType::int16, blobs(kDims, 4), 0.5f, skips);
    expectByBruteForce<double, false>(VoxelType::float64, blobs(kDims, 4), 0.5f, skips);
    expectByBruteForce<float, true>(VoxelType::float32, withHoles(blobs(kDims, 5)), 0.5f, skips);
  }
}

TEST(Isosurface, RootsAreFoundInFewLooks) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int most = 0;
  for (int i = 0; i < 20000; ++i) {
    // A cubic, as a ray through a cell sees, or a step, which is as bad as it gets.
    const double root = unit(random) * 0.998 + 0.001, bend = 40.0 * unit(random), sharp = i % 3 == 0 ? 1e4 : 1.0;
    int looks = 0;
    const auto value = [&](float t) {
      ++looks;
      const double x = double{t} - 100.0 - root;
      return static_cast<float>(5.0 + std::tanh(sharp * (x + bend * x * x * x)));
    };
    const float atA = value(100.0f), atB = value(101.0f);
    float crossing = 0.0f;
    looks = 0;
    ASSERT_TRUE(crossingBetween(value, 5.0f, 100.0f, atA, 101.0f, atB, crossing));
    EXPECT_NEAR(double{crossing} - 100.0, root, kTolerance + 1e-5);
    most = std::max(most, looks);
  }
  EXPECT_LE(most, 3 * 11);  // a step of one unit, halved until it is below the tolerance
  float crossing = 0.0f;
  EXPECT_FALSE(crossingBetween([](float) { return std::nanf(""); }, 5.0f, 0.0f, 1.0f, 1.0f, 9.0f, crossing));
  EXPECT_TRUE(crossingBetween([](float t) { return t; }, 1e6f + 0.5f, 1e6f, 1e6f, 1e6f + 2.0f, 1e6f + 2.0f, crossing))
      << "floats are farther apart than the tolerance";
}

TEST(Isosurface, LeavingOutCellsChangesNoBit) {
  for (const VoxelType type : kAllVoxelTypes)
    for (const bool hasHoles : {false, true}) {
      if (hasHoles && type != VoxelType::float32 && type != VoxelType::float64) continue;
      const FieldFunction field = blobs(kDims, 11);
      const MarcherPtr marcher =
          makeCpuMarcher(makeTestVolume(type, kDims, hasHoles ? withHoles(field) : field), everywhere(0.0f));
      for (const char* values : {"1", "50", "80", "30@0.5 60@0.3 75@0.9"})
        for (const glm::vec3 eye : {glm::vec3(60.0f, 45.0f, 53.0f), glm::vec3(0.1f, 0.2f, 0.3f)})
          for (const float step : {0.5f, 0.37f, 7.0f})
            for (const char* planes : {"none", "1,0.3,-0.2,3 0,0,1,-9"}) {
              MarchSettings settings = marchInMode(RenderMode::isosurface, values);
              settings.render.step = step;
              settings.render.effects.clip.planes = parseClipPlanes(planes, "it");
              EXPECT_TRUE(isTheSameSkipped(*marcher, lookingFrom(eye, {0.5f, 0.0f, 0.0f}, 45, 35), settings))
                  << nameOf(type) << hasHoles << " " << values << " " << step;
            }
    }
}

/// As a device reads a volume, and as it finds samples: in passes, without keeping any.
TEST(Isosurface, CellsAndPassesGiveTheSameBits) {
  const ModeRays<uint16_t, false> rays(makeTestVolume(VoxelType::uint16, kDims, blobs(kDims, 15)),
                                       inMode(RenderMode::isosurface, "30@0.5 60@0.3 75@0.9"));
  const ViewInCells<uint16_t> inCells(rays.view);
  const VolumeView<uint16_t>& byCells = inCells.view();
  const RayLimits limits{1e-3f, 1e-3f};
  int several = 0;
  for (const Ray& ray : raysThrough(33.0f, 300, 16)) {
    const RayPath path = rays.pathOf(ray);
    const auto byVoxels = [&] {
      return IsosurfaceSource<uint16_t, false, false>({rays.view, rays.baked.surfaces}, path.ray, path.lattice);
    };
    const auto asCells = [&] {
      return IsosurfaceSource<uint16_t, false, true>({byCells, rays.baked.surfaces}, path.ray, path.lattice);
    };
    visitHeuristic(Heuristic::median, [&](auto depth) {
      RaySamples a, b;
      exceptionsExpected([&] {
        findSamples(depth, path, byVoxels, Unlit{}, limits, 0.5f, 4, a),
            findSamples(AnyDepth<true>{Heuristic::median}, path, asCells, Unlit{}, limits, 0.5f, 4, b);
      });
      ASSERT_EQ(a.size(), b.size());
      for (int i = 0; i < a.size(); ++i) {
        EXPECT_EQ(a[i].depth.depth, b[i].depth.depth);
        EXPECT_EQ(a[i].color, b[i].color);
      }
      several += a.size() > 1 ? 1 : 0;
    });
  }
  EXPECT_GT(several, 20);
}

// --- What is seen of them.

/// Values that are the distance from the middle, in voxels.
VolumePtr onion() {
  return makeTestVolume(VoxelType::float32, {41, 41, 41},
                        [](const glm::ivec3& p) { return glm::length(glm::dvec3(p) - 20.0); });
}
const TransferFunction kColors{{{0.0, {1.0f, 0.0f, 0.5f}, 0.0f},
                                {20.0, {0.0f, 1.0f, 0.5f}, 0.0f}}};  // opaque nowhere: surfaces have their own opacity
const Camera kFront = lookingFrom({0.0f, 0.0f, 60.0f}, glm::vec3(0.0f), 41, 41, 0.25f);

glm::vec4 middleOf(const MarchSettings& settings) {
  return rendered(*makeCpuMarcher(onion(), kColors), kFront, settings)(20, 20);
}

TEST(Isosurface, HaveTheFunctionsColourAndTheirOwnOpacity) {
  const glm::vec4 opaque = middleOf(marchInMode(RenderMode::isosurface, "15"));
  EXPECT_NEAR(opaque.r, 0.25f, 1e-6f);
  EXPECT_NEAR(opaque.g, 0.75f, 1e-6f);
  EXPECT_EQ(opaque.a, 1.0f);
  // Front to back: 0.5 of the outer one, then the inner one in what is left.
  const glm::vec4 both = middleOf(marchInMode(RenderMode::isosurface, "10 15@0.5"));
  EXPECT_NEAR(both.r, 0.5f * 0.25f + 0.5f * 0.5f, 1e-6f);
  EXPECT_EQ(both.a, 1.0f);
  // Through both sides.
  EXPECT_NEAR(middleOf(marchInMode(RenderMode::isosurface, "15@0.5")).a, 0.75f, 1e-6f);
  EXPECT_EQ(middleOf(marchInMode(RenderMode::isosurface, "15@0")).a, 0.0f);
  EXPECT_EQ(middleOf(marchInMode(RenderMode::isosurface, "15 10@0")), opaque);
}

TEST(Isosurface, AreLitByTheirGradient) {
  MarchSettings settings = marchInMode(RenderMode::isosurface, "15");
  const glm::vec4 unlit = middleOf(settings);
  settings.render.effects.shading = {.strength = 0.0f, .ambient = 3.0f, .diffuse = 2.0f};
  EXPECT_EQ(middleOf(settings), unlit);
  settings.render.effects.shading = {.strength = 1.0f, .ambient = 0.1f, .diffuse = 0.6f, .specular = 0.0f};
  EXPECT_NEAR(middleOf(settings).g, 0.7f * 0.75f, 1e-3f) << "it faces the eye";
  settings.render.effects.lights = parseLights("camera:1,0,0", "it");
  EXPECT_NEAR(middleOf(settings).g, 0.1f * 0.75f, 1e-2f) << "light comes from the side";
}

TEST(Isosurface, HeuristicsFoldOverSurfaces) {
  const MarcherPtr marcher = makeCpuMarcher(onion(), kColors);
  const auto depthOf = [&](Heuristic heuristic, const char* values, int samplesPerRay = 1, size_t which = 0) {
    MarchSettings settings = marchInMode(RenderMode::isosurface, values);
    settings.sample.heuristic = heuristic;
    settings.sample.samplesPerRay = samplesPerRay;
    const Camera narrow = lookingFrom({0.0f, 0.0f, 60.0f}, glm::vec3(0.0f), 1, 1, 1e-4f);
    const SampleFrame frame = marcher->march(narrow, settings);
    EXPECT_GT(frame.size(), which);
    if (frame.size() <= which) return -1.0f;
    return unpackPosition(frame.samples[which], frame.grid()).z;
  };
  const float near = 1e-2f;
  EXPECT_NEAR(depthOf(Heuristic::entrance, "10@0.5 15@0.5"), 15.0f, near);
  EXPECT_NEAR(depthOf(Heuristic::exit, "10@0.5 15@0.5"), -15.0f, near);
  EXPECT_NEAR(depthOf(Heuristic::midpoint, "10@0.5 15@0.5"), 0.0f, near);
  EXPECT_NEAR(depthOf(Heuristic::exit, "10@0.5 15"), 15.0f, near) << "an opaque one ends the ray";
  EXPECT_NEAR(depthOf(Heuristic::peak, "10@0.9 15@0.3"), 10.0f, near);
  EXPECT_NEAR(depthOf(Heuristic::gradient, "10@0.4 15@0.3"), 15.0f, near) << "0.3 against 0.7 of 0.4";
  EXPECT_NEAR(depthOf(Heuristic::threshold, "10@0.5 15@0.2"), -10.0f, near) << "0.2, 0.6 and 0.8";
  EXPECT_NEAR(depthOf(Heuristic::median, "10@0.5 15@0.5"), 15.0f, near);
  EXPECT_NEAR(depthOf(Heuristic::entrance, "10@0.5 15@0.5", 2, 0), 15.0f, near);
  EXPECT_NEAR(depthOf(Heuristic::entrance, "10@0.5 15@0.5", 2, 1), 10.0f, near) << "the second half of the opacity";
}

TEST(Isosurface, CutOffIsCutOff) {
  MarchSettings settings = marchInMode(RenderMode::isosurface, "15");
  settings.sample.heuristic = Heuristic::entrance;
  settings.render.effects.clip.planes =
      parseClipPlanes("0,0,-1,-3", "it");  // the front half is gone: the back's inside is seen
  const SampleFrame frame =
      makeCpuMarcher(onion(), kColors)->march(lookingFrom({0.0f, 0.0f, 60.0f}, glm::vec3(0.0f), 1, 1, 1e-4f), settings);
  ASSERT_EQ(frame.size(), 1u);
  EXPECT_NEAR(unpackPosition(frame.samples[0], frame.grid()).z, -15.0f, 1e-2f);
}

TEST(Isosurface, NoSurfaceInConstantVolumesAndSingleVoxels) {
  for (const glm::uvec3 dims : {glm::uvec3(1), glm::uvec3(5, 1, 1), glm::uvec3(9, 9, 9)}) {
    const MarcherPtr marcher =
        makeCpuMarcher(makeTestVolume(VoxelType::uint8, dims, [](const glm::ivec3&) { return 7.0; }), everywhere(1.0f));
    const MarchSettings settings = marchInMode(RenderMode::isosurface, "7");
    const Camera camera = lookingFrom({15.0f, 3.0f, 16.0f}, glm::vec3(0.0f), 40, 30);
    EXPECT_EQ(largestAlpha(rendered(*marcher, camera, settings)), 0.0f);
    EXPECT_EQ(marcher->march(camera, settings).size(), 0u);
    EXPECT_FALSE(marcher->plan(settings.render, std::nullopt)->has(PlanStage::march));
  }
  const MarcherPtr line = makeCpuMarcher(
      makeTestVolume(VoxelType::uint8, {5, 1, 1}, [](const glm::ivec3& p) { return 10.0 * p.x; }), everywhere(1.0f));
  const Camera along = lookingFrom({20.0f, 0.0f, 0.0f}, glm::vec3(0.0f), 11, 11, 0.05f);
  EXPECT_EQ(rendered(*line, along, marchInMode(RenderMode::isosurface, "15"))(5, 5).a, 1.0f)
      << "voxels in a line have surfaces across it";
}

TEST(Isosurface, TextsComeBackAndWhatIsWrongIsSaid) {
  for (const char* text : {"none", "300", "-1.5 1e+30@0.25 0 7@0"}) EXPECT_EQ(textOf(parseIsoValues(text, "it")), text);
  const auto refusal = [](const auto& action) -> std::string {
    try {
      action();
    } catch (const UsageError& error) {
      return error.what();
    }
    return "accepted";
  };
  const auto parsed = [&](const std::string& text) { return refusal([&] { parseIsoValues(text, "--isovalues"); }); };
  EXPECT_EQ(parsed("1 2 3 4 5"), "--isovalues: at most 4 values are possible");
  EXPECT_EQ(parsed("red"), "--isovalues: 'red': a value must be a finite number");
  EXPECT_EQ(parsed("nan"), "--isovalues: 'nan': a value must be a finite number");
  EXPECT_EQ(parsed("5@1.5"), "--isovalues: '5@1.5': the opacity must be between 0 and 1, not 1.5");
  EXPECT_THAT(parsed("5@"), testing::HasSubstr("the opacity"));
  EXPECT_THAT(parsed("@1"), testing::HasSubstr("a value must be a finite number"));

  const MarcherPtr marcher = makeCpuMarcher(onion(), kColors);
  const auto marched = [&](const char* values) {
    const MarchSettings settings = marchInMode(RenderMode::isosurface, values);
    const std::string why = refusal([&] { marcher->march(kFront, settings); });
    EXPECT_EQ(refusal([&] { rendered(*marcher, kFront, settings); }), why);
    EXPECT_EQ(refusal([&] { marcher->plan(settings.render, std::nullopt); }), why);
    return why;
  };
  EXPECT_EQ(marched("none"),
            "the mode isosurface wants the values of its surfaces: --isovalues \"VALUE[@OPACITY] ...\", or isovalues among the knobs of a scene's march");
  EXPECT_THAT(marched("5 -1"),
              testing::MatchesRegex("the iso-value -1 lies outside the volume's range, 0 to 34\\.64.*"));
  EXPECT_THAT(marched("40@0"), testing::StartsWith("the iso-value 40 lies outside"));
  EXPECT_EQ(marched("0"), "accepted");
  MarchSettings unused = marchInMode(RenderMode::composite, "1000");
  EXPECT_EQ(refusal([&] { marcher->march(kFront, unused); }), "accepted") << "what is not looked for is not looked at";
  RenderSettings textbook = inMode(RenderMode::mip);
  textbook.arithmetic = Arithmetic::textbook;
  EXPECT_THAT(refusal([&] {
                rendered(*marcher, kFront, {textbook, {}});
              }),
              testing::HasSubstr("mip has no textbook arithmetic"));
}

}  // namespace
}  // namespace warpscope

// The greatest value along rays against the definition in double, what is seen of it, and what leaving out cells that
// cannot have it changes: nothing. Mirrors render/effects/mip.h.
#include "render/effects/mip.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mode_rays.h"
#include "view_cells.h"

namespace warpscope {
namespace {

constexpr glm::uvec3 kMipDims(40, 36, 33);

/// Values from 0 to 100, all of them shown and none like another.
const TransferFunction kRamp{{{0.0, {0.0f, 1.0f, 0.2f}, 0.1f}, {100.0, {1.0f, 0.0f, 0.6f}, 0.9f}}};

template <class Voxel, bool kHasHoles>
void expectGreatest(VoxelType type, const FieldFunction& field, bool skips) {
  RenderSettings settings = inMode(RenderMode::mip);
  settings.skipEmpty = skips;
  const ModeRays<Voxel, kHasHoles> rays(makeTestVolume(type, kMipDims, field), settings, kRamp);
  for (const Ray& ray : raysThrough(33.0f, 300, 7)) {
    const RayLattice lattice = rays.pathOf(ray).lattice;
    double greatest = -1.0;
    for (int i = 0; i < lattice.count; ++i)
      greatest = std::max(greatest, rays.valueAt(ray, static_cast<double>(lattice.t(i))));  // not where it is NaN
    const GreatestValue found = rays.greatestAlong(ray);
    ASSERT_EQ(found.any, greatest >= 0.0);
    if (!found.any) continue;
    EXPECT_NEAR(found.value, greatest, 2e-3);  // places are rounded, and values rise by 100 a voxel
    EXPECT_NEAR(rays.valueAt(ray, static_cast<double>(found.t)), static_cast<double>(found.value), 2e-3);
    EXPECT_EQ(found.t, lattice.t(found.i));
  }
}

TEST(Mip, FindsTheGreatestOfTheLatticesValues) {
  for (const bool skips : {false, true}) {
    expectGreatest<uint8_t, false>(VoxelType::uint8, blobs(kMipDims, 3), skips);
    expectGreatest<int16_t, false>(VoxelType::int16, blobs(kMipDims, 4), skips);
    expectGreatest<float, false>(VoxelType::float32, blobs(kMipDims, 5), skips);
    expectGreatest<float, true>(VoxelType::float32, withHoles(blobs(kMipDims, 5)), skips);
  }
}

TEST(Mip, CellsAndVoxelsAgreeBitForBit) {
  const ModeRays<uint8_t, false> rays(makeTestVolume(VoxelType::uint8, kMipDims, blobs(kMipDims, 15)),
                                      inMode(RenderMode::mip), kRamp);
  const ViewInCells<uint8_t> inCells(rays.view);
  const VolumeView<uint8_t>& byCells = inCells.view();
  for (const Ray& ray : raysThrough(33.0f, 300, 17)) {
    const RayPath path = rays.pathOf(ray);
    const auto source = exceptionsExpected([&] {
      return MipSource<uint8_t, false, true>({byCells, rays.greatest}, path.ray, path.lattice);
    });
    const GreatestValue a = rays.greatestAlong(ray), b = source.find(0, path.lattice.count);
    EXPECT_EQ(a.any, b.any);
    EXPECT_EQ(a.value, b.value);
    EXPECT_EQ(a.t, b.t);
  }
}

TEST(Mip, OfEqualValuesTheNearest) {
  for (const bool skips : {false, true}) {
    RenderSettings settings = inMode(RenderMode::mip);
    settings.skipEmpty = skips;
    // Two walls of the same value.
    const ModeRays<uint8_t, false> rays(
        makeTestVolume(VoxelType::uint8, kMipDims,
                       [](const glm::ivec3& p) { return p.z == 6 || p.z == 25 ? 90.0 : 10.0; }),
        settings, kRamp);
    const Ray ray{{0.3f, 0.2f, -50.0f}, {0.0f, 0.0f, 1.0f}};
    const GreatestValue found = rays.greatestAlong(ray);
    const float wall = 50.0f + 6.5f - 16.5f;  // the middle of the voxel of z = 6
    EXPECT_NEAR(found.t, wall, 0.25f + 1e-4f);
    const ModeRays<uint8_t, false> flat(makeTestVolume(VoxelType::uint8, kMipDims, [](const glm::ivec3&) { return 42.0; }),
                                        settings, kRamp);
    EXPECT_EQ(flat.greatestAlong(ray).i, 0) << "everywhere the same";
    EXPECT_EQ(flat.greatestAlong(ray).value, 42.0f);
  }
}

/// Colour and opacity of a pixel are the function's at the greatest value, whatever the step.
TEST(Mip, ShowsTheFunctionAtTheGreatestValue) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, kMipDims, blobs(kMipDims, 8));
  const MarcherPtr marcher = makeCpuMarcher(volume, kRamp);
  const Camera camera = lookingFrom({50.0f, 35.0f, 60.0f}, glm::vec3(0.0f), 60, 50);
  for (const float step : {0.25f, 1.0f, 3.0f}) {
    RenderSettings settings = inMode(RenderMode::mip);
    settings.step = step;
    const ModeRays<uint8_t, false> rays(volume, settings, kRamp);
    const Image<glm::vec4> image = rendered(*marcher, camera, {settings, {}});
    const PixelGrid pixels = pixelsFor(*volume, camera, settings);
    int seen = 0;
    for (uint32_t y = 0; y < camera.height; ++y)
      for (uint32_t x = 0; x < camera.width; ++x) {
        const GreatestValue found = rays.greatestAlong(pixels.ray(x, y).ray);
        const glm::vec4 straight = found.any ? kRamp.at(static_cast<double>(found.value)) : glm::vec4(0.0f);
        const glm::vec4 expected(glm::vec3(straight) * straight.a, straight.a);
        for (int channel = 0; channel < 4; ++channel)
          EXPECT_NEAR(image(x, y)[channel], expected[channel], TransferTable::kMostVariation) << x << " " << y;
        seen += found.any ? 1 : 0;
      }
    EXPECT_GT(seen, 500);
  }
}

TEST(Mip, LeavingOutCellsChangesNoBit) {
  const TransferFunction functions[] = {kRamp,
                                        band(40.0, 60.0, 0.3f),
                                        band(95.0, 200.0, 0.7f),
                                        {{{20.0, glm::vec3(1.0f), 0.0f}, {90.0, glm::vec3(0.5f), 0.004f}}}};
  for (const VoxelType type : kAllVoxelTypes)
    for (const bool hasHoles : {false, true}) {
      if (hasHoles && type != VoxelType::float32 && type != VoxelType::float64) continue;
      const FieldFunction field = blobs(kMipDims, 11);
      const VolumePtr volume = makeTestVolume(type, kMipDims, hasHoles ? withHoles(field) : field);
      for (const TransferFunction& function : functions) {
        const MarcherPtr marcher = makeCpuMarcher(volume, function);
        for (const glm::vec3 eye : {glm::vec3(60.0f, 45.0f, 53.0f), glm::vec3(0.1f, 0.2f, 0.3f)})
          for (const float step : {0.5f, 0.37f, 7.0f})
            for (const char* planes : {"none", "1,0.3,-0.2,3 0,0,1,-9"}) {
              MarchSettings settings = marchInMode(RenderMode::mip);
              settings.render.step = step;
              settings.render.effects.clip.planes = parseClipPlanes(planes, "it");
              EXPECT_TRUE(isTheSameSkipped(*marcher, lookingFrom(eye, {0.5f, 0.0f, 0.0f}, 45, 35), settings))
                  << nameOf(type) << " " << hasHoles << " " << step;
            }
      }
    }
}

TEST(Mip, EveryHeuristicGivesTheSameFrame) {
  const MarcherPtr marcher = makeCpuMarcher(makeTestVolume(VoxelType::uint8, kMipDims, blobs(kMipDims, 12)), kRamp);
  const Camera camera = lookingFrom({50.0f, 35.0f, 60.0f}, glm::vec3(0.0f), 60, 50);
  const SampleFrame expected = marcher->march(camera, marchInMode(RenderMode::mip));
  EXPECT_GT(expected.size(), 500u);
  for (const auto& heuristic : kHeuristics)
    for (const int samplesPerRay : {1, 4}) {
      MarchSettings settings = marchInMode(RenderMode::mip);
      settings.sample.heuristic = heuristic.value;
      settings.sample.samplesPerRay = samplesPerRay;
      const SampleFrame frame = marcher->march(camera, settings);
      EXPECT_EQ(frame.samples, expected.samples) << heuristic.name;
      EXPECT_EQ(frame.colors, expected.colors) << heuristic.name;
    }
}

TEST(Mip, IsNotLitAndDoesNotCareForTheStepsOpacity) {
  const MarcherPtr marcher = makeCpuMarcher(makeTestVolume(VoxelType::uint8, kMipDims, blobs(kMipDims, 13)), kRamp);
  const Camera camera = lookingFrom({50.0f, 35.0f, 60.0f}, glm::vec3(0.0f), 60, 50);
  MarchSettings settings = marchInMode(RenderMode::mip);
  const Image<glm::vec4> unlit = rendered(*marcher, camera, settings);
  settings.render.effects.shading.strength = 1.0f;
  EXPECT_TRUE(sameBits(unlit, rendered(*marcher, camera, settings)));
  settings.render.terminateEarly = false;
  EXPECT_TRUE(sameBits(unlit, rendered(*marcher, camera, settings)));
  EXPECT_FALSE(sameBits(unlit, rendered(*marcher, camera, {})));
}

TEST(Mip, AGreatestValueThatIsHiddenHidesItsRay) {
  // A wall of 90 with one of 50 in front of it; 50 alone is shown.
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, kMipDims, [](const glm::ivec3& p) {
    return p.z == 20 ? (p.x < 20 ? 90.0 : 0.0) : p.z == 30 ? 50.0 : 0.0;
  });
  const MarcherPtr marcher = makeCpuMarcher(volume, band(45.0, 55.0, 0.5f));
  MarchSettings settings = marchInMode(RenderMode::mip);
  settings.render.step = 0.01f;  // so that one lies at the voxel's middle, nearly
  const Image<glm::vec4> image =
      rendered(*marcher, lookingFrom({0.0f, 0.0f, 400.0f}, glm::vec3(0.0f), 40, 40, 0.045f), settings);
  EXPECT_EQ(image(8, 20).a, 0.0f);
  EXPECT_NEAR(image(32, 20).a, 0.5f, 1e-2f);
}

TEST(Mip, NothingConstantAndSingleVoxels) {
  const Camera camera = lookingFrom({5.0f, 3.0f, 6.0f}, glm::vec3(0.0f), 40, 30);
  const auto alphaOf = [&](const glm::uvec3& dims, double value, const TransferFunction& function) {
    const MarcherPtr marcher =
        makeCpuMarcher(makeTestVolume(VoxelType::float32, dims, [=](const glm::ivec3&) { return value; }), function);
    EXPECT_TRUE(isTheSameSkipped(*marcher, camera, marchInMode(RenderMode::mip)));
    return largestAlpha(rendered(*marcher, camera, marchInMode(RenderMode::mip)));
  };
  for (const glm::uvec3 dims : {glm::uvec3(1), glm::uvec3(4, 1, 1), glm::uvec3(3, 3, 3)}) {
    EXPECT_NEAR(alphaOf(dims, 7.0, everywhere(0.25f)), 0.25f, 1e-6f);
    EXPECT_EQ(alphaOf(dims, 7.0, everywhere(0.0f)), 0.0f);
    EXPECT_EQ(alphaOf(dims, std::nan(""), everywhere(0.25f)), 0.0f);
  }
}

}  // namespace
}  // namespace warpscope

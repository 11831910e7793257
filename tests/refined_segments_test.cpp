// What a copy of the volume with all of its voxels adds to segments: where pixels disagree, what is there.
// Mirrors render/warp/segments/between.h, render/warp/segments/pixel_views.h, render/warp/proxy_fill.h and render/march/proxy_march.h.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "marcher_cases.h"
#include "render/march/lattice.h"
#include "render/metrics/psnr.h"
#include "render/warp/fill.h"
#include "render/warp/proxy_fill.h"
#include "render/warp/segments/pixel_views.h"
#include "render/warp/segments_warp.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

const glm::uvec3 kLumpDims(48, 44, 40);
const Camera kLumpServer = lookingFrom({30.0f, 25.0f, 75.0f}, glm::vec3(0.0f), 160, 120, 0.45f);
/// Two degrees beside it.
const Camera kLumpViewer = lookingFrom({32.6f, 25.0f, 73.9f}, glm::vec3(0.0f), 160, 120, 0.45f);

MarcherPtr lumpMarcher(VoxelType type = VoxelType::uint8, double factor = 1.0) {
  const FieldFunction lumps = blobs(kLumpDims, 11);
  const TransferFunction function{{{15.0 * factor, {0.2f, 0.4f, 1.0f}, 0.0f}, {40.0 * factor, {0.9f, 0.8f, 0.3f}, 0.6f}, {80.0 * factor, {1.0f, 0.3f, 0.1f}, 0.95f}}};
  return makeCpuMarcher(makeTestVolume(type, kLumpDims, [=](const glm::ivec3& p) { return factor * lumps(p); }), function);
}

MarchSettings withCopy(int longest, float shading = 0.0f) {
  MarchSettings settings;
  settings.sample.segments = 4;
  settings.sample.proxy = longest;
  settings.render.effects.shading.strength = shading;
  return settings;
}

WarpSettings between(Between kind, Fill fill = Fill::automatic) {
  WarpSettings settings;
  settings.knobs.set(kBetweenKnob, kind);
  settings.knobs.set(kFillKnob, fill);
  return settings;
}

WarpedImage drawnFrom(Marcher& marcher, const MarchSettings& settings, const Camera& camera, const WarpSettings& warp) {
  const std::unique_ptr<Warp> technique = kSegmentsWarp.make({});
  technique->setFrame(std::make_shared<const SampleFrame>(marcher.march(kLumpServer, settings)), warp);
  WarpedImage image;
  technique->draw(camera, warp, image);
  return image;
}

double errorDb(Marcher& marcher, const MarchSettings& settings, const WarpedImage& image) {
  Image<glm::vec4> reference;
  marcher.render(kLumpViewer, settings.render, reference);
  return psnrSrgb(image.color, reference, glm::vec3(0.0f));
}

TEST(RefinedSegments, AreNearerToTheVolumeThanBlendedOnes) {
  for (const float shading : {0.0f, 1.0f})
    for (const RenderMode mode : {RenderMode::composite, RenderMode::isosurface}) {
      MarchSettings settings = withCopy(48, shading);
      settings.render.effects.mode = mode;
      settings.render.effects.isoValues = parseIsoValues("45", "it");
      const MarcherPtr marcher = lumpMarcher();
      const double blended = errorDb(*marcher, settings, drawnFrom(*marcher, settings, kLumpViewer, between(Between::linear)));
      EXPECT_GT(errorDb(*marcher, settings, drawnFrom(*marcher, settings, kLumpViewer, between(Between::refined))), blended + (mode == RenderMode::composite ? 5.0 : 2.0)) << shading << ", " << static_cast<int>(mode);
    }
}

TEST(RefinedSegments, AreBlendedOnesWithoutACopyThatShowsTheVolume) {
  const auto expectBlended = [](const char* what, const MarcherPtr& marcher, const MarchSettings& settings, Fill fill = Fill::automatic) {
    const WarpedImage refined = drawnFrom(*marcher, settings, kLumpViewer, between(Between::refined, fill)), blended = drawnFrom(*marcher, settings, kLumpViewer, between(Between::linear, fill));
    EXPECT_TRUE(refined.color == blended.color && refined.samples == blended.samples) << what;
  };
  const MarcherPtr marcher = lumpMarcher();
  expectBlended("coarse", marcher, withCopy(47));
  expectBlended("none", marcher, withCopy(0));
  expectBlended("not used", marcher, withCopy(48), Fill::none);
  expectBlended("not used, pulled", marcher, withCopy(48), Fill::pullPush);
  MarchSettings settings = withCopy(48);
  settings.render.effects.mode = RenderMode::mip;
  expectBlended("greatest values", marcher, settings);
  settings = withCopy(48);
  settings.render.effects.preIntegration = true;
  expectBlended("steps by both ends", marcher, settings);
  settings = withCopy(48, 1.0f);
  settings.render.effects.shadows.occlusion = 1.0f;
  expectBlended("in shadow", marcher, settings);
  expectBlended("rounded", lumpMarcher(VoxelType::uint16, 500.0), withCopy(48));
  expectBlended("fractions", lumpMarcher(VoxelType::float32), withCopy(48));
}

/// In the server's own view, and so near to it that each ray is as good as a pixel's.
TEST(RefinedSegments, WhereRaysArePixelsNothingDisagrees) {
  const MarcherPtr marcher = lumpMarcher();
  for (const float aside : {0.0f, 1e-4f}) {
    const Camera camera = lookingFrom({30.0f + aside, 25.0f, 75.0f}, glm::vec3(0.0f), 160, 120, 0.45f);
    EXPECT_TRUE(drawnFrom(*marcher, withCopy(48), camera, between(Between::refined)).color == drawnFrom(*marcher, withCopy(48), camera, between(Between::linear)).color) << aside;
  }
}

/// What pixels disagree about, the frame knows: it is no guess, and not counted as filled.
TEST(RefinedSegments, AreNotGuesses) {
  MarchSettings settings = withCopy(48);
  settings.render.terminateEarly = false;
  const MarcherPtr marcher = lumpMarcher();
  const WarpedImage refined = drawnFrom(*marcher, settings, kLumpViewer, between(Between::refined)), blended = drawnFrom(*marcher, settings, kLumpViewer, between(Between::linear));
  const auto filled = [](const WarpedImage& image) {
    return std::count_if(image.samples.begin(), image.samples.end(), [](uint32_t id) { return id == kFilled; });
  };
  EXPECT_FALSE(refined.color == blended.color);
  EXPECT_LE(filled(refined), filled(blended));
}

TEST(RefinedSegments, PixelsDisagreeByTheirLargestDifference) {
  PixelViews<float> views;
  float left[4] = {1.0f, 1.0f, 1.0f, 1.0f};
  views.clear();
  EXPECT_EQ(views.disagreement(left), 0.0f);  // of none
  views.asked[1] = 1.0f;
  views.color[1][2] = 0.7f;
  views.color[3][1] = 5.0f;  // is not asked
  left[1] = 0.25f;
  EXPECT_EQ(views.disagreement(left), 0.0f);  // of one with itself
  views.asked[2] = 1.0f;
  views.color[2][2] = 0.2f;
  left[2] = 0.75f;
  EXPECT_FLOAT_EQ(views.disagreement(left), 0.5f);
  left[2] = 0.95f;
  EXPECT_FLOAT_EQ(views.disagreement(left), 0.7f);
}

/// Parts of a ray that follow each other have each of its samples once, and each of its surfaces.
TEST(ProxyMarch, PartsAreTheWhole) {
  const MarcherPtr marcher = lumpMarcher();
  for (const RenderMode mode : {RenderMode::composite, RenderMode::isosurface})
    for (const bool isCut : {false, true}) {
      MarchSettings settings = withCopy(20, isCut ? 1.0f : 0.0f);
      settings.render.terminateEarly = false;
      settings.render.effects.mode = mode;
      settings.render.effects.isoValues = parseIsoValues("45@0.5", "it");
      if (isCut) settings.render.effects.clip.planes = parseClipPlanes("1,0.2,0,0", "it");
      const SampleFrame frame = marcher->march(kLumpServer, settings);
      ProxyFill fill;
      std::mt19937 random(5);
      std::uniform_real_distribution<float> unit(0.0f, 1.0f);
      int met = 0, otherwise = 0;
      fill.visit(frame.proxy, frame.settings.render, kLumpServer, [&](const auto& march, const auto&) {
        const PixelGrid pixels = makePixelGrid(kLumpServer, depthRangeOf(kLumpServer, march.clip.bounds).nearDepth);
        for (uint32_t pixel = 0; pixel < 160 * 120; pixel += 37) {
          const Ray ray = pixels.ray(pixel % 160, pixel / 160).ray;
          const RayLight whole = march(ray, 0.0f, std::numeric_limits<float>::infinity(), 1.0f);
          std::vector<float> ends{0.0f, std::numeric_limits<float>::infinity()};
          for (int i = 0; i < 30; ++i) ends.push_back(150.0f * unit(random));
          std::ranges::sort(ends);
          glm::dvec3 color(0.0);
          double through = 1.0;
          for (size_t i = 1; i < ends.size(); ++i) {
            const RayLight part = march(ray, ends[i - 1], ends[i], 1.0f);
            color += through * glm::dvec3(part.color);
            through *= part.transmittance;
          }
          const double off = std::abs(through - whole.transmittance) + glm::length(color - glm::dvec3(whole.color));
          // A surface that is crossed twice between two samples is not seen: there parts have other samples.
          if (mode == RenderMode::isosurface && off > 1e-4) {
            ++otherwise;
            continue;
          }
          EXPECT_LT(off, 1e-5);
          met += whole.transmittance < 0.9;
        }
      });
      EXPECT_GT(met, 8);
      EXPECT_LE(otherwise, met / 4);
    }
}

TEST(Lattice, SamplesFromAPlaceOn) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 2000; ++i) {
    const float t0 = 100.0f * unit(random);
    const RayLattice lattice = makeLattice({t0, t0 + 50.0f * unit(random)}, 0.1f + unit(random));
    const float place = t0 + 60.0f * unit(random) - 5.0f;
    const int first = lattice.firstFrom(place);
    const float rounding = 1e-6f * (t0 + 60.0f);
    ASSERT_TRUE(first >= 0 && first <= lattice.count);
    if (first > 0 && place < lattice.t0 + lattice.length) EXPECT_LT(lattice.tOfWholeStep(first - 1), place + rounding);
    if (first < lattice.count) EXPECT_GE(lattice.tOfWholeStep(first), place - rounding);
  }
  const RayLattice lattice = makeLattice({2.0f, 12.0f}, 1.0f);
  EXPECT_EQ(lattice.firstFrom(-INFINITY), 0);
  EXPECT_EQ(lattice.firstFrom(INFINITY), 10);
  EXPECT_EQ(lattice.firstFrom(NAN), 10);
  EXPECT_EQ(lattice.firstFrom(4.5f), 2);  // where one lies
  EXPECT_EQ(lattice.firstFrom(4.6f), 3);
  EXPECT_EQ(makeLattice({}, 1.0f).firstFrom(0.0f), 0);
  // As many steps as there may be, and far more.
  EXPECT_EQ(makeLattice({0.0f, 1e30f}, 1e-3f).firstFrom(9e29f), kMaxSamplesPerRay);
}

}  // namespace
}  // namespace warpscope

// How far depths are spread along their rays: against sums in double over the definition, in every mode, of one sample a ray and of several.
// Mirrors render/march/depth_heuristic.h (MomentsFold), the plane kSpreadPlane and the stage `spread` of the plan.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "heuristic_cases.h"
#include "marcher_cases.h"
#include "render/march/compact.h"
#include "render/march/sample_radius.h"
#include "test_volumes.h"
#include "tests/frame_samples.h"

namespace warpscope {
namespace {

/// What spreads are rounded by, and a little for what marches round, relative to them.
constexpr double kRounded = 0x1p-8 + 2e-4;

std::vector<float> spreadsOf(const SampleFrame& frame) {
  const SamplePlane* const plane = frame.plane(kSpreadPlane);
  if (plane == nullptr || plane->element != PlaneElement::float32) throw std::runtime_error("no spreads");
  std::vector<float> spreads(plane->values.size() / sizeof(float));
  std::memcpy(spreads.data(), plane->values.data(), plane->values.size());
  return spreads;
}

MarchSettings spreading(int samplesPerRay = 1) {
  MarchSettings settings;
  settings.sample.sendsSpread = true;
  settings.sample.samplesPerRay = samplesPerRay;
  return settings;
}

/// Weighted standard deviation of places, as the definition has it.
double deviation(const std::vector<std::pair<double, double>>& weightsAndPlaces) {
  double weight = 0.0, mean = 0.0, squares = 0.0;
  for (const auto& [w, t] : weightsAndPlaces) weight += w, mean += w * t;
  mean /= weight;
  for (const auto& [w, t] : weightsAndPlaces) squares += w * (t - mean) * (t - mean);
  return std::sqrt(squares / weight);
}

/// One ray along z through the middle, nearly parallel to it at all pixels.
Camera alongAxis(uint32_t side = 1) { return lookingFrom({0.0f, 0.0f, 60.0f}, glm::vec3(0.0f), side, side, 1e-3f); }

MarcherPtr softMarcher(VoxelType type = VoxelType::uint8) {
  const glm::uvec3 dims(30, 28, 26);
  return makeCpuMarcher(makeTestVolume(type, dims, blobs(dims, 11)), {{{20.0, glm::vec3(1.0f), 0.0f}, {60.0, glm::vec3(1.0f), 0.3f}}});
}

const Camera kCorner = lookingFrom({40.0f, 30.0f, 35.0f}, glm::vec3(0.0f), 61, 47);

TEST(DepthSpread, OfAHazeItIsTheDefinitions) {
  constexpr int kDepth = 20;
  for (const float alpha : {0.01f, 0.1f, 0.5f, 0.95f})
    for (const float step : {1.0f, 0.25f}) {
      const MarcherPtr marcher = makeCpuMarcher(makeTestVolume(VoxelType::uint8, {9, 9, kDepth}, [](const glm::ivec3&) { return 50.0; }), everywhere(alpha));
      MarchSettings settings = spreading();
      settings.render.step = step;
      const SampleFrame frame = marcher->march(alongAxis(), settings);
      ASSERT_EQ(frame.size(), 1u);
      std::vector<std::pair<double, double>> counting;
      const double ofStep = 1.0 - std::pow(1.0 - static_cast<double>(alpha), static_cast<double>(step));
      double transmittance = 1.0;
      for (int i = 0; i < static_cast<int>(kDepth / step); ++i) {
        if (ofStep * transmittance >= static_cast<double>(settings.render.contribution)) counting.push_back({ofStep * transmittance, (i + 0.5) * step});
        transmittance *= 1.0 - ofStep;
      }
      const double expected = deviation(counting);
      EXPECT_NEAR(spreadsOf(frame)[0], expected, kRounded * expected) << alpha << ", " << step;
    }
}

TEST(DepthSpread, IsRoundedToEightBits) {
  for (const float spread : spreadsOf(softMarcher()->march(kCorner, spreading()))) EXPECT_EQ(std::bit_cast<uint32_t>(spread) & 0xffffu, 0u);
  SampleFrame frame;
  const std::vector<float> lengths{0.0f, 1.0f, 1.00390625f, 1.0f + 0x1p-9f, 1.999f, 3e-38f, 2.5e38f};
  TransferVector<std::byte> bytes(lengths.size() * sizeof(float));
  std::memcpy(bytes.data(), lengths.data(), bytes.size());
  setSpreads(std::move(bytes), frame);
  const std::vector<float> rounded = spreadsOf(frame);
  for (size_t i = 0; i < lengths.size(); ++i) EXPECT_NEAR(rounded[i], lengths[i], 0x1p-8 * static_cast<double>(lengths[i]));
  EXPECT_EQ(rounded[4], 2.0f);
}

TEST(DepthSpread, OfTwoWallsItIsWhatTheFirstHidesOfTheSecond) {
  // A veil around z = 20 and an opaque wall at z = 4, between which there is nothing.
  const auto walls = [](const glm::ivec3& p) { return std::abs(p.z - 20) <= 1 ? 30.0 : p.z <= 4 ? 100.0 : 0.0; };
  const MarcherPtr marcher = makeCpuMarcher(makeTestVolume(VoxelType::uint8, {9, 9, 25}, walls),
                                            {{{29.0, glm::vec3(1.0f), 0.0f}, {30.0, glm::vec3(1.0f), 0.3f}, {31.0, glm::vec3(1.0f), 0.0f},
                                              {90.0, glm::vec3(1.0f), 0.0f}, {90.0, glm::vec3(1.0f), 1.0f}}});
  MarchSettings settings = spreading();
  settings.render.step = 0.1f;
  settings.sample.heuristic = Heuristic::expected;
  const SampleFrame frame = marcher->march(alongAxis(), settings);
  ASSERT_EQ(frame.size(), 1u);
  // Whatever the veil's opacity comes to, a: the mean tells it, and the spread is distance * sqrt(a (1 - a)).
  const double front = 60.0 - 8.0, back = 60.0 + 7.9;  // where the veil and the wall's front are, the volume's middle at 0
  const Sphere sphere = sphereOf(frame, 0);
  const double mean = 60.0 - static_cast<double>(sphere.center.z);
  const double share = (back - mean) / (back - front);
  ASSERT_GT(share, 0.05);
  ASSERT_LT(share, 0.95);
  EXPECT_NEAR(spreadsOf(frame)[0], (back - front) * std::sqrt(share * (1.0 - share)), 0.02 * (back - front) * 0.5) << "the veil's own thickness, and rounding, are less";
}

TEST(DepthSpread, WhereOneSampleCountsThereIsNone) {
  const MarcherPtr marcher = makeCpuMarcher(makeTestVolume(VoxelType::uint8, {9, 9, 9}, [](const glm::ivec3&) { return 50.0; }), everywhere(1.0f));
  EXPECT_THAT(spreadsOf(marcher->march(alongAxis(8), spreading())), testing::Each(0.0f));
}

TEST(DepthSpread, DoesNotDependOnWhatStandsForARay) {
  const MarcherPtr marcher = softMarcher();
  MarchSettings settings = spreading();
  const std::vector<float> expected = spreadsOf(marcher->march(kCorner, settings));
  EXPECT_GT(*std::max_element(expected.begin(), expected.end()), 1.0f);
  for (const Heuristic heuristic : everyHeuristic()) {
    settings.sample.heuristic = heuristic;
    EXPECT_EQ(spreadsOf(marcher->march(kCorner, settings)), expected) << nameOf(heuristic);
  }
}

TEST(DepthSpread, ChangesNothingElse) {
  const MarcherPtr marcher = softMarcher();
  for (const int count : {1, 3}) {
    MarchSettings settings = spreading(count);
    SampleFrame with = marcher->march(kCorner, settings);
    settings.sample.sendsSpread = false;
    const SampleFrame without = marcher->march(kCorner, settings);
    EXPECT_EQ(without.plane(kSpreadPlane), nullptr);
    EXPECT_EQ(spreadsOf(with).size(), with.size());
    std::erase_if(with.planes, [](const SamplePlane& plane) { return plane.name == kSpreadPlane; });
    EXPECT_TRUE(sameFrame(with, without));
  }
}

/// The radius policy that asks for it: in one mode after the other, sent or not.
TEST(DepthSpread, RadiiOfUncertaintyAreIt) {
  const MarcherPtr marcher = softMarcher();
  const auto voxel = static_cast<double>(0.5f * glm::length(marcher->volume()->geometry().voxelEdges()));
  for (const int count : {1, 3})
    for (const float scale : {1.0f, 0.5f})
      for (const RenderMode mode : {RenderMode::composite, RenderMode::isosurface, RenderMode::mip}) {
        SCOPED_TRACE(::testing::Message() << count << ", " << scale << ", " << nameOf(mode));
        MarchSettings settings = spreading(count);
        settings.sample.radiusPolicy = RadiusPolicy::uncertainty;
        settings.sample.radiusScale = scale;
        settings.render.effects.mode = mode;
        settings.render.effects.isoValues = parseIsoValues("30@0.25 50@1", "it");
        EXPECT_EQ(marcher->plan(settings.render, settings.sample)->has(PlanStage::spread), mode != RenderMode::mip);
        const SampleFrame frame = marcher->march(kCorner, settings);
        ASSERT_GT(frame.size(), 100u);
        const std::vector<float> spreads = spreadsOf(frame);
        size_t between = 0;
        for (size_t i = 0; i < frame.size(); ++i) {
          const Sphere sphere = sphereOf(frame, i);
          const double largest = static_cast<double>(kLargestRadiusByDepth * glm::dot(sphere.center - frame.camera.eye, frame.camera.forward));
          const double expected = static_cast<double>(scale) * std::min(largest, std::clamp(static_cast<double>(spreads[i]), voxel, 2.0 * voxel));
          ASSERT_NEAR(sphere.radius, expected, (1.0 / 64 + kRounded) * expected) << i;
          if (sphere.radius > 1.1 * static_cast<double>(scale) * voxel) ++between;
        }
        EXPECT_EQ(between > 0, mode != RenderMode::mip);
        settings.sample.sendsSpread = false;
        const SampleFrame unsent = marcher->march(kCorner, settings);
        EXPECT_TRUE(std::ranges::equal(unsent.samples, frame.samples));
        EXPECT_EQ(unsent.plane(kSpreadPlane), nullptr);
      }
}

/// The law of total variance: what parts have inside of them and between their means is the whole's.
TEST(DepthSpread, OfPartsAndBetweenThemIsTheWholes) {
  const MarcherPtr marcher = softMarcher();
  MarchSettings settings = spreading();
  settings.sample.heuristic = Heuristic::expected;
  const SampleFrame whole = marcher->march(kCorner, settings);
  settings.sample.samplesPerRay = 4;
  const SampleFrame parts = marcher->march(kCorner, settings);
  const std::vector<float> ofWhole = spreadsOf(whole), ofParts = spreadsOf(parts);
  const auto depthOf = [](const SampleFrame& frame, size_t i) { return glm::length(glm::dvec3(sphereOf(frame, i).center) - glm::dvec3(frame.camera.eye)); };
  size_t divided = 0;
  for (size_t ray = 0, i = 0; i < parts.size(); ++ray) {
    const size_t end = endOfRay(parts.layers(), i);
    if (end - i > 1) ++divided;
    double weight = 0.0, mean = 0.0, inside = 0.0, between = 0.0, transmittance = 1.0;
    std::vector<std::pair<double, double>> means;
    for (; i < end; ++i) {
      const double alpha = static_cast<double>(parts.colors[i] >> 24) / 255.0, w = alpha * transmittance;
      transmittance *= 1.0 - alpha;
      means.push_back({w, depthOf(parts, i)});
      inside += w * static_cast<double>(ofParts[i]) * static_cast<double>(ofParts[i]);
      weight += w;
      mean += w * depthOf(parts, i);
    }
    if (!(weight > 0.1)) continue;  // of fewer, 8 bits of opacity say too little
    for (const auto& [w, t] : means) between += w * (t - mean / weight) * (t - mean / weight);
    EXPECT_NEAR(std::sqrt((inside + between) / weight), static_cast<double>(ofWhole[ray]), 0.06 + 0.03 * static_cast<double>(ofWhole[ray])) << ray;
  }
  EXPECT_GT(divided, 200u);
}

TEST(DepthSpread, OfSurfacesItIsBetweenThem) {
  const auto slope = [](const glm::ivec3& p) { return 4.0 * p.z; };  // 80 at z = 20, 20 at z = 5
  const MarcherPtr marcher = makeCpuMarcher(makeTestVolume(VoxelType::uint8, {9, 9, 25}, slope), everywhere(0.5f));
  MarchSettings settings = spreading();
  settings.render.effects.mode = RenderMode::isosurface;
  settings.render.effects.isoValues = parseIsoValues("80@0.25 20@1", "it");
  const SampleFrame frame = marcher->march(alongAxis(), settings);
  ASSERT_EQ(frame.size(), 1u);
  EXPECT_NEAR(spreadsOf(frame)[0], 15.0 * std::sqrt(0.25 * 0.75), kRounded * 15.0);
}

TEST(DepthSpread, AGreatestValuesDepthIsCertain) {
  const MarcherPtr marcher = softMarcher();
  for (const Heuristic heuristic : everyHeuristic()) {
    MarchSettings settings = spreading(3);
    settings.sample.heuristic = heuristic;
    settings.render.effects.mode = RenderMode::mip;
    EXPECT_FALSE(marcher->plan(settings.render, settings.sample)->has(PlanStage::spread));
    const SampleFrame frame = marcher->march(kCorner, settings);
    ASSERT_GT(frame.size(), 100u);
    EXPECT_THAT(spreadsOf(frame), testing::Each(0.0f));
  }
}

TEST(DepthSpread, IsFiniteAndNoLongerThanHalfTheVolume) {
  for (const VoxelType type : kAllVoxelTypes)
    for (const bool integrates : {false, true})
      for (const int count : {1, 8}) {
        MarchSettings settings = spreading(count);
        settings.render.effects.preIntegration = integrates;
        for (const float spread : spreadsOf(softMarcher(type)->march(kCorner, settings))) {
          EXPECT_GE(spread, 0.0f);
          EXPECT_LE(spread, 0.5f * std::sqrt(30.0f * 30.0f + 28.0f * 28.0f + 26.0f * 26.0f));
        }
      }
}

}  // namespace
}  // namespace warpscope

// Several samples a ray: where it is cut, that its parts over one another are the ray, order, and that the marchers
// agree. Mirrors render/march/ray_samples.h, and what the CPU's marcher and compact.h make of it.
#include "render/march/ray_samples.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "heuristic_cases.h"
#include "made_up_source.h"
#include "marcher_cases.h"
#include "render/base/error.h"
#include "render/march/march_setup.h"
#include "render/march/volume_source_scalar.h"
#include "test_volumes.h"
#include "tests/frame_samples.h"

namespace warpscope {
namespace {

constexpr uint32_t kSeed = 2023;
constexpr RayLimits kLimits{1.0f / 1024, 1.0f / 1024};
constexpr float kThreshold = 0.8f;

struct TestRay {
  RayPath path;
  std::vector<float> alphas;

  MadeUpSource<1> source() const {
    return {[this](int i) { return alphas[static_cast<size_t>(i)]; }, path.lattice};
  }
  RayColor color(std::vector<CountingSample>* counting = nullptr) const {
    RayColor gathered;
    MadeUpSource<1> from = source();
    marchRay(path, 0, path.lattice.count, from, Unlit{}, kLimits, gathered, [&](const CountingSample& sample) {
      if (counting != nullptr) counting->push_back(sample);
      return true;
    });
    return gathered;
  }
};

TestRay rayOf(std::vector<float> alphas) {
  return {alongZ(latticeOf(2.0f, 0.5f * static_cast<float>(alphas.size()), 0.5f)), std::move(alphas)};
}

TestRay randomRay(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const float scale = std::exp2(-8.0f * unit(random));
  std::vector<float> alphas(1 + random() % 200);
  for (float& alpha : alphas) alpha = random() % 3 ? std::min(1.0f, 2.0f * scale * unit(random)) : 0.0f;
  return rayOf(std::move(alphas));
}

template <class Depth>
RaySamples samplesOf(const TestRay& ray, int count) {
  RaySamples found;
  findSamples(
      Depth{}, ray.path, [&] { return ray.source(); }, Unlit{}, kLimits, kThreshold, count, found);
  return found;
}

glm::dvec4 composited(const RaySamples& samples) {
  glm::dvec4 sum(0.0);
  for (int i = 0; i < samples.size(); ++i) sum += (1.0 - sum.a) * glm::dvec4(samples[i].color);
  return sum;
}

template <class Depth>
DepthResult depthBy(const std::vector<CountingSample>& counting) {
  ProfileFold profile;
  for (const CountingSample& sample : counting) profile.add(sample);
  auto fold = Depth::start(kThreshold, profile);
  for (const CountingSample& sample : counting) fold.add(sample);
  return Depth::result(fold);
}

TEST(RayParts, ASampleIsInThePartInWhichItBegins) {
  const RayParts parts{0.8f, 4};
  EXPECT_EQ(parts.partOf(0.0f, 0), 0);
  EXPECT_EQ(parts.partOf(std::nextafter(0.2f, 0.0f), 0), 0);
  EXPECT_EQ(parts.partOf(0.2f, 0), 1);
  EXPECT_EQ(parts.partOf(0.7f, 0), 3);  // over parts in which none begins
  EXPECT_EQ(parts.partOf(0.8f, 0), 3);  // never past the last
  EXPECT_EQ(parts.partOf(0.1f, 2), 2);  // never back
  EXPECT_EQ((RayParts{0.8f, 1}.partOf(0.8f, 0)), 0);
}

TEST(RaySamples, PartsOfAHomogeneousRayHaveEqualShares) {
  const TestRay ray = rayOf(std::vector<float>(100, 0.02f));
  const double whole = ray.color().premultiplied().a;
  for (const int count : {2, 3, 4, 8}) {
    const RaySamples found = samplesOf<MidpointDepth>(ray, count);
    ASSERT_EQ(found.size(), count);
    double before = 0.0;
    for (int i = 0; i < count; ++i) {
      const double share = (1.0 - before) * found[i].color.a;
      EXPECT_NEAR(share, whole / count, 0.021) << i << " of " << count;  // a sample's contribution
      before += share;
    }
    EXPECT_NEAR(before, whole, 1e-6);
  }
}

TEST(RaySamples, AWallIsOneSampleAndNothingIsNone) {
  for (const int count : {1, 2, 8}) {
    const RaySamples wall = samplesOf<GradientDepth>(rayOf({0.0f, 0.0f, 1.0f, 1.0f}), count);
    ASSERT_EQ(wall.size(), 1);
    EXPECT_EQ(wall[0].depth.depth, 3.25f);
    EXPECT_EQ(wall[0].color, glm::vec4(1.0f, 0.5f, 0.25f, 1.0f));
    EXPECT_EQ(samplesOf<GradientDepth>(rayOf({0.0f, 0.0f}), count).size(), 0);
    EXPECT_EQ(samplesOf<GradientDepth>(rayOf({1e-5f, 1e-5f}), count).size(), 0);  // nothing counts
  }
}

TEST(RaySamples, WhatWasFoundBeforeIsForgotten) {
  RaySamples found = samplesOf<GradientDepth>(rayOf(std::vector<float>(40, 0.1f)), 8);
  ASSERT_GT(found.size(), 1);
  for (const std::vector<float>& alphas : {std::vector<float>{0.0f, 1.0f}, std::vector<float>{0.0f, 0.0f}}) {
    const TestRay ray = rayOf(alphas);
    findSamples(
      GradientDepth{}, ray.path, [&] { return ray.source(); }, Unlit{}, kLimits, kThreshold, 8, found);
    EXPECT_EQ(found.size(), samplesOf<GradientDepth>(ray, 8).size());
  }
}

TEST(RaySamples, WhatDoesNotCountStaysWithThePartInFront) {
  // Two walls of half the light, and a veil before, between and behind them that does not count.
  std::vector<float> alphas(30, 1e-4f);
  alphas[10] = 0.5f;
  alphas[20] = 0.5f;
  const TestRay ray = rayOf(alphas);
  const RaySamples found = samplesOf<EntranceDepth>(ray, 2);
  ASSERT_EQ(found.size(), 2);
  EXPECT_EQ(found[0].depth.depth, 7.25f);
  EXPECT_EQ(found[1].depth.depth, 12.25f);
  EXPECT_NEAR(found[0].color.a, 1.0 - 0.5 * std::pow(1.0 - 1e-4, 19), 1e-6);
  EXPECT_NEAR(found[1].color.a, 1.0 - 0.5 * std::pow(1.0 - 1e-4, 9), 1e-6);
}

class RaySamplesBy : public testing::TestWithParam<Heuristic> {};
INSTANTIATE_TEST_SUITE_P(All, RaySamplesBy, testing::ValuesIn(everyHeuristic()), heuristicCase);

TEST_P(RaySamplesBy, OneIsTheRaysOnlyOneToTheBit) {
  visitHeuristic(GetParam(), [](auto depth) {
    using Depth = decltype(depth);
    std::mt19937 random(kSeed);
    for (int i = 0; i < 100; ++i) {
      const TestRay ray = randomRay(random);
      std::vector<CountingSample> counting;
      const RayColor color = ray.color(&counting);
      const RaySamples found = samplesOf<Depth>(ray, 1);
      ASSERT_EQ(found.size(), counting.empty() ? 0 : 1) << "seed " << kSeed << ", ray " << i;
      if (counting.empty()) continue;
      ASSERT_EQ(found[0].color, color.premultiplied());
      ASSERT_EQ(found[0].depth.depth, depthBy<Depth>(counting).depth);
      ASSERT_EQ(found[0].depth.spread, depthBy<Depth>(counting).spread);
    }
  });
}

TEST_P(RaySamplesBy, PartsAreTheRayInOrderAndEachItsOwnDepth) {
  visitHeuristic(GetParam(), [](auto depth) {
    using Depth = decltype(depth);
    std::mt19937 random(kSeed + 1);
    size_t several = 0;
    for (int i = 0; i < 100; ++i) {
      const TestRay ray = randomRay(random);
      std::vector<CountingSample> counting;
      const RayColor color = ray.color(&counting);
      for (const int count : {2, 4, 8}) {
        SCOPED_TRACE("seed " + std::to_string(kSeed + 1) + ", ray " + std::to_string(i) + ", " + std::to_string(count));
        const RaySamples found = samplesOf<Depth>(ray, count);
        ASSERT_LE(found.size(), count);
        ASSERT_EQ(found.size() == 0, counting.empty());
        several += found.size() > 1;
        if (counting.empty()) continue;
        const glm::dvec4 sum = composited(found);
        for (int channel = 0; channel < 4; ++channel) ASSERT_NEAR(sum[channel], color.premultiplied()[channel], 2e-6);

        // Cut by definition, and each part as a ray of its own.
        const double end = counting.back().accumulatedAfter();
        size_t next = 0;
        for (int part = 0, place = 0; part < count; ++part) {
          std::vector<CountingSample> own;
          double through = 1.0;
          const auto isInPart = [&](const CountingSample& sample) {
            return part + 1 == count ||
                   sample.accumulatedBefore() <
                       static_cast<float>(end) * (static_cast<float>(part + 1) / static_cast<float>(count));
          };
          for (; next < counting.size() && isInPart(counting[next]); ++next) {
            const CountingSample& met = counting[next];
            if (own.empty()) through = 1.0 - static_cast<double>(met.accumulated);
            // What did not count before the first part's first sample is that part's.
            own.push_back(CountingSample::behind((1.0 - static_cast<double>(met.accumulated)) / (place == 0 ? 1.0 : through), met.t, met.ds, met.alpha));
          }
          if (own.empty()) continue;
          ASSERT_LT(place, found.size());
          ASSERT_NEAR(found[place].depth.depth, depthBy<Depth>(own).depth, 1e-3);
          if (place > 0) {
            ASSERT_GE(found[place].depth.depth, found[place - 1].depth.depth);
          }
          ++place;
          if (next == counting.size()) {
            ASSERT_EQ(place, found.size());
          }
        }
      }
    }
    EXPECT_GT(several, 100u);  // the rays exercise what they are meant to
  });
}

// --- Through the CPU's marcher.

MarcherPtr cloudMarcher(VolumePtr& volume, TransferFunction& function) {
  const glm::uvec3 dims(40, 36, 32);
  volume = makeTestVolume(VoxelType::uint8, dims, blobs(dims, 35));
  function = {{{5.0, {1.0f, 0.2f, 0.1f}, 0.0f}, {100.0, {0.1f, 0.5f, 1.0f}, 0.3f}}};
  return makeCpuMarcher(volume, function);
}

TEST_P(RaySamplesBy, TheMarchersFramesCompositeBackToThePicture) {
  VolumePtr volume;
  TransferFunction function;
  const MarcherPtr marcher = cloudMarcher(volume, function);
  const Camera camera = lookingFrom({50.0f, 30.0f, 45.0f}, {}, 121, 97);
  MarchSettings settings;
  settings.sample.heuristic = GetParam();
  const SampleFrame single = marcher->march(camera, settings);
  ASSERT_GT(single.size(), 500u);
  EXPECT_TRUE(single.planes.empty());
  for (const int count : {2, 4, 8}) {
    settings.sample.samplesPerRay = count;
    const SampleFrame frame = marcher->march(camera, settings);
    const std::span<const uint8_t> layers = frame.layers();
    ASSERT_EQ(layers.size(), frame.size());
    ASSERT_EQ(frame.colors.size(), frame.size());
    EXPECT_GT(frame.size(), single.size() + single.size() / 2);
    size_t ray = 0;
    double sumOfErrors = 0.0, largest = 0.0;
    for (size_t first = 0; first < frame.size(); ++ray) {
      const size_t end = endOfRay(layers, first);
      ASSERT_LE(end - first, static_cast<size_t>(count));
      ASSERT_LT(ray, single.size());
      glm::vec4 sum(0.0f);
      for (size_t i = first; i < end; ++i) {
        ASSERT_EQ(layers[i], i - first);
        sum = over(sum, decodeRgba8(frame.colors[i]));
        if (i > first) {
          ASSERT_GE(glm::length(sphereOf(frame, i).center - camera.eye),
                    glm::length(sphereOf(frame, i - 1).center - camera.eye) - 1e-3f);
        }
      }
      const double error = glm::length(sum - decodeRgba8(single.colors[ray]));
      sumOfErrors += error;
      largest = std::max(largest, error);
      first = end;
    }
    EXPECT_EQ(ray, single.size());
    EXPECT_LT(sumOfErrors / static_cast<double>(ray), 0.005) << count;  // of 8 bits
    EXPECT_LT(largest, 0.03) << count;
  }
}

TEST_P(RaySamplesBy, TheMarcherFindsWhatASampleAtATimeFinds) {
  // The way that a device takes, on the host: the same bits.
  VolumePtr volume;
  TransferFunction function;
  const MarcherPtr marcher = cloudMarcher(volume, function);
  const MarchedVolume marched(volume, function);
  MarchSettings settings;
  settings.sample.heuristic = GetParam();
  const BakedTransfer baked = bakeTransfer(marched, settings.render);
  VolumeView<uint8_t> view = makeVolumeView<uint8_t>(marched);
  view.voxels = volume->voxelsAs<uint8_t>();
  view.transfer = baked.table.lookup();
  view.cells.distances = baked.emptyDistances.data();
  const Camera camera = lookingFrom({50.0f, 30.0f, 45.0f}, {}, 31, 27);
  for (const int count : {1, 2, 4, 8}) {
    settings.sample.samplesPerRay = count;
    const SampleFrame frame = marcher->march(camera, settings);
    const SampleRule rule = sampleRuleOf(frame);
    const PixelGrid pixels = makePixelGrid(camera, frame.quantization.nearDepth);
    size_t next = 0;
    for (uint32_t y = 0; y < camera.height; ++y)
      for (uint32_t x = 0; x < camera.width; ++x) {
        const auto [pixelRay, cosine] = pixels.ray(x, y);
        const Ray& ray = pixelRay;
        const RayPath path{
            ray, makeLattice(intersectBox(reciprocalOf(ray.origin, ray.direction), volume->bounds(), 0.0f, 1e30f),
                             settings.render.step)};
        RaySamples found;
        visitHeuristic(GetParam(), [&](auto depth) {
          findSamples(
              depth, path, [&] { return ScalarVolumeSource<uint8_t, false, false>(view, ray, path.lattice); }, Unlit{},
              limitsOf(settings.render), settings.sample.threshold, count, found);
        });
        for (int i = 0; i < found.size(); ++i, ++next) {
          ASSERT_LT(next, frame.size());
          ASSERT_EQ(frame.samples[next], packRaySample(rule, pixels, x, y, cosine, found[i].depth, found[i].color.a))
              << x << " " << y << ", " << i << " of " << count;
          ASSERT_EQ(frame.colors[next], ColorTables::instance().encode(found[i].color));
        }
      }
    ASSERT_EQ(next, frame.size());
  }
}

TEST(RaySamples, AsManyAsTheRangeAllows) {
  EXPECT_EQ(kMaxRaySamples, 8);
  VolumePtr volume;
  TransferFunction function;
  const MarcherPtr marcher = cloudMarcher(volume, function);
  for (const int count : {0, -1, 9}) {
    MarchSettings settings;
    settings.sample.samplesPerRay = count;
    EXPECT_THROW(marcher->march(lookingFrom({50.0f, 30.0f, 45.0f}, {}, 8, 8), settings), UsageError) << count;
  }
}

}  // namespace
}  // namespace warpscope

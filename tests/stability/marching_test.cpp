// One ray: cases 30 to 39, with samples that are made up. Truth: closed forms in 100 digits, counts in exact
// arithmetic. Mirrors render/march/march.h, lattice.h, transmittance.h, volume_view.h and render/volume/voxel_access.h.
// Through volumes: volumes_test.cpp.
#include "render/march/march.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "tests/made_up_source.h"
#include "tests/opacities.h"
#include "tests/stability/backends.h"
#include "tests/stability/device_probe.h"
#include "tests/stability/exact.h"
#include "tests/stability/magnitudes.h"
#include "tests/stability/probes.h"
#include "tests/stability/record.h"

namespace warpscope {
namespace {

constexpr float kLeastFloat = std::numeric_limits<float>::denorm_min();

/// What hard-cases allow a slab's colour and opacity to be off by.
constexpr double kSlabError = 1e-6;

/// Opacity of `length` of a medium whose opacity over `per` is `alpha`.
Exact slabOf(float alpha, const Exact& length, const Exact& per = 1) {
  return -expm1(length / per * log1p(-Exact(alpha)));
}

/// A ray whose samples are alike: of `unitAlpha` over a unit of length.
MarchProbe::Input slabInput(float unitAlpha, float length, float dt, float stopBelow = 0.0f) {
  return {correctOpacity(unitAlpha, dt), unitAlpha, length, dt, stopBelow};
}

TEST_P(Case30, AMillionNearlyTransparentSamplesAddUp) {
  const auto found = evaluate<MarchProbe>(GetParam(), slabInput(1e-8f, 1e6f, 1.0f));
  EXPECT_EQ(found.samples, 1000000);
  Worst worst;
  const Exact truth = slabOf(1e-8f, Exact(1000000));
  EXPECT_NEAR(static_cast<double>(truth), 0.00995017, 1e-8);
  worst.see(static_cast<double>(abs(Exact(found.premultiplied.a) - truth)));
  worst.see(static_cast<double>(abs(Exact(found.premultiplied.r) - truth)));
  worst.see(static_cast<double>(abs(Exact(found.premultiplied.b) - truth / 4)));
  record(
      {"marchRay, 1e6 samples of 1e-8", "100 digits", "of colour and opacity", worst.value(), kSlabError, GetParam()});
}

TEST_P(Case31, AnOpaqueSampleIsOpaque) {
  for (const float dt : {0.25f, 1.0f, 8.0f}) {
    const auto found = evaluate<MarchProbe>(GetParam(), slabInput(1.0f, 8.0f, dt));
    EXPECT_EQ(found.premultiplied, glm::vec4(1.0f, 0.5f, 0.25f, 1.0f));
    EXPECT_EQ(found.transmittance, 0.0);
  }
  recordExact("marchRay, opacity 1", "closed form", GetParam());
}

TEST(Case31, AnOpaqueSampleEndsTheRayAndIsRecorded) {
  const auto profile = [](int i) { return i == 3 ? 1.0f : i > 3 ? 0.5f : 0.0f; };
  for (const float stopBelow : {0.0f, kContribution}) {
    const Marched result = march(latticeOf(2.0f, 10.0f, 1.0f), profile, stopBelow);
    EXPECT_EQ(result.color.premultiplied(), glm::vec4(1.0f, 0.5f, 0.25f, 1.0f));
    ASSERT_EQ(result.counting.size(), 1u);
    EXPECT_EQ(result.counting[0].t, 5.5f);
    EXPECT_EQ(result.counting[0].transmittance, 1.0f);
  }
}

TEST_P(Case32, NoLengthNoOpacity) {
  for (const float alpha : {0.0f, kLeastFloat, 1e-8f, 0.5f, std::nextafter(1.0f, 0.0f), 1.0f})
    EXPECT_EQ(evaluate<OpacityProbe>(GetParam(), OpacityProbe::Input{alpha, 0.0f}), 0.0f) << alpha;
  for (const RayInterval& interval : {RayInterval{}, {5.0f, 5.0f}, {5.0f, 4.0f}, {0.0f, std::nanf("")}})
    EXPECT_EQ(evaluate<LatticeProbe>(GetParam(), LatticeProbe::Input{interval, 1.0f, 0}).count, 0);
  // A whole number of steps leaves no empty one behind.
  for (const float dt : {0.5f, 0.25f, 1.0f, 3.0f})
    for (const int steps : {1, 2, 3, 7, 1000, 65536}) {
      const auto found = evaluate<LatticeProbe>(
          GetParam(), LatticeProbe::Input{{0.0f, static_cast<float>(steps) * dt}, dt, steps - 1});
      EXPECT_EQ(found.count, steps);
      EXPECT_EQ(found.stepLength, dt);
    }
  recordExact("correctOpacity over no length, makeLattice of no length", "definition", GetParam());
}

TEST_P(Case33, ASlabIsTheClosedFormAtEveryStep) {
  Worst worst;
  std::vector<MarchProbe::Input> inputs;
  for (const float alpha : {0.001f, 0.05f, 0.4f, 0.99f})
    for (const float length : {10.0f, 9.73f, 0.3f, 100.0f})
      for (const float dt : {1.0f, 0.5f, 0.25f, 0.1f, 0.01f}) inputs.push_back(slabInput(alpha, length, dt));
  const auto found = evaluate<MarchProbe>(GetParam(), inputs);
  for (size_t i = 0; i < inputs.size(); ++i) {
    const Exact truth = slabOf(inputs[i].unitAlpha, Exact(inputs[i].length));
    worst.see(static_cast<double>(abs(Exact(found[i].premultiplied.a) - truth)));
    worst.see(static_cast<double>(abs(Exact(found[i].premultiplied.g) - truth / 2)));
  }
  record({"marchRay, slabs of any step", "100 digits", "of colour and opacity", worst.value(), kSlabError, GetParam()});
}

TEST_P(Case33, PropertyLightIsWithinItsBound) {
  Worst opacity, color;
  checkProperty([&] {
    std::vector<MarchProbe::Input> inputs;
    for (const auto& [alpha, steps, dt] : *rc::gen::container<std::vector<std::tuple<float, float, float>>>(
             rc::gen::tuple(anyPositive(-30, -1), anyPositive(-3, 12), anyPositive(-8, 4))))
      inputs.push_back(
          {std::min(alpha, 0.999f), correctOpacity(std::min(alpha, 0.999f), 1.0f / dt), dt * steps, dt, 0.0f});
    const auto found = evaluate<MarchProbe>(GetParam(), inputs);
    for (size_t i = 0; i < inputs.size(); ++i) {
      const RayLattice lattice = makeLattice({0.0f, inputs[i].length}, inputs[i].dt);
      if (lattice.count == 0) continue;
      // Of the samples' opacities as they are: whole ones, and the last as it is corrected.
      const float last = correctOpacity(inputs[i].unitAlpha, lattice.stepLength(lattice.count - 1));
      const Exact through = exp(Exact(lattice.count - 1) * log1p(-Exact(inputs[i].alpha))) * (1 - Exact(last));
      const double opacityError = roundoffs(found[i].premultiplied.a, 1 - through, 1 - through);
      const Exact ofDouble = lattice.count * Exact(0x1p-53) / (1 - through);
      RC_ASSERT(Exact(opacityError * kUnitRoundoff) <= Exact(1.001 * kUnitRoundoff) + ofDouble);
      const bool isFaint = last < 1e-9f || inputs[i].alpha < 1e-9f;
      if (!isFaint) RC_ASSERT(opacityError * kUnitRoundoff <= kMarchedOpacityError);
      if (!isFaint) opacity.see(opacityError);
      for (const auto& [value, share] :
           {std::pair(found[i].premultiplied.r, 1), std::pair(found[i].premultiplied.b, 4)}) {
        const double colorError = roundoffs(Exact(value) * share, 1 - through, 1 - through);
        RC_ASSERT(colorError * kUnitRoundoff <= kMarchedColorError);
        color.see(colorError);
      }
    }
  });
  record({"marchRay, opacity of up to 8192 samples of 1e-9 to 1", "100 digits", "u of it", opacity.value(),
          kMarchedOpacityError / kUnitRoundoff, GetParam()});
  record({"marchRay, colour of up to 8192 samples of 1e-9 to 1", "100 digits", "u of it", color.value(),
          kMarchedColorError / kUnitRoundoff, GetParam()});
}

TEST_P(Case34, AHundredThousandSamplesLetThroughLessAndLess) {
  double before = 1.0;
  Worst worst;
  for (const float length : {1.0f, 10.0f, 100.0f, 1000.0f, 5000.0f, 20000.0f, 60000.0f, 70000.0f}) {
    const auto found = evaluate<MarchProbe>(GetParam(), MarchProbe::Input{0.01f, 0.01f, length, 1.0f, 0.0f});
    EXPECT_GE(found.transmittance, 0.0);
    EXPECT_LT(found.transmittance, before) << "stalls at sample " << length;
    before = found.transmittance;
    const Exact truth = exp(Exact(length) * log1p(-Exact(0.01f)));
    worst.see(static_cast<double>(abs(Exact(found.transmittance) / truth - 1)));
  }
  EXPECT_EQ(evaluate<MarchProbe>(GetParam(), MarchProbe::Input{0.01f, 0.01f, 1e5f, 1.0f, 0.0f}).premultiplied.a, 1.0f);
  // A rounding of a double for each sample, and one of the factor.
  record({"Transmittance after up to 70000 samples of .01", "100 digits", "of it", worst.value(), 2.0 * 70000 * 0x1p-53,
          GetParam()});
}

TEST(Case34, TransmittanceFallsWithoutStallingAndNeverBelowZero) {
  Transmittance transmittance;
  double exact = 0.0;
  float before = 2.0f;
  for (int i = 0; i < 100000; ++i) {
    const float value = transmittance.value();
    ASSERT_GE(value, 0.0f);
    ASSERT_LE(value, before);
    if (value > 1e-37f) {
      ASSERT_LT(value, before) << "stalls at sample " << i;
      ASSERT_NEAR(value / std::exp(exact), 1.0, 1e-6);
    }
    before = value;
    exact += std::log1p(-static_cast<double>(0.01f));
    const double beforeInDouble = transmittance.exact();
    transmittance.pass(0.01f);
    ASSERT_GE(transmittance.exact(), 0.0);
    ASSERT_TRUE(transmittance.exact() < beforeInDouble || beforeInDouble < 1e-300) << "stalls at sample " << i;
  }
  EXPECT_EQ(transmittance.opacity(), 1.0f);
  recordExact("Transmittance: falls, never negative", "definition");
}

DepthResult depthOf(Heuristic heuristic, const std::vector<CountingSample>& counting) {
  return visitHeuristic(heuristic, [&](auto depth) {
    using Depth = decltype(depth);
    ProfileFold ray;
    for (const CountingSample& sample : counting) ray.add(sample);
    auto fold = Depth::start(0.8f, ray);
    for (const CountingSample& sample : counting) fold.add(sample);
    return Depth::result(fold);
  });
}

TEST(Case35, PropertyStoppingEarlyAndPiecesChangeNoDepthAndHardlyAColour) {
  checkProperty([] {
    const auto alphas = *rc::gen::nonEmpty(rc::gen::container<std::vector<float>>(
        rc::gen::oneOf(rc::gen::just(0.0f), anyPositive(-12, -1), anyFraction())));
    const auto profile = [&](int i) { return std::min(1.0f, alphas[static_cast<size_t>(i)]); };
    const RayLattice lattice = latticeOf(1.0f, 0.5f * static_cast<float>(alphas.size()) - 0.2f, 0.5f);
    const Marched all = march(lattice, profile), some = march(lattice, profile, kContribution);
    RC_ASSERT(sameSamples(all.counting, some.counting));
    for (const auto& entry : kHeuristics) {
      const DepthResult a = depthOf(entry.value, all.counting), b = depthOf(entry.value, some.counting);
      RC_ASSERT(a.hasDepth == b.hasDepth);
      RC_ASSERT(a.depth == b.depth);
    }
    for (int c = 0; c < 4; ++c)
      RC_ASSERT(std::abs(all.color.premultiplied()[c] - some.color.premultiplied()[c]) <= kContribution);
    // In segments, and in batches of another size: the same bits.
    auto cuts = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, lattice.count + 1));
    std::sort(cuts.begin(), cuts.end());
    for (const Marched& other :
         {march(lattice, profile, 0.0f, cuts), march<1>(lattice, profile), march<32>(lattice, profile)}) {
      RC_ASSERT(sameSamples(all.counting, other.counting));
      RC_ASSERT(all.color.premultiplied() == other.color.premultiplied());
    }
  });
  recordExact("marchRay in pieces and batches of other sizes; depths of rays that end early", "itself");
}

TEST_P(Case35, PropertyAnEarlyEndIsWithinItsThreshold) {
  Worst worst;
  checkProperty([&] {
    const float alpha = std::min(*anyPositive(-20, -1), 0.999f),
                stop = *rc::gen::element(1.0f / 1024, 1.0f / 16, 1e-6f);
    const float length = *anyPositive(0, 12);
    const auto all = evaluate<MarchProbe>(GetParam(), MarchProbe::Input{alpha, alpha, length, 1.0f, 0.0f});
    const auto some = evaluate<MarchProbe>(GetParam(), MarchProbe::Input{alpha, alpha, length, 1.0f, stop});
    RC_ASSERT(some.samples <= all.samples);
    for (int channel = 0; channel < 4; ++channel) {
      // The light that is left, and the roundings of both sums.
      const double missing =
          (static_cast<double>(all.premultiplied[channel]) - static_cast<double>(some.premultiplied[channel])) /
          static_cast<double>(stop);
      RC_ASSERT(std::abs(missing) <= 1.0 + 2.0 * kMarchedColorError / static_cast<double>(stop));
      worst.see(std::abs(missing) - 2.0 * kMarchedColorError / static_cast<double>(stop));
    }
  });
  record({"marchRay, ended early", "itself, to the end", "of the threshold", worst.value(), 1.0, GetParam()});
}

// --- The lattice.

/// How many steps of dt cover the length, exactly.
int64_t exactCount(float length, float dt) { return static_cast<int64_t>(ceil(Exact(length) / Exact(dt))); }

/// Checks samples of a lattice: the first ones, the last, one between.
void checkLattices(Backend backend, const std::vector<std::pair<RayInterval, float>>& lattices, Worst& worst) {
  std::vector<LatticeProbe::Input> inputs;
  for (const auto& [interval, dt] : lattices) {
    const int count = makeLattice(interval, dt).count;
    for (const int i : {0, 1, count / 2, count - 2, count - 1})
      if (i >= 0 && i < count) inputs.push_back({interval, dt, i});
  }
  const auto found = evaluate<LatticeProbe>(backend, inputs);
  for (size_t k = 0; k < inputs.size(); ++k) {
    const auto& [interval, dt, i] = inputs[k];
    const float t0 = interval.tNear, inside = interval.tFar - interval.tNear;  // what is left of it in float
    SCOPED_TRACE(testing::Message() << "sample " << i << " of " << found[k].count << ", from " << t0 << ", length "
                                    << inside << ", step " << dt);
    ASSERT_EQ(found[k].count, exactCount(inside, dt));
    ASSERT_EQ(found[k].length, inside);
    const bool isLast = i + 1 == found[k].count;
    const Exact step = isLast ? Exact(inside) - Exact(dt) * i : Exact(dt);
    if (!isLast) ASSERT_EQ(found[k].stepLength, dt);
    ASSERT_GE(found[k].stepLength, 0.0f);
    ASSERT_LE(found[k].stepLength, dt);
    ASSERT_LE(roundoffs(found[k].stepLength, step, step) * kUnitRoundoff, isLast ? kLatticeStepError : 0.0);
    ASSERT_GE(found[k].t, t0);
    ASSERT_LE(found[k].t, interval.tFar * (1.0f + 1.2e-7f));
    const double error = roundoffs(found[k].t, Exact(t0) + Exact(dt) * i + step / 2, Exact(t0) + Exact(inside));
    ASSERT_LE(error * kUnitRoundoff, kLatticeError);
    worst.see(error);
  }
}

TEST_P(Case36, CountsExactlyFarFromTheEyeWithTinySteps) {
  Worst worst;
  // The last ones have 2^24 samples and more: rounded indices would make the last step negative, and opacity grow out
  // of nothing.
  checkLattices(GetParam(),
                {{{1e4f, 1e4f + 1.0f}, 1e-4f},
                 {{1e4f, 1e4f + 100.0f}, 1e-4f},
                 {{0.0f, 16777.3f}, 1e-3f},
                 {{0.0f, 40000.0f}, 1e-3f},
                 {{0.0f, 65535.9f}, 1e-3f},
                 {{0.0f, 113000.5f}, 1e-3f}},
                worst);
  record({"RayLattice from 1e4 by 1e-4, and of up to 1e8 samples", "100 digits", "u of its far end", worst.value(),
          kLatticeError / kUnitRoundoff, GetParam()});
  const auto found = evaluate<MarchProbe>(GetParam(), MarchProbe::Input{0.0f, 0.0f, 1.0f, 1e-4f, 0.0f});
  EXPECT_EQ(found.samples, exactCount(1.0f, 1e-4f));  // it ends, and looks at each once
}

TEST_P(Case36, PropertyLatticesCoverTheRayOnceAtAnyMagnitude) {
  Worst worst;
  checkProperty([&] {
    std::vector<std::pair<RayInterval, float>> lattices;
    for (const auto& [dt, steps, away, isWhole] :
         *rc::gen::container<std::vector<std::tuple<float, float, float, bool>>>(rc::gen::tuple(
             anyPositive(-60, 60), anyPositive(-3, 20), anyPositive(-10, 10), rc::gen::arbitrary<bool>()))) {
      const float length = dt * (isWhole ? std::ceil(steps) : steps), t0 = away < 0.01f ? 0.0f : away * length;
      lattices.push_back({{t0, t0 + length}, dt});
    }
    checkLattices(GetParam(), lattices, worst);
  });
  record({"RayLattice::t", "100 digits", "u of its far end", worst.value(), kLatticeError / kUnitRoundoff, GetParam()});
}

// --- Parts of steps.

TEST_P(Case37, CorrectedOpacityIsTheNearestFloat) {
  std::mt19937 random(32);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  std::vector<OpacityProbe::Input> inputs;
  for (const float alpha : opacities(700, random))
    for (const float part : {1.0f, std::nextafter(1.0f, 0.0f), 0.5f, 1e-3f, kLeastFloat, unit(random),
                             std::exp2(-30.0f * unit(random)), 1000.0f * unit(random)})
      inputs.push_back({alpha, part});
  const std::vector<float> found = evaluate<OpacityProbe>(GetParam(), inputs);
  size_t undecided = 0, nearest = 0, wrong = 0;
  for (size_t i = 0; i < inputs.size(); ++i) {
    const Exact truth = slabOf(inputs[i].alpha, Exact(inputs[i].ds));
    const Exact reach = truth * kOpacityTie;
    const float lowest = static_cast<float>(truth - reach), highest = static_cast<float>(truth + reach);
    wrong += found[i] != lowest && found[i] != highest;
    (lowest == highest ? nearest : undecided) += 1;
  }
  EXPECT_GT(nearest, 10000u);
  EXPECT_LT(undecided, nearest / 100);  // tiny opacities over half a step are ties; else they would excuse too much
  record({"correctOpacity", "100 digits", "not the nearest float, ties within 3e-15 aside", static_cast<double>(wrong),
          0.0, GetParam()});
}

TEST_P(Case37, PropertyCorrectedOpacitiesOfAllMagnitudes) {
  Worst worst;
  checkProperty([&] {
    std::vector<OpacityProbe::Input> inputs;
    for (const auto& [alpha, ds, isNearOne] : *rc::gen::container<std::vector<std::tuple<float, float, bool>>>(
             rc::gen::tuple(anyPositive(-100, -1), anyPositive(-20, 20), rc::gen::arbitrary<bool>())))
      inputs.push_back({std::min(isNearOne ? 1.0f - alpha : alpha, std::nextafter(1.0f, 0.0f)), ds});
    const std::vector<float> found = evaluate<OpacityProbe>(GetParam(), inputs);
    for (size_t i = 0; i < inputs.size(); ++i) {
      RC_ASSERT(found[i] >= 0.0f);
      RC_ASSERT(found[i] <= 1.0f);
      const Exact truth = slabOf(inputs[i].alpha, Exact(inputs[i].ds));
      if (truth < Exact(std::numeric_limits<float>::min())) continue;  // floats have fewer digits there
      const double error = roundoffs(found[i], truth, truth);
      RC_ASSERT(error * kUnitRoundoff <= kOpacityError);
      worst.see(error);
    }
  });
  record({"correctOpacity, opacities from 1e-30 to 1 - 2^-24", "100 digits", "u of it", worst.value(),
          kOpacityError / kUnitRoundoff, GetParam()});
}

TEST_P(Case37, PropertyOpacityRisesWithBoth) {
  checkProperty([&] {
    const float alpha = std::min(*anyPositive(-60, -1), 0.99f), ds = *anyPositive(-20, 10);
    const auto of = [&](float a, float d) { return evaluate<OpacityProbe>(GetParam(), OpacityProbe::Input{a, d}); };
    RC_ASSERT(of(alpha, ds * 1.01f) >= of(alpha, ds));
    RC_ASSERT(of(std::min(1.0f, alpha * 1.01f), ds) >= of(alpha, ds));
    RC_ASSERT(of(alpha, std::nextafter(ds, 1e9f)) >= of(alpha, ds));
  });
  recordExact("correctOpacity rises with opacity and length", "definition", GetParam());
}

TEST_P(Case37, AWholeStepIsLeftAsItIs) {
  std::mt19937 random(33);
  std::vector<OpacityProbe::Input> inputs;
  for (const float alpha : opacities(10000, random)) inputs.push_back({alpha, 1.0f});
  inputs.push_back({1.0f, 1.0f});
  const std::vector<float> found = evaluate<OpacityProbe>(GetParam(), inputs);
  for (size_t i = 0; i < inputs.size(); ++i) ASSERT_EQ(found[i], inputs[i].alpha) << "seed 33";
  EXPECT_EQ(evaluate<OpacityProbe>(GetParam(), OpacityProbe::Input{1.0f, kLeastFloat}), 1.0f);
  recordExact("correctOpacity over a whole step", "identity", GetParam());
}

TEST_P(Case37, ThePartialLastStepIsCorrected) {
  // One step and a part of one.
  Worst worst;
  for (const float part : {0.25f, 0x1p-20f, 0.75f, 0.999f}) {
    const auto found = evaluate<MarchProbe>(GetParam(), MarchProbe::Input{0.5f, 0.5f, 1.0f + part, 1.0f, 0.0f});
    worst.see(roundoffs(found.premultiplied.a, slabOf(0.5f, Exact(1.0f + part)), 1));
    EXPECT_EQ(found.samples, 2);
  }
  record({"marchRay, a step and a part of one", "100 digits", "u", worst.value(), 2.0, GetParam()});
}

TEST(Case37, ThePartialLastStepIsReportedAsSuch) {
  // One step and a quarter of one.
  const Marched result = march(latticeOf(0.0f, 1.25f, 1.0f), [](int) { return 0.5f; });
  ASSERT_EQ(result.counting.size(), 2u);
  EXPECT_EQ(result.counting[1].ds, 0.25f);
  EXPECT_EQ(result.counting[1].t, 1.125f);
  EXPECT_NEAR(result.counting[1].alpha, 1.0 - std::pow(0.5, 0.25), 1e-7);
  EXPECT_NEAR(result.color.premultiplied().a, 1.0 - std::pow(0.5, 1.25), 1e-7);
}

// --- Interpolation.

TEST_P(Case38, PropertyAConstantFieldIsConstant) {
  // So that its gradient is 0, and no normal is made of what rounding leaves.
  checkProperty([&] {
    const float value = *anyNumber();
    std::vector<TrilinearProbe::Input> inputs;
    for (const auto& [x, y, z] : *rc::gen::container<std::vector<std::tuple<float, float, float>>>(
             rc::gen::tuple(anyFraction(), anyFraction(), anyFraction()))) {
      TrilinearProbe::Input input{{}, {x, y, z}};
      std::fill(std::begin(input.corners), std::end(input.corners), value);
      inputs.push_back(input);
    }
    for (const float found : evaluate<TrilinearProbe>(GetParam(), inputs)) RC_ASSERT(found == value);
  });
  recordExact("trilinear of a constant field", "identity", GetParam());
}

TEST_P(Case39, PropertyInterpolationIsWithinItsBound) {
  Worst worst;
  checkProperty([&] {
    std::vector<TrilinearProbe::Input> inputs;
    const int most = *anyInteger(-90, 90);
    for (const auto& [corners, x, y, z] :
         *rc::gen::container<std::vector<std::tuple<std::vector<float>, float, float, float>>>(
             rc::gen::tuple(rc::gen::container<std::vector<float>>(8, anyNumber(-8, 8)), anyFraction(), anyFraction(),
                            anyFraction()))) {
      TrilinearProbe::Input input{{}, {x, y, z}};
      for (size_t i = 0; i < 8; ++i) input.corners[i] = std::ldexp(corners[i], most);
      inputs.push_back(input);
    }
    const std::vector<float> found = evaluate<TrilinearProbe>(GetParam(), inputs);
    for (size_t k = 0; k < inputs.size(); ++k) {
      const auto& [c, w] = inputs[k];
      Exact truth = 0, largest = 0;
      for (int i = 0; i < 8; ++i) {
        truth += (i & 1 ? Exact(w.x) : 1 - Exact(w.x)) * (i & 2 ? Exact(w.y) : 1 - Exact(w.y)) *
                 (i & 4 ? Exact(w.z) : 1 - Exact(w.z)) * Exact(c[i]);
        largest = std::max<Exact>(largest, abs(Exact(c[i])));
      }
      const double error = roundoffs(found[k], truth, largest);
      RC_ASSERT(error * kUnitRoundoff <= kTrilinearError);
      worst.see(error);
    }
  });
  record({"trilinear", "100 digits", "u of the largest corner", worst.value(), kTrilinearError / kUnitRoundoff,
          GetParam()});
}

TEST_P(Case39, PropertyPlacesAreWithinTheirBound) {
  Worst worst;
  checkProperty([&] {
    std::vector<VoxelPlaceProbe::Input> inputs;
    for (const auto& [origin, direction, half, edge, t] :
         *rc::gen::container<std::vector<std::tuple<glm::vec3, glm::vec3, glm::vec3, glm::vec3, float>>>(rc::gen::tuple(
             anyVector(-10, 12), anyDirection(), anyVector(0, 12), anyVector(0, 7), anyPositive(-10, 13))))
      inputs.push_back({{origin, direction}, -glm::abs(half), 1.0f / glm::abs(edge), t});
    const auto found = evaluate<VoxelPlaceProbe>(GetParam(), inputs);
    for (size_t i = 0; i < inputs.size(); ++i)
      for (int axis = 0; axis < 3; ++axis) {
        const VoxelPlaceProbe::Input& in = inputs[i];
        const Exact perUnit(in.voxelsPerUnit[axis]), before = (Exact(in.ray.origin[axis]) - in.lower[axis]) * perUnit;
        const Exact along = Exact(in.t) * in.ray.direction[axis] * perUnit;
        const double error =
            roundoffs(found[i][axis], before - Exact(0.5) + along, abs(before) + Exact(0.5) + abs(along));
        RC_ASSERT(error * kUnitRoundoff <= kVoxelPlaceError);
        worst.see(error);
      }
  });
  record({"VolumeView, the place of a ray's point in voxels", "100 digits", "u of its terms", worst.value(),
          kVoxelPlaceError / kUnitRoundoff, GetParam()});
}

}  // namespace
}  // namespace warpscope

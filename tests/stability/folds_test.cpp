// Which depth stands for a ray: cases 34 and 35. Truth: the heuristics' definitions in 100 decimal digits, closed forms
// of haze. Mirrors render/march/depth_heuristic.h, ray_state.h and transmittance.h; definitions after Zellmann,
// Aumueller, Lang 2012.
#include "render/march/depth_heuristic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numeric>
#include <random>
#include <vector>

#include "render/march/ray_state.h"
#include "render/march/transmittance.h"
#include "tests/heuristic_cases.h"
#include "tests/made_up_source.h"
#include "tests/stability/backends.h"
#include "tests/stability/device_probe.h"
#include "tests/stability/exact.h"
#include "tests/stability/magnitudes.h"
#include "tests/stability/probes.h"
#include "tests/stability/record.h"

namespace warpscope {
namespace {

// --- Haze

/// Depth of `count` samples of the same opacity, one unit apart, as a march folds them.
template <class Depth>
float depthOfHaze(float alpha, int count, float threshold) {
  ProfileFold profile;
  const auto fold = [&](auto&& add) {
    Transmittance transmittance;
    for (int i = 0; i < count; ++i) {
      add(CountingSample::behind(transmittance.exact(), static_cast<float>(i) + 0.5f, 1.0f, alpha));
      transmittance.pass(alpha);
    }
  };
  if constexpr (Depth::kTwoPass) fold([&](const CountingSample& sample) { profile.add(sample); });
  auto state = Depth::start(threshold, profile);
  fold([&](const CountingSample& sample) { state.add(sample); });
  return Depth::result(state).depth;
}

TEST(Case34, HalfOfAThinHazesOpacityIsReachedInItsMiddle) {
  Worst worst;
  for (const float alpha : {1e-6f, 3e-6f, 1e-5f, 1e-4f, 1e-3f, 1e-2f})
    for (const int count : {1, 2, 10, 100, 1000, 100000}) {
      const double all = -std::expm1(count * std::log1p(-static_cast<double>(alpha)));
      const auto depthWhere = [&](double opacity) {
        return std::log1p(-opacity) / std::log1p(-static_cast<double>(alpha));
      };
      // Crossings are refined linearly inside the step, which is off by an eighth of its opacity at most, of the step.
      const double tolerance = 2e-7 * count + 0.13 * static_cast<double>(alpha) + 1e-6;
      worst.see(std::abs(depthOfHaze<MedianDepth>(alpha, count, 0.0f) - depthWhere(0.5 * all)) / tolerance);
      worst.see(std::abs(depthOfHaze<RelThresholdDepth>(alpha, count, 0.8f) - depthWhere(0.8 * all)) /
                (2.0 * tolerance));
    }
  record({"median, rel-threshold of up to 1e5 samples from 1e-6 on", "closed form in double", "of linear refinement's",
          worst.value(), 1.0});
}

// --- The definitions, of a probe's samples: t_i, ds, alpha_i, T_i, w_i = alpha_i T_i, A_i

struct Row {
  Exact t, ds, alpha, w, before, after;
};

std::vector<Row> rowsOf(const FoldProbe::Input& in) {
  std::vector<Row> rows;
  Exact transmittance = 1;
  for (int i = 0; i < in.count; ++i) {
    const Exact alpha(in.alphas[i]);
    const float t = mulAdd(static_cast<float>(i) + 0.5f, in.dt, in.t0);
    rows.push_back({t, in.dt, alpha, alpha * transmittance, 1 - transmittance, 1 - transmittance * (1 - alpha)});
    transmittance *= 1 - alpha;
  }
  return rows;
}

Exact crossingOf(const std::vector<Row>& rows, const Exact& tau) {
  for (const Row& row : rows) {
    if (row.after < tau) continue;
    Exact fraction = row.after > row.before ? Exact((tau - row.before) / (row.after - row.before)) : Exact(0);
    fraction = std::clamp<Exact>(fraction, 0, 1);
    return row.t + (fraction - Exact(0.5)) * row.ds;
  }
  return rows.back().t;
}

/// Lowest and highest answer that the declared errors excuse.
struct Answer {
  Exact lowest, highest;
};

Answer answerOf(Heuristic heuristic, const std::vector<Row>& rows, const Exact& threshold) {
  const auto exactly = [](const Exact& t) { return Answer{t, t}; };
  const auto crossing = [&](const Exact& tau) {
    const Exact off = tau * kCrossingError + Exact(rows.size() * 0x1p-53);  // of T in double
    // A step's end and the next one's beginning are one place but for the rounding of both samples' places.
    const Exact places[] = {crossingOf(rows, tau - off), crossingOf(rows, tau), crossingOf(rows, tau + off)};
    const Row& last = rows.back();
    Answer answer{*std::min_element(std::begin(places), std::end(places)),
                  *std::max_element(std::begin(places), std::end(places))};
    if (abs(tau - last.after) <= off) {  // crossed at the last step's end, or never: then its middle
      answer.lowest = std::min(answer.lowest, last.t);
      answer.highest = std::max<Exact>(answer.highest, last.t + last.ds / 2);
    }
    const Exact rounding = kUnitRoundoff * (abs(answer.highest) + 2 * last.ds) * 1.001;
    return Answer{answer.lowest - rounding, answer.highest + rounding};
  };
  const Exact end = rows.back().after;
  switch (heuristic) {
    case Heuristic::entrance:
      return exactly(rows.front().t);
    case Heuristic::exit:
      return exactly(rows.back().t);
    case Heuristic::midpoint: {
      const Exact middle = (rows.front().t + rows.back().t) / 2;
      return {middle * (1 - Exact(kUnitRoundoff)), middle * (1 + Exact(kUnitRoundoff))};
    }
    case Heuristic::threshold:
      return crossing(threshold);
    case Heuristic::peak: {
      const auto peak =
          std::max_element(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.alpha < b.alpha; });
      return exactly(peak->t);
    }
    case Heuristic::gradient: {
      Exact best = 0;
      for (const Row& row : rows) best = std::max(best, row.w);
      Answer answer{Exact("1e300"), Exact(-1)};
      for (const Row& row : rows)
        if (row.w >= best * (1 - Exact(kContributionError)))
          answer = {std::min(answer.lowest, row.t), std::max(answer.highest, row.t)};
      return answer;
    }
    case Heuristic::relThreshold:
      return crossing(threshold * end);
    case Heuristic::enExMean:
      return crossing((rows.front().alpha + rows.back().alpha) / 2);
    case Heuristic::median:
      return crossing(end / 2);
    case Heuristic::expected:
      break;
  }
  Exact weight = 0, sum = 0;
  for (const Row& row : rows) weight += row.w, sum += row.w * row.t;
  const Exact mean = sum / weight, off = (rows.size() + 3) * Exact(kMeanErrorPerSample) * rows.back().t;
  return {mean - off, mean + off};
}

/// Its square.
Exact varianceOf(const std::vector<Row>& rows) {
  Exact weight = 0, sum = 0, squares = 0;
  for (const Row& row : rows) weight += row.w, sum += row.w * row.t;
  const Exact mean = sum / weight;
  for (const Row& row : rows) squares += row.w * (row.t - mean) * (row.t - mean);
  return squares / weight;
}

/// A ray's samples that count: from hardly visible to opaque, equal ones among them.
rc::Gen<FoldProbe::Input> anyFolds() {
  return rc::gen::map(rc::gen::tuple(rc::gen::nonEmpty(rc::gen::container<std::vector<float>>(rc::gen::oneOf(
                                         anyPositive(-20, -1), anyFraction(), rc::gen::element(0.25f, 0.5f, 1e-3f)))),
                                     rc::gen::inRange(0, 17), anyPositive(-10, 10), anyPositive(-20, 20),
                                     rc::gen::element(0.8f, 0.3f, 0.999f, 1e-3f)),
                      [](const auto& parts) {
                        const auto& [alphas, cut, away, dt, threshold] = parts;
                        FoldProbe::Input input{};
                        input.count = static_cast<int>(std::min<size_t>(alphas.size(), FoldProbe::kSamples));
                        input.cut = std::min(cut, input.count);
                        input.dt = dt;
                        input.t0 = away < 0.01f ? 0.0f : away * dt;
                        input.threshold = threshold;
                        for (int i = 0; i < input.count; ++i)
                          input.alphas[i] = std::clamp(alphas[static_cast<size_t>(i)], 0x1p-20f, 1.0f);
                        for (int i = 0; i + 1 < input.count; ++i)
                          input.alphas[i] =
                              std::min(input.alphas[i], 0.999f);  // what is behind an opaque one does not count
                        return input;
                      });
}

}  // namespace

void showValue(const FoldProbe::Input& in, std::ostream& out) {
  out << "from " << in.t0 << " by " << in.dt << ", threshold " << in.threshold << ", cut before " << in.cut << ":"
      << std::hexfloat;
  for (int i = 0; i < in.count; ++i) out << " " << in.alphas[i];
  out << std::defaultfloat;
}

namespace {

TEST_P(Case34, PropertyDepthsAreThoseOfTheDefinitions) {
  Worst ofMean, ofSpread;
  checkProperty([&] {
    const auto inputs = *rc::gen::container<std::vector<FoldProbe::Input>>(anyFolds());
    const auto found = evaluate<FoldProbe>(GetParam(), inputs);
    for (size_t k = 0; k < inputs.size(); ++k) {
      const std::vector<Row> rows = rowsOf(inputs[k]);
      for (size_t h = 0; h < kHeuristics.size(); ++h) {
        const Answer answer = answerOf(kHeuristics[h].value, rows, Exact(inputs[k].threshold));
        for (const DepthResult& result : {found[k].whole[h], found[k].cut[h]}) {
          RC_LOG() << std::setprecision(12) << kHeuristics[h].name << ": " << result.depth << " in " << answer.lowest
                   << " .. " << answer.highest << '\n';
          RC_ASSERT(result.hasDepth);
          RC_ASSERT(Exact(result.depth) >= answer.lowest);
          RC_ASSERT(Exact(result.depth) <= answer.highest);
          if (kHeuristics[h].value != Heuristic::expected) continue;
          const Exact scale = (rows.size() + 3) * rows.back().t;
          ofMean.see(roundoffs(result.depth, (answer.lowest + answer.highest) / 2, scale));
          const Exact extent = rows.back().t - rows.front().t;
          const double spreadError =
              roundoffs(Exact(result.spread) * Exact(result.spread), varianceOf(rows), scale * extent);
          RC_ASSERT(spreadError * kUnitRoundoff <= 2.0 * kMeanErrorPerSample);
          ofSpread.see(spreadError);
        }
      }
    }
  });
  recordExact("every heuristic but expected, within the errors declared for its fold, whole and in two pieces",
              "definitions in 100 digits", GetParam());
  record({"heuristic expected, the mean, whole and in two pieces", "100 digits",
          "u of the farthest sample, for each and three", ofMean.value(), kMeanErrorPerSample / kUnitRoundoff,
          GetParam()});
  record({"heuristic expected, the square of the spread, whole and in two pieces", "100 digits",
          "u of the farthest sample and their extent, for each and three", ofSpread.value(),
          2.0 * kMeanErrorPerSample / kUnitRoundoff, GetParam()});
}

TEST_P(Case35, PropertyAnyCutGivesTheSameDepth) {
  checkProperty([&] {
    const auto inputs = *rc::gen::container<std::vector<FoldProbe::Input>>(anyFolds());
    const auto found = evaluate<FoldProbe>(GetParam(), inputs);
    for (size_t k = 0; k < inputs.size(); ++k)
      for (size_t h = 0; h < kHeuristics.size(); ++h) {
        if (kHeuristics[h].value == Heuristic::expected) continue;  // which rounds: above
        RC_ASSERT(found[k].whole[h].depth == found[k].cut[h].depth);
        RC_ASSERT(found[k].whole[h].hasDepth == found[k].cut[h].hasDepth);
      }
  });
  recordExact("folds of a ray in two pieces, all heuristics but expected", "the whole ray's", GetParam());
}

/// The samples of a probe.
std::vector<CountingSample> samplesOf(const FoldProbe::Input& in) {
  std::vector<CountingSample> samples;
  Transmittance transmittance;
  for (int i = 0; i < in.count; ++i) {
    samples.push_back(CountingSample::behind(transmittance.exact(), mulAdd(static_cast<float>(i) + 0.5f, in.dt, in.t0),
                                             in.dt, in.alphas[i]));
    transmittance.pass(in.alphas[i]);
  }
  return samples;
}

TEST(Case35, PropertyCombiningIsAssociativeAndHasAnIdentity) {
  Worst worst;
  checkProperty([&] {
    const FoldProbe::Input in = *anyFolds();
    const std::vector<CountingSample> samples = samplesOf(in);
    const size_t first = *rc::gen::inRange<size_t>(0, samples.size() + 1),
                 second = first + *rc::gen::inRange<size_t>(0, samples.size() - first + 1);
    for (const auto& entry : kHeuristics)
      visitHeuristic(entry.value, [&](auto depth) {
        using Depth = decltype(depth);
        using Fold = typename Depth::Fold;
        ProfileFold ray;
        for (const CountingSample& sample : samples) ray.add(sample);
        const auto segment = [&](size_t begin, size_t end) {
          Fold fold = Depth::start(in.threshold, ray);
          for (size_t i = begin; i < end; ++i) fold.add(samples[i]);
          return fold;
        };
        const double scale = static_cast<double>(samples.size() + 3) * static_cast<double>(samples.back().t);
        const auto same = [&](const Fold& a, const Fold& b, bool isExact) {
          const DepthResult x = Depth::result(a), y = Depth::result(b);
          RC_ASSERT(x.hasDepth == y.hasDepth);
          if (!x.hasDepth) return;
          const double error = std::abs(static_cast<double>(x.depth) - static_cast<double>(y.depth)) / scale;
          RC_ASSERT(error <= (isExact ? 0.0 : 2.0 * kMeanErrorPerSample));
          worst.see(error / kUnitRoundoff);
        };
        const bool isExact = entry.value != Heuristic::expected;
        const Fold a = segment(0, first), b = segment(first, second), c = segment(second, samples.size());
        same(Fold::combine(Fold::combine(a, b), c), Fold::combine(a, Fold::combine(b, c)), isExact);
        // The identity, on either side, to the bit; and what comes out can be gone on with.
        for (Fold fold : {Fold::combine({}, a), Fold::combine(a, {})}) {
          same(fold, a, true);
          for (size_t i = first; i < samples.size(); ++i) fold.add(samples[i]);
          same(fold, segment(0, samples.size()), true);
        }
      });
  });
  record({"folds combined in either order (exact but for expected)", "itself",
          "u of the farthest sample, for each and three", worst.value(), 2.0 * kMeanErrorPerSample / kUnitRoundoff});
}

TEST(Case35, PropertyLightCombinesAssociatively) {
  Worst worst;
  checkProperty([&] {
    std::vector<RayLight> pieces;
    for (const auto& [color, transmittance] :
         *rc::gen::container<std::vector<std::pair<glm::vec3, float>>>(rc::gen::pair(anyVector(-60, 0), anyFraction())))
      pieces.push_back({glm::abs(glm::dvec3(color)), static_cast<double>(transmittance)});
    RayLight front, back;
    for (const RayLight& piece : pieces) front = RayLight::combine(front, piece);
    for (size_t i = pieces.size(); i-- > 0;) back = RayLight::combine(pieces[i], back);
    for (const RayLight& light : {RayLight::combine({}, front), RayLight::combine(front, {})})
      RC_ASSERT(light.color == front.color && light.transmittance == front.transmittance);
    const double allowed = 4.0 * static_cast<double>(pieces.size() + 1);  // of doubles, all terms positive
    const auto see = [&](double a, double b) {
      if (a == b) return;
      const double error = std::abs(a - b) / std::max(a, b) / 0x1p-53;
      RC_ASSERT(error <= allowed);
      worst.see(error / allowed);
    };
    see(front.transmittance, back.transmittance);
    for (int channel = 0; channel < 3; ++channel) see(front.color[channel], back.color[channel]);
  });
  record(
      {"RayLight::combine in either order", "itself", "of 4 roundings of a double for each piece", worst.value(), 1.0});
}

// --- Rays put together from pieces, as separate machines would

constexpr uint32_t kSeed = 2012;
constexpr int kRays = 60;
constexpr float kThreshold = 0.8f;

/// A ray's opacities, from faint to opaque, with gaps; its colours differ from sample to sample.
struct TestRay {
  RayPath path;
  std::vector<float> alphas;
  RayLimits limits;
};

/// Colours by place, so that light that is taken from the wrong piece shows.
struct ByPlace {
  template <class Source>
  glm::vec3 shade(const ClassifiedSample& sample, const Ray& ray, const Source&, int) const {
    const float z = ray.at(sample.t).z;
    return sample.alpha * glm::vec3(0.5f + 0.5f * std::sin(z), 0.5f + 0.5f * std::cos(3.0f * z), 0.25f);
  }
};

TestRay randomRay(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  TestRay ray;
  const auto count = 1 + random() % 200;
  ray.path = alongZ(latticeOf(1.0f, 0.5f * static_cast<float>(count) - 0.2f, 0.5f));
  const float scale = std::exp2(-8.0f * unit(random));
  ray.alphas.resize(count);
  for (float& alpha : ray.alphas) alpha = random() % 3 ? std::min(1.0f, 2.0f * scale * unit(random)) : 0.0f;
  ray.limits = {kContribution, random() % 2 ? kContribution : 0.0f};
  return ray;
}

MadeUpSource<8> sourceOf(const TestRay& ray) {
  return {[&ray](int i) { return ray.alphas[static_cast<size_t>(i)]; }, ray.path.lattice};
}

/// Begins and ends of `pieces` pieces, some of them empty.
std::vector<int> randomCuts(int pieces, int count, std::mt19937& random) {
  std::vector<int> cuts{0, count};
  for (int i = 1; i < pieces; ++i) cuts.push_back(static_cast<int>(random() % (static_cast<uint32_t>(count) + 1)));
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

/// The state of each piece, as separate machines would find it: they exchange transmittances, then profiles.
template <class Depth>
std::vector<RayState<Depth>> statesOf(const TestRay& ray, const std::vector<int>& cuts) {
  std::vector<RayState<Depth>> states;
  std::vector<Transmittance> inFront{Transmittance()};
  for (size_t p = 0; p + 1 < cuts.size(); ++p) {
    MadeUpSource<8> source = sourceOf(ray);
    RayOpacity alone;
    marchRay(ray.path, cuts[p], cuts[p + 1], source, ByPlace{}, {kContribution, 0.0f}, alone,
             [](const CountingSample&) { return true; });
    states.push_back(
        marchPiece<Depth>(ray.path, cuts[p], cuts[p + 1], source, ByPlace{}, ray.limits, kThreshold, inFront[p]));
    inFront.push_back(Transmittance(inFront[p].exact() * alone.transmittance.exact()));
  }
  if constexpr (Depth::kTwoPass) {
    ProfileFold profile;
    for (const auto& state : states) profile = ProfileFold::combine(profile, state.profile);
    for (size_t p = 0; p + 1 < cuts.size(); ++p) {
      MadeUpSource<8> source = sourceOf(ray);
      states[p].fold = marchPieceAgain<Depth>(ray.path, cuts[p], cuts[p + 1], source, ByPlace{}, ray.limits, kThreshold,
                                              inFront[p], profile);
    }
  }
  return states;
}

template <class Depth>
RayState<Depth> combined(const std::vector<RayState<Depth>>& states) {
  RayState<Depth> whole;
  for (const auto& state : states) whole = RayState<Depth>::combine(whole, state);
  return whole;
}

template <class Depth>
void expectNear(const RayState<Depth>& a, const RayState<Depth>& b, float reach) {
  ASSERT_NEAR(a.light.transmittance, b.light.transmittance, 1e-12);
  for (int channel = 0; channel < 3; ++channel) ASSERT_NEAR(a.light.color[channel], b.light.color[channel], 2e-6);
  ASSERT_EQ(a.profile.any, b.profile.any);
  ASSERT_EQ(a.profile.alphaEntrance, b.profile.alphaEntrance);
  ASSERT_EQ(a.profile.alphaExit, b.profile.alphaExit);
  ASSERT_NEAR(a.profile.accumulatedEnd, b.profile.accumulatedEnd, 3e-7f);
  ASSERT_EQ(a.depth().hasDepth, b.depth().hasDepth);
  ASSERT_NEAR(a.depth().depth, b.depth().depth, reach);
  ASSERT_NEAR(a.depth().spread, b.depth().spread, 10.0f * reach);
}

/// As the marchers find a whole ray's.
template <class Depth>
void expectTheWhole(const TestRay& ray, const RayState<Depth>& state) {
  MadeUpSource<8> source = sourceOf(ray);
  RayColor color;
  std::vector<CountingSample> counting;
  marchRay(ray.path, 0, ray.path.lattice.count, source, ByPlace{}, ray.limits, color,
           [&](const CountingSample& sample) {
             counting.push_back(sample);
             return true;
           });
  ProfileFold profile;
  for (const CountingSample& sample : counting) profile.add(sample);
  RayState<Depth> whole;
  whole.light = {color.color(), color.transmittance.exact()};
  if (Depth::kTwoPass) whole.profile = profile;
  whole.fold = Depth::start(kThreshold, profile);
  for (const CountingSample& sample : counting) whole.fold.add(sample);
  expectNear(whole, state, 1e-4f);
  for (int channel = 0; channel < 4; ++channel)
    ASSERT_NEAR(state.light.premultiplied()[channel], color.premultiplied()[channel], 2e-6f);
}

TEST(Case35, RayStatesPiecesMakeTheWhole) {
  for (const Heuristic heuristic : everyHeuristic())
    visitHeuristic(heuristic, [&](auto depth) {
      using Depth = decltype(depth);
      std::mt19937 random(kSeed);
      for (int i = 0; i < kRays; ++i) {
        const TestRay ray = randomRay(random);
        for (const int pieces : {1, 2, 7}) {
          SCOPED_TRACE("seed " + std::to_string(kSeed) + ", ray " + std::to_string(i) + " in " +
                       std::to_string(pieces));
          expectTheWhole(ray, combined(statesOf<Depth>(ray, randomCuts(pieces, ray.path.lattice.count, random))));
          if (testing::Test::HasFatalFailure()) return;
        }
      }
    });
  recordExact("RayState of 1, 2, 7 pieces: colour within 2e-6, depth within 1e-4", "the whole ray's");
}

TEST(Case35, RayStatesCombiningIsAssociativeAndHasAnIdentity) {
  for (const Heuristic heuristic : everyHeuristic())
    visitHeuristic(heuristic, [&](auto depth) {
      using State = RayState<decltype(depth)>;
      std::mt19937 random(kSeed + 1);
      for (int i = 0; i < kRays; ++i) {
        SCOPED_TRACE("seed " + std::to_string(kSeed + 1) + ", ray " + std::to_string(i));
        const TestRay ray = randomRay(random);
        const auto s = statesOf<decltype(depth)>(ray, randomCuts(4, ray.path.lattice.count, random));
        const auto both = [](const State& front, const State& back) { return State::combine(front, back); };
        expectNear(both(both(both(s[0], s[1]), s[2]), s[3]), both(s[0], both(s[1], both(s[2], s[3]))), 1e-4f);
        expectNear(both(both(s[0], s[1]), both(s[2], s[3])), both(s[0], both(both(s[1], s[2]), s[3])), 1e-4f);
        for (const State& state : s) {
          expectNear(both(State{}, state), state, 0.0f);
          expectNear(both(state, State{}), state, 0.0f);
          ASSERT_EQ(both(State{}, state).light.color, state.light.color);
          ASSERT_EQ(both(state, State{}).light.color, state.light.color);
        }
        if (testing::Test::HasFatalFailure()) return;
      }
    });
  recordExact("RayState::combine in any order: colour within 2e-6, depth within 1e-4", "itself");
}

}  // namespace
}  // namespace warpscope

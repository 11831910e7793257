// Single, full and empty frames: compaction keeps what there is, in order, whatever the number of threads.
// Mirrors render/march/compact.h; std::copy_if is the oracle.
#include "render/march/compact.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <random>

namespace warpscope {
namespace {

/// `count` pixels of which a share `kept` has a sample; empty pixels hold other bits, which must not count. A seventh of all codes is 1.
void fill(size_t count, double kept, uint32_t seed, std::vector<PackedSample>& samples, std::vector<Rgba8>& colors) {
  std::mt19937_64 random(seed);
  std::bernoulli_distribution keep(kept);
  samples.resize(count);
  colors.resize(count);
  for (size_t i = 0; i < count; ++i) {
    const uint64_t position = random() & ((uint64_t{1} << 54) - 1);
    const uint64_t code = keep(random) ? (i % 7 == 0 ? 1 : 1 + random() % kRadiusCodeMax) : 0;
    samples[i] = position | code << 54;
    colors[i] = static_cast<Rgba8>(i);
  }
}

void expectCompacted(const std::vector<PackedSample>& samples, const std::vector<Rgba8>& colors, const std::string& label) {
  std::vector<PackedSample> keptSamples;
  std::vector<Rgba8> keptColors;
  std::copy_if(samples.begin(), samples.end(), std::back_inserter(keptSamples), [](PackedSample s) { return s >> 54 != 0; });
  std::copy_if(colors.begin(), colors.end(), std::back_inserter(keptColors), [&](Rgba8 c) { return samples[c] >> 54 != 0; });
  SampleFrame frame;
  frame.samples.assign(3, 42);  // what an earlier frame left behind
  frame.colors.assign(5, 42);
  compact(samples, colors, 1, frame);
  EXPECT_TRUE(std::ranges::equal(frame.samples, keptSamples)) << label;
  EXPECT_TRUE(std::ranges::equal(frame.colors, keptColors)) << label;
}

TEST(Compact, AgreesWithCopyIf) {
  std::vector<PackedSample> samples;
  std::vector<Rgba8> colors;
  for (const size_t count : {0, 1, 2, 16383, 16384, 16385, 32768, 100003})
    for (const double kept : {0.0, 1e-3, 0.5, 0.999, 1.0}) {
      fill(count, kept, 29, samples, colors);
      expectCompacted(samples, colors, "seed 29, " + std::to_string(count) + " pixels, " + std::to_string(kept));
    }
}

TEST(Compact, ASingleSampleAnywhere) {
  std::vector<PackedSample> samples;
  std::vector<Rgba8> colors;
  for (const size_t place : {size_t{0}, size_t{16383}, size_t{16384}, size_t{49999}}) {
    fill(50000, 0.0, 30, samples, colors);
    samples[place] |= PackedSample{1} << 54;
    expectCompacted(samples, colors, "single at " + std::to_string(place));
  }
}

TEST(Compact, OneThreadGivesTheSame) {
  std::vector<PackedSample> samples;
  std::vector<Rgba8> colors;
  fill(200001, 0.3, 31, samples, colors);
  SampleFrame parallel, serial;
  compact(samples, colors, 1, parallel);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  compact(samples, colors, 1, serial);
  EXPECT_TRUE(parallel.samples == serial.samples);
  EXPECT_TRUE(parallel.colors == serial.colors);
}

RC_GTEST_PROP(Compact, AgreesWithCopyIfAtAnySize, (uint32_t seed)) {
  std::vector<PackedSample> samples;
  std::vector<Rgba8> colors;
  fill(seed % 40000, (seed >> 16) / 65536.0, seed, samples, colors);
  SampleFrame frame;
  compact(samples, colors, 1, frame);
  std::erase_if(colors, [&](Rgba8 c) { return samples[c] >> 54 == 0; });
  std::erase_if(samples, [](PackedSample s) { return s >> 54 == 0; });
  RC_ASSERT(std::ranges::equal(frame.samples, samples));
  RC_ASSERT(std::ranges::equal(frame.colors, colors));
}

}  // namespace
}  // namespace warpscope

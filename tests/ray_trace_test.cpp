// A traced ray is the one that frames are made of: the same depths, colours and segments, in every mode and by every heuristic.
// Mirrors render/march/ray_trace.h.
#include "render/march/ray_trace.h"

#include <gtest/gtest.h>

#include <cmath>

#include "marcher_cases.h"
#include "render/base/error.h"
#include "render/effects/mode_settings.h"
#include "test_volumes.h"
#include "tests/frame_samples.h"

namespace warpscope {
namespace {

constexpr glm::uvec3 kTracedDims(40, 30, 36);

class RayTraceTest : public ::testing::Test {
 protected:
  VolumePtr volume_ = makeTestVolume(VoxelType::uint8, kTracedDims, blobs(kTracedDims, 3));
  TransferFunction function_{{{20.0, {0.1f, 0.3f, 1.0f}, 0.0f}, {120.0, {1.0f, 0.6f, 0.2f}, 0.08f}, {255.0, glm::vec3(1.0f), 0.5f}}};
  MarcherPtr marcher_ = makeCpuMarcher(volume_, function_);
  std::unique_ptr<RayTracer> tracer_ = makeRayTracer(volume_, function_);
  Camera camera_ = lookingFrom({45.0f, 20.0f, 30.0f}, {}, 24, 20);
};

/// The ray of one pixel of a frame: its sample's index, if it has one.
std::optional<size_t> sampleIn(const SampleFrame& frame, const glm::uvec2& pixel) {
  for (size_t i = 0; i < frame.size(); ++i)
    if (columnOf(frame.samples[i]) == pixel.x && rowOf(frame.samples[i]) == pixel.y) return i;
  return std::nullopt;
}

TEST_F(RayTraceTest, DepthsAreThoseOfFrames) {
  for (const RenderMode mode : {RenderMode::composite, RenderMode::mip, RenderMode::isosurface})
    for (const auto& heuristic : kHeuristics) {
      SCOPED_TRACE(std::string(heuristic.name) + ", mode " + std::to_string(static_cast<int>(mode)));
      MarchSettings settings;
      settings.render.effects.mode = mode;
      if (mode == RenderMode::isosurface) settings.render.effects.isoValues = parseIsoValues("15 40", "it");
      settings.sample.heuristic = heuristic.value;
      settings.sample.threshold = 0.4f;
      const SampleFrame frame = marcher_->march(camera_, settings);
      size_t found = 0;
      for (uint32_t y = 0; y < camera_.height; y += 2)
        for (uint32_t x = 0; x < camera_.width; x += 2) {
          const RayTrace trace = tracer_->trace(camera_, settings, {x, y});
          const std::optional<size_t> sample = sampleIn(frame, {x, y});
          ASSERT_EQ(trace.depths.size(), kHeuristics.size());
          const TracedDepth& depth = trace.depths[static_cast<size_t>(&heuristic - kHeuristics.data())];
          EXPECT_EQ(depth.heuristic, heuristic.value);
          ASSERT_EQ(depth.result.hasDepth, sample.has_value()) << x << " " << y;
          if (!sample) continue;
          ++found;
          EXPECT_EQ(depthCode(frame.samples[*sample]), encodeDepth(depth.result.depth * trace.cosine, frame.quantization.depthStep)) << x << " " << y;
        }
      EXPECT_GT(found, 15u);
    }
}

TEST_F(RayTraceTest, SegmentsAreThoseOfFramesAndColoursThoseOfPictures) {
  MarchSettings settings;
  settings.sample.segments = 3;
  const SampleFrame frame = marcher_->march(camera_, settings);
  const Image<glm::vec4> picture = rendered(*marcher_, camera_, settings);
  size_t segments = 0, compared = 0, next = 0;
  for (uint32_t y = 0; y < camera_.height; ++y)
    for (uint32_t x = 0; x < camera_.width; ++x) {
      const RayTrace trace = tracer_->trace(camera_, settings, {x, y});
      EXPECT_EQ(trace.color, picture(x, y)) << x << " " << y;
      const auto count = static_cast<size_t>(frame.segments.rays[size_t{y} * camera_.width + x].count());
      EXPECT_GE(trace.segments.size(), count) << "what shows nothing in 8 bits is not sent";
      EXPECT_LE(trace.segments.size(), 3u);
      if (count > 0 && count == trace.segments.size())
        for (size_t i = 0; i < count; ++i, ++compared) {
          EXPECT_EQ(frame.segments.depths[next + i].begin, encodeDepth(trace.segments[i].begin * trace.cosine, frame.quantization.depthStep));
          EXPECT_EQ(frame.segments.depths[next + i].end, encodeDepth(trace.segments[i].end * trace.cosine, frame.quantization.depthStep));
        }
      next += count;
      segments += count;
    }
  EXPECT_GT(segments, 100u);
  EXPECT_GT(compared, segments / 2);
}

TEST_F(RayTraceTest, PlacesSayWhatTheVolumeIsThere) {
  // A value that is its place along x: what a ray meets there is known.
  const VolumePtr ramp = makeTestVolume(VoxelType::float32, kTracedDims, [](const glm::ivec3& at) { return 10.0 * at.x; });
  const TransferFunction function{{{0.0, glm::vec3(0.0f), 0.0f}, {400.0, glm::vec3(1.0f), 0.4f}}};
  const RayTrace trace = makeRayTracer(ramp, function)->trace(camera_, {}, {12, 10});
  ASSERT_GT(trace.places.size(), 50u);
  EXPECT_FLOAT_EQ(trace.places.front().t, trace.begin);
  EXPECT_FLOAT_EQ(trace.places.back().t, trace.end);
  for (const RayPlace& place : trace.places) {
    const float x = trace.ray.at(place.t).x - ramp->bounds().lower.x - 0.5f;
    const double expected = 10.0 * std::clamp(static_cast<double>(x), 0.0, 39.0);
    EXPECT_NEAR(place.value, expected, 1e-3);
    EXPECT_NEAR(place.look.a, expected / 1000.0, 1e-5);
  }
  for (size_t i = 1; i < trace.samples.size(); ++i) EXPECT_GT(trace.samples[i].t, trace.samples[i - 1].t);
}

TEST_F(RayTraceTest, AVoxelThatIsNoNumberHasNoValue) {
  const VolumePtr holey = makeTestVolume(VoxelType::float32, kTracedDims, [](const glm::ivec3& at) { return at.x > 10 && at.x < 20 ? std::nan("") : 50.0; });
  const RayTrace trace = makeRayTracer(holey, everywhere(0.1f))->trace(camera_, {}, {12, 10});
  EXPECT_TRUE(std::ranges::any_of(trace.places, [](const RayPlace& place) { return std::isnan(place.value); }));
  EXPECT_TRUE(std::ranges::any_of(trace.places, [](const RayPlace& place) { return place.value == 50.0; }));
  for (const TracedDepth& depth : trace.depths) EXPECT_TRUE(std::isfinite(depth.result.depth));
}

TEST_F(RayTraceTest, ARayBesideTheVolumeHasNothing) {
  const Camera past = lookingFrom({70.0f, 30.0f, 45.0f}, {140.0f, 30.0f, 45.0f}, 8, 8);
  const RayTrace trace = tracer_->trace(past, {}, {4, 4});
  EXPECT_TRUE(trace.places.empty() && trace.samples.empty() && trace.segments.empty());
  EXPECT_LE(trace.end, trace.begin);
  EXPECT_EQ(trace.color, glm::vec4(0.0f));
  for (const TracedDepth& depth : trace.depths) EXPECT_FALSE(depth.result.hasDepth);
}

TEST_F(RayTraceTest, WhatIsWrongIsRefused) {
  EXPECT_THROW(tracer_->trace(camera_, {}, {24, 0}), UsageError);
  EXPECT_THROW(tracer_->trace(camera_, {}, {0, 20}), UsageError);
  MarchSettings bad;
  bad.render.step = 0.0f;
  EXPECT_THROW(tracer_->trace(camera_, bad, {0, 0}), UsageError);
  Camera broken = camera_;
  broken.eye.x = std::nanf("");
  EXPECT_THROW(tracer_->trace(broken, {}, {0, 0}), InputError);
  std::stop_source stopped;
  stopped.request_stop();
  EXPECT_THROW(tracer_->trace(camera_, {}, {12, 10}, stopped.get_token()), OperationCancelled);
}

TEST_F(RayTraceTest, ALongRayHasNoMorePlacesThanThereIsRoomFor) {
  MarchSettings fine;
  fine.render.step = 1e-3f;
  EXPECT_EQ(tracer_->trace(camera_, fine, {12, 10}).places.size(), kMostRayPlaces);
}

}  // namespace
}  // namespace warpscope

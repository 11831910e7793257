// A frame's own picture: which ray is seen in each pixel, and what its samples look like over one another.
// Mirrors render/march/own_picture.h.
#include "render/march/own_picture.h"

#include <gtest/gtest.h>

#include <random>

#include "render/volume/procedural.h"
#include "render/warp/multihit_warp.h"
#include "render/warp/warp.h"
#include "tests/frame_samples.h"
#include "tests/layered_frames.h"
#include "tests/marcher_cases.h"

namespace warpscope {
namespace {

constexpr uint32_t kWidth = 40, kHeight = 30;

/// Looks along -z; every pixel has 0 to 4 samples, at random depths that rise, of random colours.
SampleFrame layeredFrame(uint32_t seed) {
  std::mt19937 random(seed);
  SampleFrame frame;
  frame.camera = lookingFrom({3.0f, 2.0f, 40.0f}, {}, kWidth, kHeight);
  frame.quantization = {{glm::vec3(-40.0f), glm::vec3(40.0f)}, 1.0f, 10.0f, 0x1p-10f};
  std::vector<uint8_t> layers;
  for (uint32_t pixel = 0; pixel < kWidth * kHeight; ++pixel) {
    float depth = 20.0f;
    for (uint32_t k = 0, count = random() % 5; k < count; ++k) {
      depth += 0.5f + static_cast<float>(random() % 8);
      frame.samples.push_back(sampleOnRay(frame, pixel, depth, 0.2f));
      frame.colors.push_back(static_cast<Rgba8>(random()));
      layers.push_back(static_cast<uint8_t>(k));
    }
  }
  frame.planes.push_back(layerPlane(layers));
  return frame;
}

/// The colours of samples [first, past) over one another, as rays are composited: by what is left of the light.
glm::vec4 composited(const SampleFrame& frame, size_t first, size_t past) {
  glm::dvec3 sum(0.0);
  double left = 1.0;
  for (size_t i = first; i < past; ++i) {
    const glm::vec4 color = decodeRgba8(frame.colors[i]);
    sum += left * glm::dvec3(color);
    left *= 1.0 - static_cast<double>(color.a);
  }
  return {glm::vec3(sum), static_cast<float>(1.0 - left)};
}

void expectNear(const glm::vec4& a, const glm::vec4& b, float tolerance) {
  for (int channel = 0; channel < 4; ++channel) ASSERT_NEAR(a[channel], b[channel], tolerance);
}

TEST(OwnPicture, EveryPixelShowsItsRaysSamplesOverOneAnother) {
  for (const uint32_t seed : {1u, 2u, 3u}) {
    const SampleFrame frame = layeredFrame(seed);
    const std::span<const uint8_t> layers = frame.layers();
    const Image<uint32_t> rays = ownPicture(frame);
    Image<glm::vec4> color;
    resolveRayColors(frame, rays, color);
    size_t first = 0, seen = 0;
    for (size_t pixel = 0; pixel < rays.size(); ++pixel) {
      if (rays[pixel] == kNoSample) {
        EXPECT_EQ(color[pixel], glm::vec4(0.0f));
        continue;
      }
      ++seen;
      ASSERT_EQ(rays[pixel], first) << "seed " << seed << ", pixel " << pixel;
      const size_t past = endOfRay(layers, first);
      expectNear(color[pixel], composited(frame, first, past), 1e-6f);
      first = past;
    }
    EXPECT_EQ(first, frame.size());
    EXPECT_GT(seen, kWidth * kHeight / 2);
    EXPECT_LT(seen, size_t{kWidth} * kHeight);
  }
}

TEST(OwnPicture, WithOneSampleARayItIsTheSampleItself) {
  SampleFrame frame = layeredFrame(4);
  const SampleFrame several = frame;
  frame.samples.clear();
  frame.colors.clear();
  frame.planes.clear();
  for (size_t first = 0; first < several.size(); first = endOfRay(several.layers(), first)) {
    frame.samples.push_back(several.samples[first]);
    frame.colors.push_back(several.colors[first]);
  }
  const Image<uint32_t> rays = ownPicture(frame);
  Image<glm::vec4> color, expected;
  resolveRayColors(frame, rays, color);
  resolveColors(frame, rays, expected);
  EXPECT_TRUE(sameBits(color, expected));
  // That every sample is its ray's first may be said as well.
  frame.planes.push_back(layerPlane(std::vector<uint8_t>(frame.size(), 0)));
  EXPECT_TRUE(ownPicture(frame) == rays);
  resolveRayColors(frame, rays, color);
  EXPECT_TRUE(sameBits(color, expected));
}

TEST(OwnPicture, SamplesThatNoPlaneCountsAreRaysOfTheirOwn) {
  SampleFrame frame = layeredFrame(5);
  const Image<uint32_t> nearest = ownPicture(frame);
  frame.planes.clear();
  EXPECT_TRUE(ownPicture(frame) == nearest);
  Image<glm::vec4> color, expected;
  resolveRayColors(frame, nearest, color);
  resolveColors(frame, nearest, expected);
  EXPECT_TRUE(sameBits(color, expected));
}

/// Depths may be coarse: rays stay in their pixels.
TEST(OwnPicture, RaysStayInTheirPixelsHoweverCoarseDepthsAre) {
  SampleFrame frame = layeredFrame(6);
  const Image<uint32_t> rays = ownPicture(frame);
  const std::vector<float> depths = [&] {
    std::vector<float> of;
    for (const PackedSample sample : frame.samples) of.push_back(decodeDepth(depthCode(sample), frame.quantization.depthStep));
    return of;
  }();
  frame.quantization.depthStep = 64.0f;
  for (size_t i = 0; i < frame.size(); ++i)
    frame.samples[i] = packSample(columnOf(frame.samples[i]), rowOf(frame.samples[i]), depths[i], 0.2f, frame.quantization);
  EXPECT_TRUE(ownPicture(frame) == rays);
}

TEST(OwnPicture, HoldShowsIt) {
  const auto frame = std::make_shared<const SampleFrame>(layeredFrame(7));
  const auto hold = makeWarp(findWarp("hold"), {});
  hold->setFrame(frame, {});
  WarpedImage image;
  hold->draw(frame->camera, {}, image);
  Image<glm::vec4> expected;
  resolveRayColors(*frame, ownPicture(*frame), expected);
  EXPECT_TRUE(image.samples == ownPicture(*frame));
  EXPECT_TRUE(sameBits(image.color, expected));
}

/// A view of another shape shows it as it is: cut off or with nothing beside it, never stretched.
TEST(OwnPicture, HoldDoesNotStretchIt) {
  const auto frame = std::make_shared<const SampleFrame>(layeredFrame(7));
  const Image<uint32_t> own = ownPicture(*frame);
  const uint32_t side = std::min(kWidth, kHeight);
  const auto hold = makeWarp(findWarp("hold"), {});
  hold->setFrame(frame, {});
  const auto held = [&](uint32_t width, uint32_t height) {
    Camera camera = frame->camera;
    camera.width = width;
    camera.height = height;
    WarpedImage image;
    hold->draw(camera, {}, image);
    return image.samples;
  };
  const Image<uint32_t> square = held(side, side);  // the middle of it
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x) ASSERT_EQ(square(x, y), own(x + (kWidth - side) / 2, y + (kHeight - side) / 2)) << x << ", " << y;
  const Image<uint32_t> large = held(3 * side, 3 * side);
  for (uint32_t y = 0; y < 3 * side; ++y)
    for (uint32_t x = 0; x < 3 * side; ++x) ASSERT_EQ(large(x, y), square(x / 3, y / 3)) << x << ", " << y;
  const Image<uint32_t> wide = held(kWidth + 40 * side, kHeight);  // all of it, and nothing beside it
  for (uint32_t y = 0; y < kHeight; ++y)
    for (uint32_t x = 0; x < wide.width(); ++x) {
      const bool isInside = x >= 20 * side && x < 20 * side + kWidth;
      ASSERT_EQ(wide(x, y), isInside ? own(x - 20 * side, y) : kNoSample) << x << ", " << y;
    }
}

/// Where spheres fit into their pixels, a ray from the frame's own eye meets its own samples and no others.
TEST(OwnPicture, MultihitShowsItWhereSpheresFitIntoTheirPixels) {
  SampleFrame made = layeredFrame(8);
  const float tanHalfPixel = made.camera.tanHalfFovY / static_cast<float>(kHeight);
  for (size_t i = 0; i < made.size(); ++i) {
    const PackedSample sample = made.samples[i];
    const float behind = decodeDepth(depthCode(sample), made.quantization.depthStep);
    made.samples[i] = packSample(columnOf(sample), rowOf(sample), behind, 0.5f * tanHalfPixel * (made.quantization.nearDepth + behind), made.quantization);
  }
  const auto frame = std::make_shared<const SampleFrame>(std::move(made));
  Image<glm::vec4> expected;
  const Image<uint32_t> rays = ownPicture(*frame);
  resolveRayColors(*frame, rays, expected);
  WarpSettings settings;
  settings.knobs.set(kHitsKnob, 4);
  const auto multihit = makeWarp(findWarp("multihit"), {});
  multihit->setFrame(frame, settings);
  WarpedImage image;
  multihit->draw(frame->camera, settings, image);
  EXPECT_TRUE(image.samples == rays);
  EXPECT_TRUE(sameBits(image.color, expected));
  // First-hit techniques show the nearest sample.
  const auto spheres = makeWarp(findWarp("spheres"), {});
  spheres->setFrame(frame, settings);
  spheres->draw(frame->camera, settings, image);
  EXPECT_TRUE(image.samples == rays);
  resolveColors(*frame, rays, expected);
  EXPECT_TRUE(sameBits(image.color, expected));
}

/// A marched frame's rays, taken apart, look as they did.
TEST(OwnPicture, LayersOfAMarchedFrameLookLikeIt) {
  const VolumePtr volume = makeProceduralVolume("shells", {48, 48, 48});
  const TransferFunction look{{{0.1, {0.1f, 0.2f, 0.9f}, 0.0f}, {0.3, {0.2f, 0.9f, 0.1f}, 0.05f}, {1.0, {0.9f, 0.3f, 0.1f}, 0.4f}}};
  const MarcherPtr marcher = makeCpuMarcher(volume, look);
  const Camera camera = lookingFrom(1.2f * volume->bounds().upper + glm::vec3(10.0f, 0.0f, 60.0f), {}, 96, 80);
  const Heuristic one[] = {Heuristic::gradient}, four[] = {Heuristic::entrance, Heuristic::gradient, Heuristic::peak, Heuristic::exit};
  const SampleFrame flat = marchLayers(*marcher, camera, {}, one), deep = marchLayers(*marcher, camera, {}, four);
  ASSERT_GT(flat.size(), 500u);
  ASSERT_GT(deep.size(), 3 * flat.size() / 2);
  Image<glm::vec4> flatColor, deepColor;
  resolveRayColors(flat, ownPicture(flat), flatColor);
  resolveRayColors(deep, ownPicture(deep), deepColor);
  for (size_t i = 0; i < flatColor.size(); ++i) expectNear(flatColor[i], deepColor[i], 0.012f);  // opacities are rounded to 8 bits, four times
}

}  // namespace
}  // namespace warpscope

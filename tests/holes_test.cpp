// What counts as a hole, also in identical images and NaN pixels, and that a warp leaves them open instead of painting background.
// Mirrors render/metrics/holes.h.
#include "render/metrics/holes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/base/error.h"
#include "render/march/marcher_cpu.h"
#include "render/warp/spheres_warp.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

WarpedImage warped(uint32_t width, uint32_t height, uint32_t id) {
  return {Image<glm::vec4>(width, height), Image<uint32_t>(width, height, id)};
}

TEST(Holes, OnlyUncoveredPixelsWhereTheReferenceShowsSomething) {
  WarpedImage image = warped(4, 1, kNoSample);
  image.samples(0, 0) = 0;
  image.samples(1, 0) = kNotASample;
  Image<glm::vec4> reference(4, 1, glm::vec4(1.0f));
  reference(3, 0) = glm::vec4(0.0f);  // background
  const HoleCount count = countHoles(image, reference);
  EXPECT_EQ(count.shown, 3u);
  EXPECT_EQ(count.holes, 1u);
  EXPECT_DOUBLE_EQ(count.fraction(), 1.0 / 3.0);
}

TEST(Holes, TheReferenceShowsSomethingFromOne255thOn) {
  const auto holesAt = [](float alpha) { return countHoles(warped(1, 1, kNoSample), {1, 1, glm::vec4(0, 0, 0, alpha)}).holes; };
  EXPECT_EQ(holesAt(1.0f / 255.0f), 1u);
  EXPECT_EQ(holesAt(std::nextafter(1.0f / 255.0f, 0.0f)), 0u);
  EXPECT_EQ(holesAt(1.0f), 1u);
  EXPECT_EQ(holesAt(0.0f), 0u);
}

TEST(Holes, CoveredIsNoHoleEvenIfItsColourIsClear) {
  EXPECT_EQ(countHoles(warped(3, 2, 7), {3, 2, glm::vec4(1.0f)}).holes, 0u);
}

TEST(Holes, NothingShownIsNoHole) {
  const HoleCount count = countHoles(warped(5, 5, kNoSample), {5, 5, glm::vec4(0.0f)});
  EXPECT_EQ(count.shown, 0u);
  EXPECT_EQ(count.fraction(), 0.0);
}

TEST(Holes, RefusesWhatHasNoAnswer) {
  EXPECT_THROW(countHoles(warped(2, 3, 0), {3, 2}), InputError);
  EXPECT_THROW(countHoles(warped(2, 3, 0), {2, 3, glm::vec4(0, 0, 0, std::nanf(""))}), InputError);
}

TEST(Holes, DisocclusionsStayOpen) {
  // A small plate before a large one. From the server's place the small one hides the middle of the large one, which the turned
  // camera sees.
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {48, 48, 48}, [](const glm::ivec3& p) {
    const bool front = p.z == 40 && std::abs(p.x - 24) < 8 && std::abs(p.y - 24) < 8;
    const bool back = p.z == 8 && std::abs(p.x - 24) < 22 && std::abs(p.y - 24) < 22;
    return front || back ? 255.0 : 0.0;
  });
  const TransferFunction function{{{100.0, glm::vec3(1.0f), 0.0f}, {120.0, glm::vec3(1.0f), 1.0f}}};
  WarpResources resources;
  resources.marcher = makeCpuMarcher(volume, function);
  Camera server;
  server.eye = {0.0f, 0.0f, 120.0f};
  server.tanHalfFovY = 0.3f;
  server.width = server.height = 128;
  const auto frame = std::make_shared<const SampleFrame>(resources.marcher->march(server, {}));
  Camera client = server;
  const float angle = 0.35f;
  client.eye = 120.0f * glm::vec3(std::sin(angle), 0.0f, std::cos(angle));
  client.right = {std::cos(angle), 0.0f, -std::sin(angle)};
  client.forward = -glm::vec3(std::sin(angle), 0.0f, std::cos(angle));
  Image<glm::vec4> reference;
  resources.marcher->render(client, {}, reference);

  const auto warp = makeWarp(findWarp("spheres"), resources);
  warp->setFrame(frame, {});
  WarpedImage image;
  warp->draw(client, {}, image);
  const HoleCount count = countHoles(image, reference);
  EXPECT_GT(count.fraction(), 0.02);
  EXPECT_LT(count.fraction(), 0.3);
  // The middle of what the small plate hid: on the large one, where the line from the server's eye through the small one's centre ends.
  const Projection hidden = project(client, {0.0f, 0.0f, 8.0f - 23.5f});
  const auto x = static_cast<uint32_t>(hidden.pixel.x), y = static_cast<uint32_t>(hidden.pixel.y);
  EXPECT_GT(reference(x, y).a, 0.9f);
  EXPECT_EQ(image.samples(x, y), kNoSample);
  for (size_t i = 0; i < image.samples.size(); ++i) {
    if (image.samples[i] == kNoSample) {
      ASSERT_EQ(image.color[i], glm::vec4(0.0f));
    }
  }
}

}  // namespace
}  // namespace warpscope

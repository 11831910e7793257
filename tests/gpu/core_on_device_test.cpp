// The shared headers give the same bits on a CUDA device as on the host.
// Random inputs over magnitudes; the seed is fixed, so that a failure repeats.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "render/cuda/devices.h"
#include "tests/gpu/core_probe.h"

namespace warpscope {
namespace {

constexpr uint32_t kSeed = 20120913;

std::vector<CoreProbeInput> randomInputs(size_t count) {
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const auto symmetric = [&](float size) { return size * (2.0f * unit(random) - 1.0f); };
  std::vector<CoreProbeInput> inputs(count);
  for (CoreProbeInput& in : inputs) {
    const float size = std::exp2(std::floor(12.0f * unit(random)));
    in.quantization.bounds = {glm::vec3(-size, -0.5f * size, -size), glm::vec3(size, 0.5f * size, unit(random) < 0.1f ? -size : size)};
    in.quantization.radiusUnit = radiusUnitFor(size * unit(random));
    in.camera.forward = glm::normalize(glm::vec3(symmetric(1.0f), symmetric(1.0f), -1.0f));
    in.camera.right = glm::normalize(glm::cross(in.camera.forward, glm::vec3(0.0f, 1.0f, 0.0f)));
    in.camera.up = glm::cross(in.camera.right, in.camera.forward);
    in.camera.eye = -2.0f * size * in.camera.forward;
    in.camera.width = 1 + random() % 2000;
    in.camera.height = 1 + random() % 2000;
    in.quantization = quantizationFor(in.camera, in.quantization.bounds, in.quantization.radiusUnit);
    in.grid = makeSampleGrid(in.camera, in.quantization);
    in.pixel = {unit(random) * static_cast<float>(in.camera.width), unit(random) * static_cast<float>(in.camera.height)};
    in.point = {symmetric(size), symmetric(0.5f * size), symmetric(size)};
    in.radius = size * unit(random);
    in.step = 0.25f + unit(random);
    for (float& alpha : in.alphas) alpha = random() % 2 ? unit(random) : std::exp2(-40.0f * unit(random));
  }
  return inputs;
}

bool same(float a, float b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same(const glm::vec3& a, const glm::vec3& b) { return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z); }

TEST(CoreOnDevice, SameBitsAsHost) {
  const cuda::DeviceReport report = cuda::listDevices();
  if (report.devices.empty()) GTEST_SKIP() << "no GPU here: " << report.reason;
  const std::vector<CoreProbeInput> inputs = randomInputs(200000);
  const std::vector<CoreProbeResult> device = probeCoreOnDevice(inputs);
  ASSERT_EQ(device.size(), inputs.size());
  size_t hits = 0;
  for (size_t i = 0; i < inputs.size(); ++i) {
    const CoreProbeResult host = probeCore(inputs[i]);
    const CoreProbeResult& dev = device[i];
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", input " + std::to_string(i));
    ASSERT_TRUE(same(host.ray.origin, dev.ray.origin) && same(host.ray.direction, dev.ray.direction));
    ASSERT_TRUE(same(host.sphereT, dev.sphereT)) << host.sphereT << " and " << dev.sphereT;
    ASSERT_TRUE(same(host.interval.tNear, dev.interval.tNear) && same(host.interval.tFar, dev.interval.tFar));
    ASSERT_TRUE(same(host.projection.pixel.x, dev.projection.pixel.x) && same(host.projection.pixel.y, dev.projection.pixel.y));
    ASSERT_EQ(host.packed, dev.packed);
    ASSERT_TRUE(same(host.pixelRay.ray.origin, dev.pixelRay.ray.origin) && same(host.pixelRay.ray.direction, dev.pixelRay.ray.direction) &&
                same(host.pixelRay.cosine, dev.pixelRay.cosine));
    ASSERT_TRUE(same(host.unpacked.center, dev.unpacked.center) && same(host.unpacked.radius, dev.unpacked.radius));
    ASSERT_EQ(host.morton, dev.morton);
    ASSERT_EQ(host.latticeCount, dev.latticeCount);
    ASSERT_TRUE(same(host.latticeLast, dev.latticeLast));
    for (int h = 0; h < 10; ++h) ASSERT_TRUE(same(host.depths[h], dev.depths[h])) << "heuristic " << h;
    for (int h = 0; h < 10; ++h)
      ASSERT_TRUE(same(host.combinedDepths[h], dev.combinedDepths[h])) << "heuristic " << h << " in two pieces";
    ASSERT_EQ(host.combinedColor, dev.combinedColor);
    ASSERT_EQ(host.combinedTransmittance, dev.combinedTransmittance);
    ASSERT_TRUE(same(host.transmittance, dev.transmittance));
    ASSERT_TRUE(same(host.trilinear, dev.trilinear));
    ASSERT_EQ(host.tableIndex, dev.tableIndex);
    ASSERT_EQ(host.axisIndex, dev.axisIndex);
    ASSERT_TRUE(same(host.axisWeight, dev.axisWeight));
    ASSERT_TRUE(same(host.partialOpacity, dev.partialOpacity))
        << inputs[i].alphas[1] << " over " << inputs[i].alphas[2];
    hits += std::isfinite(host.sphereT);
  }
  EXPECT_GT(hits, inputs.size() / 100);  // the inputs exercise what they are meant to
}

TEST(CoreOnDevice, DevicesAreDescribed) {
  const cuda::DeviceReport report = cuda::listDevices();
  if (report.devices.empty()) {
    EXPECT_FALSE(report.reason.empty());
    GTEST_SKIP() << "no GPU here: " << report.reason;
  }
  for (const cuda::Device& device : report.devices) {
    EXPECT_FALSE(device.name.empty());
    EXPECT_GE(device.computeMajor, 5);
    EXPECT_GT(device.memoryBytes, size_t{1} << 28);
  }
}

}  // namespace
}  // namespace warpscope

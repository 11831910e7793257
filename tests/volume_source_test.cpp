// The vectors over a batch of samples against one sample at a time through voxel_access.h: the same bits.
// Mirrors render/march/volume_source.h, volume_source_scalar.h, volume_source_pairs.h and render/volume/voxel_access.h.
#include "render/march/volume_source.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "marcher_cases.h"
#include "render/core/pixel_grid.h"
#include "render/march/march.h"
#include "render/march/march_setup.h"
#include "render/march/volume_source_pairs.h"
#include "test_volumes.h"
#include "view_cells.h"

namespace warpscope {
namespace {

const double kNan = std::nan("");
const double kInfinity = std::numeric_limits<double>::infinity();

/// One sample at a time, by the shared formulas, skipping nothing.
template <class Voxel>
struct ScalarSource {
  static constexpr int kBatch = 1;
  const Volume& volume;
  const TransferTable& table;
  const ValueScale& scale;
  const Ray& ray;
  const RayLattice& lattice;
  glm::vec4 entry{0.0f};
  float ofUnit = 0.0f;

  int skip(int i) const { return i; }
  uint32_t classify(int i, int) {
    const glm::ivec3 n(volume.dims());
    const glm::vec3 perUnit = 1.0f / volume.geometry().voxelEdges();
    const glm::vec3 origin = (ray.origin - volume.bounds().lower) * perUnit - 0.5f;
    const glm::vec3 direction = ray.direction * perUnit;
    int index[3];
    float weight[3];
    for (int axis = 0; axis < 3; ++axis)
      axisCell(mulAdd(lattice.t(i), direction[axis], origin[axis]), axisEndsOf(n[axis]), index[axis], weight[axis]);
    float corner[8];
    bool allFinite = true;
    for (int k = 0; k < 8; ++k) {
      const int x = index[0] + (k & 1 && n.x > 1), y = index[1] + (k >> 1 & 1 && n.y > 1), z = index[2] + (k >> 2 && n.z > 1);
      corner[k] = interpolant(volume.voxelsAs<Voxel>()[(size_t(z) * n.y + y) * n.x + x], scale);
      allFinite = allFinite && std::isfinite(corner[k]);
    }
    const float value = allFinite ? trilinear(corner, weight[0], weight[1], weight[2])
                                  : trilinearOfFinite(corner, weight[0], weight[1], weight[2]);
    if (std::isnan(value)) return 0;
    const auto place = static_cast<size_t>(table.lookup().entryOf(value));
    entry = table.entries[place];
    ofUnit = table.unitAlphas[place];
    return entry.a > 0.0f;
  }
  bool classifyLast() { return classify(lattice.count - 1, 1) != 0; }
  float alpha(int) const { return entry.a; }
  float unitAlpha(int) const { return ofUnit; }
  glm::vec3 color(int) const { return glm::vec3(entry); }
};

TransferFunction colourful() {
  return {{{10.0, {1.0f, 0.2f, 0.1f}, 0.0f}, {40.0, {0.1f, 0.9f, 0.3f}, 0.1f}, {100.0, {0.2f, 0.3f, 1.0f}, 0.5f}}};
}

/// Ways in which devices read a volume.
enum class DeviceWay { byVoxels, byCells, inPairs };

/// The sources for devices, on the host. In pairs only what can be: the rest by cells.
Image<glm::vec4> renderedAsOnDevices(const Volume& volume, const TransferFunction& function, const Camera& camera,
                                        const MarchSettings& settings, DeviceWay way) {
  const MarchedVolume marched(VolumePtr(&volume, [](const Volume*) {}), function);
  const BakedTransfer baked = bakeTransfer(marched, settings.render);
  const PixelGrid pixels = makePixelGrid(camera, depthRangeOf(camera, volume.bounds()).nearDepth);
  Image<glm::vec4> image(camera.width, camera.height);
  const auto renderWith = [&](auto source, const auto& view) {
    for (uint32_t y = 0; y < camera.height; ++y)
      for (uint32_t x = 0; x < camera.width; ++x) {
        const Ray ray = pixels.ray(x, y).ray;
        const RayLattice lattice =
            makeLattice(intersectBox(reciprocalOf(ray.origin, ray.direction), volume.bounds(), 0.0f, 1e30f), settings.render.step);
        typename decltype(source)::type rayed(view, ray, lattice);
        RayColor color;
        marchRay({ray, lattice}, 0, lattice.count, rayed, Unlit{}, limitsOf(settings.render), color,
                 [](const CountingSample&) { return true; });
        image(x, y) = color.premultiplied();
      }
  };
  visitVoxelType(volume.type(), [&](auto tag) {
    using Voxel = decltype(tag);
    using Kept = std::conditional_t<(sizeof(Voxel) > 2), InterpolantVoxel, Voxel>;
    std::vector<Kept> kept(volume.voxelCount());
    for (size_t i = 0; i < kept.size(); ++i) {
      if constexpr (sizeof(Voxel) > 2)
        kept[i] = {interpolant(volume.voxelsAs<Voxel>()[i], marched.scale)};
      else
        kept[i] = volume.voxelsAs<Voxel>()[i];
    }
    VolumeView<Kept> view = makeVolumeView<Kept>(marched);
    view.voxels = kept.data();
    view.transfer = baked.table.lookup();
    view.cells.distances = baked.emptyDistances.data();
    const auto renderFrom = [&]<bool kByCells>(const VolumeView<Kept>& from) {
      if (volume.statistics().nonFinite > 0)
        renderWith(std::type_identity<ScalarVolumeSource<Kept, true, kByCells>>{}, from);
      else
        renderWith(std::type_identity<ScalarVolumeSource<Kept, false, kByCells>>{}, from);
    };
    if (way == DeviceWay::byVoxels) return renderFrom.template operator()<false>(view);
    const std::vector<uint8_t> octants = octantDistances(view.cells.distances, view.cells.dims);
    view.octants = {octants.data(), view.cells.dims, view.cells.edgeBits};
    const ViewInCells<Kept> inCells(view);
    if constexpr (kIsPairable<Kept>)
      if (way == DeviceWay::inPairs) return renderWith(std::type_identity<PairedVolumeSource<Kept, true>>{}, inCells.view());
    renderFrom.template operator()<true>(inCells.view());
  });
  return image;
}

Image<glm::vec4> renderedOneByOne(const Volume& volume, const TransferFunction& function, const Camera& camera,
                                  const MarchSettings& settings) {
  const ValueScale scale = valueScaleOf(volume.type(), volume.statistics(), function);
  const TransferTable table = bakeTransferTable(function, volume, scale, settings.render.step);
  const PixelGrid pixels = makePixelGrid(camera, depthRangeOf(camera, volume.bounds()).nearDepth);
  Image<glm::vec4> image(camera.width, camera.height);
  visitVoxelType(volume.type(), [&](auto tag) {
    for (uint32_t y = 0; y < camera.height; ++y)
      for (uint32_t x = 0; x < camera.width; ++x) {
        const Ray ray = pixels.ray(x, y).ray;
        const RayLattice lattice =
            makeLattice(intersectBox(reciprocalOf(ray.origin, ray.direction), volume.bounds(), 0.0f, 1e30f), settings.render.step);
        ScalarSource<decltype(tag)> source{volume, table, scale, ray, lattice};
        RayColor color;
        marchRay({ray, lattice}, 0, lattice.count, source, Unlit{}, limitsOf(settings.render), color,
                 [](const CountingSample&) { return true; });
        image(x, y) = color.premultiplied();
      }
  });
  return image;
}

class VolumeSourceOf : public testing::TestWithParam<VoxelType> {};
INSTANTIATE_TEST_SUITE_P(All, VolumeSourceOf, testing::ValuesIn(kAllVoxelTypes),
                         [](const auto& info) { return std::string(nameOf(info.param)); });

TEST_P(VolumeSourceOf, BatchesAreTheScalarFormulaBitForBit) {
  for (const glm::uvec3 dims : {glm::uvec3(24, 19, 21), glm::uvec3(1, 20, 20), glm::uvec3(20, 1, 20), glm::uvec3(20, 20, 1),
                                glm::uvec3(1, 1, 20), glm::uvec3(20, 1, 1), glm::uvec3(1), glm::uvec3(2)}) {
    VolumeGeometry geometry;
    geometry.dims = dims;
    geometry.spacing = {1.0, 1.5, 1.25};
    FieldFunction field = blobs(dims, 4);
    if (dims.x * dims.y * dims.z < 1000) field = [](const glm::ivec3& p) { return (p.x * 31 + p.y * 17 + p.z * 13 + 40) % 101; };
    const bool isSigned = GetParam() == VoxelType::int8 || GetParam() == VoxelType::int16 || GetParam() == VoxelType::int32;
    const double shift = isSigned ? 60.0 : 0.0;  // values of both signs
    const VolumePtr volume = makeTestVolume(GetParam(), geometry, [&](const glm::ivec3& p) { return field(p) - shift; });
    TransferFunction function = colourful();
    for (TransferPoint& point : function.points) point.value -= shift;
    const MarcherPtr marcher = makeCpuMarcher(volume, function);
    for (const float step : {0.5f, 0.37f}) {
      MarchSettings settings;
      settings.render.step = step;
      for (const glm::vec3 eye : {glm::vec3(40.0f, 25.0f, 33.0f), glm::vec3(0.1f, 0.2f, 0.3f), glm::vec3(0.0f, 0.0f, -50.0f)}) {
        const Camera camera = lookingFrom(eye, {0.5f, 0.0f, 0.0f}, 33, 29);
        SCOPED_TRACE(::testing::Message() << dims.x << "x" << dims.y << "x" << dims.z << ", step " << step);
        const Image<glm::vec4> expected = renderedOneByOne(*volume, function, camera, settings);
        ASSERT_TRUE(sameBits(rendered(*marcher, camera, settings), expected));
        for (const DeviceWay way : {DeviceWay::byVoxels, DeviceWay::byCells, DeviceWay::inPairs})
          ASSERT_TRUE(sameBits(renderedAsOnDevices(*volume, function, camera, settings, way), expected)) << "way " << static_cast<int>(way);
      }
    }
  }
}

/// Where the outermost voxels' values are seen, each differs from its neighbours, and bins are told apart by the last bit of what is interpolated.
TEST_P(VolumeSourceOf, TheOutermostHalfVoxelsAreTheSameOnDevices) {
  std::mt19937 random(11);
  for (const glm::uvec3 dims : {glm::uvec3(9, 9, 9), glm::uvec3(2, 2, 1), glm::uvec3(1, 2, 3), glm::uvec3(2, 1, 2), glm::uvec3(3, 2, 2)}) {
    const double lowest = GetParam() == VoxelType::int8 ? -128.0 : GetParam() == VoxelType::int16 ? -32768.0 : 0.0;
    const double values = sizeBytes(GetParam()) == 1 ? 256.0 : 65536.0;
    const VolumePtr volume = makeTestVolume(GetParam(), dims, [&](const glm::ivec3&) { return lowest + std::floor(values * std::generate_canonical<double, 32>(random)); });
    TransferFunction function;
    for (int i = 0; i < 200; ++i) {  // steps, many of which lie between two bins
      const double value = lowest + values * i / 200.0 + 0.125;
      const glm::vec3 color(0.2f + 0.003f * static_cast<float>(i % 97), 0.5f, 0.1f + 0.004f * static_cast<float>(i));
      if (i > 0) function.points.push_back({value, color, 0.01f + 0.002f * static_cast<float>((i + 36) % 37)});
      function.points.push_back({value, color, 0.01f + 0.002f * static_cast<float>(i % 37)});
    }
    for (const glm::vec3 eye : {glm::vec3(30.0f, 25.0f, 33.0f), glm::vec3(-20.0f, -31.0f, 19.0f), glm::vec3(0.5f, 40.0f, 0.25f), glm::vec3(0.0f, 0.0f, 30.0f)}) {
      const Camera camera = lookingFrom(eye, {}, 160, 160);
      MarchSettings settings;
      settings.render.step = 0.19f;
      const Image<glm::vec4> expected = renderedOneByOne(*volume, function, camera, settings);
      ASSERT_TRUE(sameBits(rendered(*makeCpuMarcher(volume, function), camera, settings), expected));
      for (const DeviceWay way : {DeviceWay::byVoxels, DeviceWay::byCells, DeviceWay::inPairs})
        ASSERT_TRUE(sameBits(renderedAsOnDevices(*volume, function, camera, settings, way), expected))
            << "way " << static_cast<int>(way) << ", " << dims.x << "x" << dims.y << "x" << dims.z << ", from " << eye.x << " " << eye.y;
    }
  }
}

/// Rays enter and leave such volumes voxels beside their ends, by rounding.
TEST(VolumeSource, VoxelsThatAreFarLongerThanWideAreReadWithinTheVolume) {
  VolumeGeometry geometry;
  geometry.dims = glm::uvec3(64);
  geometry.spacing = {1.0, 1e6, 1.0};
  std::mt19937 random(3);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, geometry, [&](const glm::ivec3&) { return static_cast<double>(random() % 256); });
  for (const glm::vec3 direction : {glm::vec3(1.0f, 1.0f, 0.0f), glm::vec3(-1.0f, 1.0f, 0.001f), glm::vec3(1.0f, -0.3f, 1.0f)}) {
    const float distance = 2e7f;
    const Camera camera = lookingFrom(-distance * direction, {}, 48, 48, 40.0f / distance);
    const Image<glm::vec4> expected = renderedOneByOne(*volume, colourful(), camera, {});
    EXPECT_GT(largestAlpha(expected), 0.1f);
    ASSERT_TRUE(sameBits(renderedAsOnDevices(*volume, colourful(), camera, {}, DeviceWay::inPairs), expected));
  }
}

TEST(VolumeSource, BatchesWithHolesAreTheScalarFormulaBitForBit) {
  const glm::uvec3 dims(20, 18, 16);
  const FieldFunction field = blobs(dims, 8);
  for (const VoxelType type : {VoxelType::float32, VoxelType::float64}) {
    const VolumePtr volume = makeTestVolume(type, dims, [&](const glm::ivec3& p) {
      if (p.y > 8) return field(p);  // half of the volume is whole
      const int hash = (p.x * 7 + p.y * 5 + p.z * 3) % 11;
      return hash == 0 ? kNan : hash == 1 ? kInfinity : hash == 2 ? -kInfinity : field(p);
    });
    const MarcherPtr marcher = makeCpuMarcher(volume, colourful());
    const Camera camera = lookingFrom({30.0f, 20.0f, 25.0f}, {}, 40, 40);
    const Image<glm::vec4> image = rendered(*marcher, camera);
    EXPECT_GT(largestAlpha(image), 0.1f);
    EXPECT_TRUE(sameBits(image, renderedOneByOne(*volume, colourful(), camera, {})));
    for (const DeviceWay way : {DeviceWay::byVoxels, DeviceWay::byCells})
      EXPECT_TRUE(sameBits(image, renderedAsOnDevices(*volume, colourful(), camera, {}, way))) << "way " << static_cast<int>(way);
  }
}

// --- A light of this test alone, that reads the volume through either source.

/// The direction in which values change, as a colour.
struct ByGradient {
  template <class Source>
  glm::vec3 shade(const ClassifiedSample& sample, const Ray& ray, const Source& source, int) const {
    const auto& view = source.view();
    const glm::ivec3 place(view.voxelOrigin(ray) + sample.t * view.voxelDirection(ray) + 0.5f);
    const glm::ivec3 voxel = glm::clamp(place, glm::ivec3(1), view.dims - 2);
    glm::vec3 change(0.0f);
    for (int axis = 0; axis < 3; ++axis) {
      glm::ivec3 before = voxel, after = voxel;
      --before[axis];
      ++after[axis];
      const auto at = [&](const glm::ivec3& p) {
        return static_cast<float>(view.voxels[(p.z * view.dims.y + p.y) * view.dims.x + p.x]);
      };
      change[axis] = at(after) - at(before);
    }
    return sample.alpha * glm::abs(glm::normalize(change));
  }
};

TEST(VolumeSource, ALightMayReadTheVolumesGradient) {
  const VolumePtr volume =
      makeTestVolume(VoxelType::uint8, glm::uvec3(12), [](const glm::ivec3& p) { return 20.0 + 10.0 * p.y; });
  const MarchedVolume marched(volume, {{{0.0, glm::vec3(1.0f), 0.1f}}});
  const BakedTransfer baked = bakeTransfer(marched, {.step = 0.5f});
  VolumeView<uint8_t> view = makeVolumeView<uint8_t>(marched);
  view.voxels = volume->voxelsAs<uint8_t>();
  view.transfer = baked.table.lookup();
  const Ray ray{{20.0f, 1.0f, 14.0f}, glm::normalize(glm::vec3(-20.0f, 0.5f, -14.0f))};
  const RayPath path{
      ray, makeLattice(intersectBox(reciprocalOf(ray.origin, ray.direction), volume->bounds(), 0.0f, 1e30f), 0.5f)};
  const auto colorBy = [&](auto source) {
    RayColor color;
    marchRay(path, 0, path.lattice.count, source, ByGradient{}, {1.0f / 1024, 0.0f}, color,
             [](const CountingSample&) { return true; });
    return color.premultiplied();
  };
  const glm::vec4 color = colorBy(VolumeSource<uint8_t, false>(view, ray, path.lattice));
  EXPECT_EQ(color.r, 0.0f);
  EXPECT_EQ(color.b, 0.0f);
  EXPECT_GT(color.a, 0.5f);
  EXPECT_NEAR(color.g, color.a, 1e-6);
  EXPECT_EQ(color, colorBy(ScalarVolumeSource<uint8_t, false, false>(view, ray, path.lattice)));
}

// --- Interpolation itself, against the definition in long double.

TEST(VoxelAccess, InterpolatesBetweenCentresAndIsConstantBeyondThem) {
  for (const int voxels : {1, 2, 5})
    for (float coordinate = -0.5f; coordinate <= static_cast<float>(voxels) - 0.5f; coordinate += 0.0625f) {
      int index = -1;
      float weight = -1.0f;
      axisCell(coordinate, axisEndsOf(voxels), index, weight);
      const float clamped = std::min(std::max(coordinate, 0.0f), static_cast<float>(voxels - 1));
      EXPECT_EQ(static_cast<float>(index) + weight, clamped);
      EXPECT_GE(weight, 0.0f);
      EXPECT_LE(weight, 1.0f);
      EXPECT_GE(index, 0);
      EXPECT_LE(index, std::max(0, voxels - 2));
    }
  int index = -1;
  float weight = -1.0f;
  axisCell(std::nanf(""), axisEndsOf(9), index, weight);
  EXPECT_EQ(index, 0);
  EXPECT_EQ(weight, 0.0f);
}

TEST(VoxelAccess, TrilinearIsTheWeightedSum) {
  const float corner[8] = {1.0f, -2.0f, 30.0f, 4.5f, 0.0f, 6.0f, -7.0f, 80.0f};
  for (float x = 0.0f; x <= 1.0f; x += 0.125f)
    for (float y = 0.0f; y <= 1.0f; y += 0.125f)
      for (float z = 0.0f; z <= 1.0f; z += 0.125f) {
        double sum = 0.0;
        for (int i = 0; i < 8; ++i) sum += (i & 1 ? x : 1 - x) * (i & 2 ? y : 1 - y) * (i & 4 ? z : 1 - z) * static_cast<double>(corner[i]);
        ASSERT_NEAR(trilinear(corner, x, y, z), sum, 1e-5);
        ASSERT_NEAR(trilinearOfFinite(corner, x, y, z), sum, 1e-5);
      }
}

TEST(VoxelAccess, MissingCornersShareTheirWeight) {
  const float nan = std::nanf("");
  const float corner[8] = {nan, 10.0f, nan, 10.0f, nan, 10.0f, nan, 20.0f};
  EXPECT_NEAR(trilinearOfFinite(corner, 0.75f, 0.5f, 0.5f), 12.5, 1e-5);
  EXPECT_TRUE(std::isnan(trilinearOfFinite(corner, 0.5f, 0.5f, 0.5f)));  // half of it is missing
  EXPECT_TRUE(std::isnan(trilinearOfFinite(corner, 0.25f, 0.5f, 0.5f)));
  EXPECT_EQ(trilinearOfFinite(corner, 1.0f, 0.0f, 0.0f), 10.0f);
  const float equal[8] = {0.1f, nan, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f};
  for (float x = 0.0f; x <= 1.0f; x += 0.03125f) ASSERT_EQ(trilinearOfFinite(equal, x, 0.7f * x, 1.0f - x), 0.1f);
}

}  // namespace
}  // namespace warpscope

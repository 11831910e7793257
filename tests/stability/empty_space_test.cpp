// Leaving out what is empty: case 47. Truth: the march that looks at everything, bit for bit; brute force over cells.
// Mirrors render/march/empty_space.h and what marchers make of it over render/volume/macrocells.h.
#include "render/march/empty_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "render/volume/procedural.h"
#include "tests/marcher_cases.h"
#include "tests/stability/backends.h"
#include "tests/stability/magnitudes.h"
#include "tests/stability/record.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

std::vector<Camera> camerasAround(const Box& box) {
  const float radius = 0.5f * glm::length(box.extent());
  std::vector<Camera> cameras{lookingFrom(radius * glm::vec3(1.3f, 0.9f, 1.6f), {}, 64, 56),
                              lookingFrom(radius * glm::vec3(0.1f, 0.2f, 0.1f), {}, 64, 56, 1.2f),
                              lookingFrom({0.0f, 0.0f, 2.5f * radius}, {}, 33, 33),  // along an axis
                              lookingFrom({-2.5f * radius, 0.0f, 0.0f}, {}, 33, 33),
                              lookingFrom(box.upper, {}, 64, 56, 1.0f)};  // on a corner
  // As if turned by 90 degrees with rounding: components next to nothing.
  Camera turned = cameras[2];
  turned.eye = 2.5f * radius * glm::vec3(1.0f, 6e-17f, 6e-17f);
  turned.right = {6e-17f, 6e-17f, -1.0f};
  turned.forward = {-1.0f, -6e-17f, -6e-17f};
  turned.up = {-6e-17f, 1.0f, 6e-17f};
  cameras.push_back(turned);
  return cameras;
}

void expectSkippingChangesNothing(Backend backend, const VolumePtr& volume, const TransferFunction& function,
                                  const std::vector<Camera>& cameras, const std::vector<float>& steps,
                                  const std::string& label) {
  const MarcherPtr marcher = marcherOn(backend, volume, function);
  for (const float step : steps)
    for (size_t i = 0; i < cameras.size(); ++i) {
      MarchSettings with, without;
      with.render.step = without.render.step = step;
      without.render.skipEmpty = false;
      ASSERT_TRUE(sameBits(rendered(*marcher, cameras[i], with), rendered(*marcher, cameras[i], without)))
          << label << ", camera " << i << ", step " << step;
      with.sample.heuristic = without.sample.heuristic = Heuristic::expected;
      ASSERT_TRUE(sameFrame(marcher->march(cameras[i], with), marcher->march(cameras[i], without)))
          << label << ", camera " << i << ", step " << step;
    }
}

TEST_P(Case47, ProceduralVolumes) {
  for (const ProceduralVolume& procedural : kProceduralVolumes) {
    const VolumePtr volume = makeProceduralVolume(procedural.name, procedural.defaultDims / 3u);
    for (const TransferFunction& function :
         {band(100.0, 120.0, 0.3f), band(1.0, 255.0, 0.02f), band(254.0, 256.0, 0.9f)})
      expectSkippingChangesNothing(GetParam(), volume, function, camerasAround(volume->bounds()), {0.5f},
                                   std::string(procedural.name));
  }
  recordExact("skipping empty space of procedural volumes", "without skipping", GetParam());
}

TEST_P(Case47, EveryVoxelType) {
  for (const VoxelType type : kAllVoxelTypes)
    for (const glm::uvec3 dims : {glm::uvec3(30, 25, 27), glm::uvec3(1, 50, 50), glm::uvec3(90, 2, 1)}) {
      VolumeGeometry geometry;
      geometry.dims = dims;
      geometry.spacing = {1.0, 1.0, 1.7};
      const VolumePtr volume = makeTestVolume(type, geometry, blobs(dims, 47));
      for (const TransferFunction& function : {band(40.0, 60.0, 0.4f), band(99.0, 101.0, 0.2f)})
        expectSkippingChangesNothing(GetParam(), volume, function, camerasAround(volume->bounds()), {0.5f, 0.23f},
                                     std::string(nameOf(type)));
    }
  recordExact("skipping empty space of every voxel type", "without skipping", GetParam());
}

TEST_P(Case47, VolumesWithHoles) {
  const glm::uvec3 dims(30, 28, 26);
  const FieldFunction field = blobs(dims, 2);
  const VolumePtr volume = makeTestVolume(VoxelType::float32, dims, [&](const glm::ivec3& p) {
    return p.x > 20 || (p.x + p.y * p.z) % 9 == 0 ? std::nan("") : field(p);
  });
  expectSkippingChangesNothing(GetParam(), volume, band(30.0, 70.0, 0.3f), camerasAround(volume->bounds()),
                               {0.5f, 0.23f}, "holes");
  recordExact("skipping empty space of NaN voxels", "without skipping", GetParam());
}

TEST_P(Case47, LargeBesideTheirExtent) {
  const glm::uvec3 dims(30, 28, 26);
  const FieldFunction field = blobs(dims, 2);
  for (const VoxelType type : {VoxelType::uint16, VoxelType::int16}) {
    const double offset = type == VoxelType::uint16 ? 65430.0 : -32760.0;
    const VolumePtr volume = makeTestVolume(type, dims, [&](const glm::ivec3& p) { return offset + field(p); });
    expectSkippingChangesNothing(GetParam(), volume, band(offset + 30.0, offset + 70.0, 0.3f),
                                 camerasAround(volume->bounds()), {0.5f}, std::string(nameOf(type)));
  }
  recordExact("skipping empty space of values large beside their extent", "without skipping", GetParam());
}

TEST_P(Case47, FarCamerasWithNarrowViews) {
  // Far away, distances along a ray are coarse beside a step: leaving a block must not overshoot. Everything above 0 is
  // shown, so that what lies hardly beyond a block counts.
  std::mt19937 random(47);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  const VolumePtr volume =
      makeTestVolume(VoxelType::uint8, {48, 48, 48}, [&](auto) { return random() % 150 == 0 ? 255.0 : 0.0; });
  std::vector<Camera> cameras;
  for (const float distance : {1e3f, 1e4f, 5e4f, 2e5f})
    for (int i = 0; i < 3; ++i) {
      const glm::vec3 toEye = glm::normalize(glm::vec3(unit(random), unit(random), unit(random)));
      cameras.push_back(lookingFrom(distance * toEye, {}, 64, 64, 40.0f / distance));
    }
  expectSkippingChangesNothing(GetParam(), volume, band(0.05, 256.0, 0.1f), cameras, {0.5f, 0.1f}, "seed 47, far");
  recordExact("skipping empty space from up to 2e5 away", "without skipping", GetParam());
}

/// Cells of 4 voxels, some of them visible, and how far each is from those: by definition.
struct MadeUpCells {
  std::vector<uint8_t> distances;
  EmptyCells cells;

  MadeUpCells(const glm::ivec3& dims, const std::vector<uint8_t>& visible) {
    cells.dims = dims;
    cells.edgeBits = 2;
    const int count = dims.x * dims.y * dims.z;
    const auto placeOf = [&](int i) { return glm::ivec3(i % dims.x, i / dims.x % dims.y, i / (dims.x * dims.y)); };
    for (int i = 0; i < count; ++i) {
      int least = 255;
      for (int j = 0; j < count; ++j) {
        const glm::ivec3 apart = glm::abs(placeOf(i) - placeOf(j));
        if (visible[static_cast<size_t>(j) % visible.size()] == 1)
          least = std::min(least, std::max({apart.x, apart.y, apart.z}));
      }
      distances.push_back(static_cast<uint8_t>(least));
    }
    cells.distances = distances.data();
  }
};

TEST(Case47, PropertyNoVisibleSampleIsLeaptOver) {
  // Steps from hardly anything to larger than cells; rays from up to 2^20 volumes away, along axes, through borders of
  // cells.
  size_t leaps = 0;
  checkProperty([&] {
    const glm::ivec3 dims(*rc::gen::inRange(1, 9), *rc::gen::inRange(1, 9), *rc::gen::inRange(1, 9));
    const auto visible = *rc::gen::nonEmpty(rc::gen::container<std::vector<uint8_t>>(rc::gen::inRange<uint8_t>(0, 12)));
    const MadeUpCells made(dims, visible);
    for (int round = 0; round < 32; ++round) {
      // Through a point that is a border as often as not, in voxels.
      glm::vec3 through;
      for (int axis = 0; axis < 3; ++axis) {
        through[axis] = static_cast<float>(*rc::gen::inRange(0, 4 * dims[axis] + 1));
        if (*rc::gen::arbitrary<bool>())
          through[axis] = std::min(static_cast<float>(4 * dims[axis]), through[axis] + *anyFraction());
      }
      glm::vec3 direction = *anyDirection();
      if (*rc::gen::arbitrary<bool>()) direction[*rc::gen::inRange(0, 3)] = *anyNumber(-60, -10);
      direction = glm::vec3(glm::normalize(glm::dvec3(direction)));
      const float away = *anyPositive(0, 20), dt = *anyPositive(-8, 4);
      const glm::vec3 origin = glm::vec3(glm::dvec3(through) - static_cast<double>(away) * glm::dvec3(direction));
      const Box box{glm::vec3(-0.5f), glm::vec3(4 * dims) + 0.5f};
      const RayLattice lattice = makeLattice(intersectBox(reciprocalOf(origin, direction), box, 0.0f, 1e30f), dt);
      const EmptySpace space(made.cells, origin, direction, lattice);
      int i = 0;
      while (i < std::min(lattice.count, 20000)) {
        const int next = space.skip(i, lattice);
        RC_ASSERT(next >= i);
        leaps += next > i + 1;
        for (int j = i; j < std::min(next, lattice.count); ++j) {
          // Where the sample is read. A place exactly between two cells belongs to both.
          int distance = 0;
          for (int corner = 0; corner < 8; ++corner) {
            glm::ivec3 cell;
            for (int axis = 0; axis < 3; ++axis) {
              const float place = 0.25f * mulAdd(lattice.t(j), direction[axis], origin[axis]);
              int at = static_cast<int>(std::max(place, 0.0f));
              if (corner >> axis & 1 && static_cast<float>(at) == place) at = std::max(at - 1, 0);
              cell[axis] = std::min(at, dims[axis] - 1);
            }
            distance = std::max(distance, made.cells.distance(cell));
          }
          RC_ASSERT(distance > 0);
        }
        i = next + 1;
      }
    }
  });
  EXPECT_GT(leaps, 1000u);
  recordExact("EmptySpace::skip passes no sample of a visible cell", "brute force");
}

}  // namespace
}  // namespace warpscope

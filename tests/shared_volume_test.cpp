// Volumes of which each rank has what it is asked for: made, or read from files. They are those that one process has.
// Mirrors render/volume/sparse_voxels.h, stored_rows.h, and what reader.h and procedural.h say of ranks.
#include <gmock/gmock.h>

#include <atomic>
#include <cstring>
#include <random>
#include <stop_token>
#include <thread>
#include <vector>

#include "marcher_cases.h"
#include "reader_fixture.h"
#include "render/base/error.h"
#include "render/march/streamed_marcher.h"
#include "render/volume/macrocells.h"
#include "render/volume/procedural.h"
#include "render/volume/proxy.h"
#include "render/volume/sparse_voxels.h"
#include "slab_volume.h"
#include "spread_volume.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

constexpr glm::uvec3 kSharedDims(24, 31, 27);

std::vector<uint16_t> numbers(const glm::uvec3& dims) {
  std::vector<uint16_t> values(size_t{dims.x} * dims.y * dims.z);
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<uint16_t>(i * 2654435761u >> 7);
  return values;
}

template <class T>
std::string swapped(std::vector<T> values) {
  for (T& value : values) {
    auto* const bytes = reinterpret_cast<std::byte*>(&value);
    std::reverse(bytes, bytes + sizeof value);
  }
  return bytesOf(values);
}

/// Whether those rows of both are the same.
bool haveSameRows(const Volume& a, const Volume& b, const VoxelRows& rows) {
  const size_t rowBytes = a.dims().x * sizeBytes(a.type());
  for (uint32_t z = rows.lower.y; z < rows.upper.y; ++z)
    for (uint32_t y = rows.lower.x; y < rows.upper.x; ++y) {
      const size_t at = (size_t{z} * a.dims().y + y) * rowBytes;
      if (std::memcmp(static_cast<const std::byte*>(a.voxels()) + at, static_cast<const std::byte*>(b.voxels()) + at, rowBytes) != 0) return false;
    }
  return true;
}

/// Rows within rows, by dice.
VoxelRows someRows(std::mt19937& dice, const glm::uvec3& dims) {
  VoxelRows rows;
  for (int i = 0; i < 2; ++i) {
    std::uniform_int_distribution<uint32_t> place(0, dims[i + 1]);
    const uint32_t one = place(dice), other = place(dice);
    rows.lower[i] = std::min(one, other);
    rows.upper[i] = std::max(one, other);
  }
  return rows;
}

/// As ranks have it, `shared` is the volume that one process opens: what is known of it, voxels that are asked for, and frames.
void expectTheSame(const Volume& whole, const std::function<VolumePtr(RanksPtr)>& openShared) {
  onAll(3, [&](const RanksPtr& own) {
    SCOPED_TRACE(whole.name());
    const VolumePtr shared = openShared(own);
    ASSERT_EQ(shared->type(), whole.type());
    EXPECT_EQ(shared->dims(), whole.dims());
    EXPECT_EQ(shared->geometry().spacing, whole.geometry().spacing);
    EXPECT_EQ(shared->geometry().origin, whole.geometry().origin);
    EXPECT_EQ(shared->geometry().hasOrientation, whole.geometry().hasOrientation);
    EXPECT_EQ(shared->statistics().lowest, whole.statistics().lowest);
    EXPECT_EQ(shared->statistics().highest, whole.statistics().highest);
    EXPECT_EQ(shared->statistics().histogram, whole.statistics().histogram);
    std::mt19937 dice(static_cast<uint32_t>(own->rank()));
    for (int i = 0; i < 60; ++i) {
      if (i % 7 == 0) shared->releaseVoxels();
      const VoxelRows rows = someRows(dice, whole.dims());
      shared->provide(rows);
      EXPECT_TRUE(haveSameRows(*shared, whole, rows)) << i;
    }
  });
}

class SharedVolume : public Reader {
 protected:
  void expectTheSameFile(const fs::path& path) const {
    SCOPED_TRACE(path);
    expectTheSame(*openVolume(path), [path](RanksPtr ranks) { return openVolume(path, {}, {}, std::move(ranks)); });
  }
  /// All ranks refuse it.
  void expectNotShared(const fs::path& path, const std::string& reason) const {
    SCOPED_TRACE(path);
    onAll(2, [&](const RanksPtr& own) {
      std::string text = "(nothing was thrown)";
      try {
        openVolume(path, {}, {}, own);
      } catch (const InputError& error) {
        text = error.what();
      }
      EXPECT_THAT(text, HasSubstr(reason));
      EXPECT_THAT(text, HasSubstr(path.filename().string()));
    });
  }
};

std::string nrrd(const std::string& fields, const glm::uvec3& dims = kSharedDims) {
  return "NRRD0004\n# a comment, so that voxels are anywhere\ndimension: 3\nsizes: " + std::to_string(dims.x) + " " + std::to_string(dims.y) + " " + std::to_string(dims.z) + "\n" + fields + "\n";
}

TEST_F(SharedVolume, IsReadFromWhereFilesHaveIt) {
  const std::vector<uint16_t> values = numbers(kSharedDims);
  std::vector<float> floats(values.begin(), values.end());
  floats[77] = std::nanf("");
  expectTheSameFile(write("little.nrrd", nrrd("type: ushort\nendian: little\nencoding: raw\nspacings: 1 2 0.5\n") + bytesOf(values)));
  expectTheSameFile(write("big.nrrd", nrrd("type: ushort\nendian: big\nencoding: raw\n") + swapped(values)));
  expectTheSameFile(write("floats.nrrd", nrrd("type: float\nendian: big\nencoding: raw\n") + swapped(floats)));
  write("voxels.raw", bytesOf(values));
  expectTheSameFile(write("detached.nhdr", nrrd("type: ushort\nendian: little\nencoding: raw\ndata file: voxels.raw\n")));
  const std::string meta = "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 24 31 27\nElementSpacing = 1 1 3\n";
  expectTheSameFile(write("a.mha", meta + "BinaryDataByteOrderMSB = False\nElementType = MET_USHORT\nElementDataFile = LOCAL\n" + bytesOf(values)));
  expectTheSameFile(write("b.mha", meta + "BinaryDataByteOrderMSB = True\nElementType = MET_USHORT\nElementDataFile = LOCAL\n" + swapped(values)));
  expectTheSameFile(write("e.mha", meta + "ElementByteOrderMSB = True\nElementType = MET_USHORT\nElementDataFile = LOCAL\n" + swapped(values)));
  expectTheSameFile(write("c.mhd", meta + "BinaryDataByteOrderMSB = False\nElementType = MET_USHORT\nElementDataFile = voxels.raw\n"));
  expectTheSameFile(write("d.mha", meta + "BinaryDataByteOrderMSB = False\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + bytesOf(values).substr(0, values.size())));
}

TEST_F(SharedVolume, NiftiInEitherOrderOfBytes) {
  const std::vector<uint16_t> values = numbers(kSharedDims);
  for (const bool isBig : {false, true}) {
    std::string bytes(352, '\0');
    const auto put = [&](size_t offset, const auto& value) {
      std::memcpy(bytes.data() + offset, &value, sizeof value);
      const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(offset);
      if (isBig) std::reverse(first, first + sizeof value);
    };
    put(0, int32_t{348});
    put(40, int16_t{3});
    for (size_t axis = 0; axis < 3; ++axis) {
      put(42 + 2 * axis, static_cast<int16_t>(kSharedDims[static_cast<int>(axis)]));
      put(80 + 4 * axis, 1.0f + static_cast<float>(axis));
    }
    put(70, int16_t{512});
    put(72, int16_t{16});
    put(108, 352.0f);
    bytes.replace(344, 4, std::string("n+1\0", 4));
    expectTheSameFile(write(isBig ? "big.nii" : "little.nii", bytes + (isBig ? swapped(values) : bytesOf(values))));
  }
}

TEST_F(SharedVolume, WhatIsNotThereAsItIsIsRefused) {
  const std::string voxels = bytesOf(numbers(kSharedDims));
  expectNotShared(write("packed.nrrd", nrrd("type: ushort\nendian: little\nencoding: gzip\n") + voxels), "not compressed");
  expectNotShared(write("text.nrrd", nrrd("type: uchar\nencoding: ascii\n") + voxels), "not compressed");
  expectNotShared(write("short.nrrd", nrrd("type: ushort\nendian: little\nencoding: raw\n") + voxels.substr(0, 999)), "");
  expectNotShared(write("last.nrrd", nrrd("type: ushort\nendian: little\nencoding: raw\nbyte skip: -1\n") + "some bytes more" + voxels), "where its voxels begin");
  expectNotShared(write("both.mha", "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 24 31 27\nElementByteOrderMSB = True\nBinaryDataByteOrderMSB = False\nElementType = MET_USHORT\nElementDataFile = LOCAL\n" + voxels),
                  "order");
  expectNotShared(write("a.vtk", "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 24 31 27\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 20088\nSCALARS a unsigned_short\nLOOKUP_TABLE default\n" + voxels),
                  "raw, NIfTI, NRRD and MetaImage volumes alone");
}

TEST_F(SharedVolume, AFileThatIsCutWhileItIsInUseIsASentenceWithItsPlace) {
  const fs::path path = write("a.nrrd", nrrd("type: ushort\nendian: little\nencoding: raw\n") + bytesOf(numbers(kSharedDims)));
  Spread spread([path](RanksPtr ranks) { return openVolume(path, {}, {}, std::move(ranks)); }, band(1, 400, 0.4f), 3);
  fs::resize_file(path, 3000);
  try {
    spread->march(lookingFrom({70.0f, 30.0f, 45.0f}, {}, 40, 30), MarchSettings{}, {});
    FAIL() << "it has what is not there";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("process "));
    EXPECT_THAT(error.what(), HasSubstr("a.nrrd: bytes "));
  }
}

TEST(SharedProcedural, IsMadeWhereItIsAskedForAndIsTheSame) {
  for (const ProceduralVolume& known : kProceduralVolumes) {
    SCOPED_TRACE(known.name);
    const glm::uvec3 dims(43, 50, 37);
    const VolumePtr whole = makeProceduralVolume(known.name, dims, 5);
    const auto open = [&](RanksPtr ranks) { return makeProceduralVolume(known.name, dims, 5, {}, std::move(ranks)); };
    expectTheSame(*whole, open);
    const TransferFunction function = band(40, 255, 0.2f);
    const MarcherPtr one = makeCpuMarcher(whole, function);
    const Camera camera = lookingFrom({70.0f, 30.0f, 45.0f}, {}, 60, 44);
    MarchSettings settings;
    settings.sample.segments = 3;
    settings.sample.proxy = 9;
    settings.render.effects.shading.strength = 1.0f;
    const SampleFrame expected = one->march(camera, settings, {});
    for (const int count : {2, 5}) {
      Spread spread(open, function, count);
      for (int again = 0; again < 3; ++again) {  // cut anew, too
        const SampleFrame frame = spread->march(camera, settings, {});
        EXPECT_EQ(frame.samples, expected.samples);
        EXPECT_EQ(frame.colors, expected.colors);
        EXPECT_EQ(frame.segments.depths, expected.segments.depths);
        EXPECT_EQ(std::memcmp(frame.proxy->volume->voxels(), expected.proxy->volume->voxels(), expected.proxy->volume->sizeBytes()), 0);
      }
    }
  }
}

TEST(SparseVoxels, WhatIsThereIsNotMadeAgainAndWhatIsLetGoOfIs) {
  VolumeGeometry geometry;
  geometry.dims = {8, 20, 10};
  size_t made = 0;
  SparseVoxels voxels(geometry, VoxelType::uint8, [&](const VoxelRows& rows, std::byte* first, const std::stop_token&) {
    for (uint32_t z = rows.lower.y; z < rows.upper.y; ++z)
      for (uint32_t y = rows.lower.x; y < rows.upper.x; ++y, ++made) std::memset(first + (size_t{z} * 20 + y) * 8, static_cast<int>(y), 8);
  });
  const auto madeFor = [&](const VoxelRows& rows) {
    made = 0;
    voxels.provide(rows, {});
    return made;
  };
  EXPECT_EQ(madeFor({{5, 2}, {10, 4}}), 10u);
  EXPECT_EQ(madeFor({{6, 2}, {9, 4}}), 0u);
  EXPECT_EQ(madeFor({{3, 2}, {8, 4}}), 4u) << "what is missing below";
  EXPECT_EQ(madeFor({{8, 3}, {12, 5}}), 2u + 4u) << "above, and in another slice";
  EXPECT_EQ(madeFor({{0, 0}, {2, 0}}), 0u);
  EXPECT_EQ(madeFor({{4, 4}, {4, 9}}), 0u);
  voxels.release();
  EXPECT_EQ(madeFor({{6, 2}, {9, 4}}), 6u);
  EXPECT_EQ(static_cast<const uint8_t*>(voxels.voxels())[(2 * 20 + 7) * 8], 7);
}

TEST(SparseVoxels, WhoHoldsRowsHasThemAloneAndOthersAreLetGoOfWhereMemoryIsLimited) {
  VolumeGeometry geometry;
  geometry.dims = {64, 64, 40};  // a slice is a page
  size_t made = 0;
  const auto fill = [&](const VoxelRows& rows, std::byte* first, const std::stop_token&) {
    for (uint32_t z = rows.lower.y; z < rows.upper.y; ++z)
      for (uint32_t y = rows.lower.x; y < rows.upper.x; ++y, ++made) std::memset(first + (size_t{z} * 64 + y) * 64, static_cast<int>(z + 1), 64);
  };
  SparseVoxels kept(geometry, VoxelType::uint8, fill), limited(geometry, VoxelType::uint8, fill, "", 10);
  const auto madeBy = [&](SparseVoxels& voxels, const VoxelRows& rows) {
    made = 0;
    const std::unique_lock<std::mutex> held = voxels.hold(rows, {});
    EXPECT_TRUE(held.owns_lock());
    const auto* const slices = static_cast<const uint8_t*>(voxels.voxels());
    for (uint32_t z = rows.lower.y; z < rows.upper.y; ++z) {
      EXPECT_EQ(slices[(size_t{z} * 64 + rows.lower.x) * 64], z + 1);
      EXPECT_EQ(slices[(size_t{z} * 64 + rows.upper.x) * 64 - 1], z + 1);
    }
    return made;
  };
  EXPECT_EQ(madeBy(kept, {{0, 0}, {64, 10}}), 640u);
  EXPECT_EQ(madeBy(kept, {{0, 8}, {64, 20}}), 640u);
  EXPECT_EQ(madeBy(kept, {{0, 0}, {64, 10}}), 0u) << "nothing was let go of";
  EXPECT_EQ(madeBy(limited, {{0, 0}, {64, 10}}), 640u);
  EXPECT_EQ(madeBy(limited, {{0, 8}, {64, 20}}), 640u) << "two slices were there";
  EXPECT_EQ(madeBy(limited, {{0, 0}, {64, 10}}), 512u);
  EXPECT_EQ(madeBy(limited, {{5, 9}, {7, 11}}), 2u) << "and some rows of the one beside it are none";
  EXPECT_EQ(static_cast<const uint8_t*>(limited.voxels())[0], 0) << "is not in memory any more";
  EXPECT_THROW(limited.hold({{0, 0}, {64, 13}}, {}), InputError) << "two more than are kept are charged";
  const std::unique_lock<std::mutex> held = limited.hold({{0, 0}, {64, 3}}, {});
  std::stop_source stop;
  std::thread waiting([&] { EXPECT_THROW(limited.hold({{0, 0}, {64, 3}}, stop.get_token()), OperationCancelled); });
  stop.request_stop();
  waiting.join();
}

/// One that a limit of memory has no room for: whatever is found out of all of its voxels is what is found out of them in memory.
TEST(SparseVoxels, AVolumeMadeSlabBySlabIsTheWholeOne) {
  const SlabVolume volumes;
  const Volume &whole = *volumes.whole(), &slabs = *volumes.slabs();
  const uint32_t slices = whole.dims().z, kept = slicesKept(slabs);
  ASSERT_EQ(slicesKept(whole), slices);
  ASSERT_LT(kept, slices / 2) << "three slabs at least";
  EXPECT_EQ(slabs.statistics().histogram, whole.statistics().histogram);
  const Macrocells cells(whole, ValueScale{}), ofSlabs(slabs, ValueScale{});
  EXPECT_EQ(std::memcmp(ofSlabs.lowest(), cells.lowest(), cells.count() * sizeof(float)), 0);
  EXPECT_EQ(std::memcmp(ofSlabs.highest(), cells.highest(), cells.count() * sizeof(float)), 0);

  const TransferFunction function = band(200, 250, 0.05f);
  for (const int longest : {2, 7, 64})  // a voxel of the first copy covers more slices than are kept, those of others share some
    for (const CopyFilter filter : {CopyFilter::leastSquares, CopyFilter::means}) {
      SCOPED_TRACE(testing::Message() << longest << (filter == CopyFilter::means ? " means" : " fitted"));
      const Proxy expected = makeProxy(whole, function, longest, filter), copy = makeProxy(slabs, function, longest, filter);
      ASSERT_EQ(copy.volume->dims(), expected.volume->dims());
      EXPECT_EQ(std::memcmp(copy.volume->voxels(), expected.volume->voxels(), expected.volume->sizeBytes()), 0);
    }

  const MarcherPtr alone = makeCpuMarcher(volumes.whole(), function), marcher = makeFittingCpuMarcher(volumes.slabs(), function);
  MarchSettings settings;
  settings.sample.segments = 2;
  settings.sample.proxy = 12;
  settings.render.effects.shading.strength = 1.0f;
  const Camera camera = lookingFrom({500.0f, 300.0f, 600.0f}, {}, 40, 31, 0.8f);
  const SampleFrame frame = marcher->march(camera, settings);
  EXPECT_TRUE(sameFrame(frame, alone->march(camera, settings)));
  EXPECT_GT(frame.samples.size(), 100u);
  // Several that are marched at once take turns.
  std::vector<std::thread> others;
  std::atomic<int> same = 0;
  for (int i = 0; i < 3; ++i)
    others.emplace_back([&, twin = marcher->twin()] { same += sameFrame(twin->march(camera, settings), frame) ? 1 : 0; });
  for (std::thread& other : others) other.join();
  EXPECT_EQ(same, 3);

  settings.render.step = static_cast<float>(kept);
  EXPECT_THROW(marcher->march(camera, settings), InputError) << "a step looks at more slices than there is room for";
}

TEST(SparseVoxels, AreAsLargeAsAddressesReach) {
  // 128 GiB of voxels, of which one row is made: no machine of tests has memory for all.
  VolumeGeometry geometry;
  geometry.dims = {4096, 4096, 4096};
  SparseVoxels voxels(geometry, VoxelType::uint16, [](const VoxelRows& rows, std::byte* first, const std::stop_token&) { first[((size_t{rows.lower.y} * 4096 + rows.lower.x) * 4096) * 2] = std::byte{9}; });
  voxels.provide({{4000, 4095}, {4001, 4096}}, {});
  EXPECT_EQ(static_cast<const uint16_t*>(voxels.voxels())[(size_t{4095} * 4096 + 4000) * 4096], 9);
}

}  // namespace
}  // namespace warpscope

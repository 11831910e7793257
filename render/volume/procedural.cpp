// Picks the procedural volume by its name; the Marschner-Lobb signal, which is too short for a file of its own.
// Marschner, Lobb 1994, "An Evaluation of Reconstruction Filters for Volume Rendering", section 4.
#include "render/volume/procedural.h"

#include <new>

#include "render/base/error.h"
#include "render/base/memory.h"
#include "render/volume/procedural_fields.h"
#include "render/volume/sparse_voxels.h"

namespace warpscope {
namespace procedural {

/// Voxel centres sample the signal on (-1, 1)^3.
void fillMarschnerLobb(uint8_t* voxels, const Wanted& wanted, const std::stop_token& stop) {
  const glm::uvec3& dims = wanted.dims;
  constexpr double kFrequency = 6.0;   // f_M
  constexpr double kAmplitude = 0.25;  // alpha
  const auto coordinate = [](uint32_t index, uint32_t count) { return (2.0 * index + 1.0) / count - 1.0; };
  // The ripple depends on x and y alone, the slope on z alone.
  std::vector<double> ripple(size_t{dims.x} * dims.y);
  parallelForRanges(ripple.size(), 1024, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const double x = coordinate(static_cast<uint32_t>(i % dims.x), dims.x);
      const double y = coordinate(static_cast<uint32_t>(i / dims.x), dims.y);
      ripple[i] = cosTurns(kFrequency * cosTurns(0.25 * std::sqrt(x * x + y * y)));
    }
  });
  std::vector<double> slope(dims.z);
  for (uint32_t z = 0; z < dims.z; ++z) slope[z] = cosTurns(0.25 * coordinate(z, dims.z) - 0.25);  // sin(pi z / 2)
  fillVoxels(voxels, wanted, stop, [&](uint32_t x, uint32_t y, uint32_t z) {
    const double signal =
        (1.0 - slope[z] + kAmplitude * (1.0 + ripple[size_t{y} * dims.x + x])) / (2.0 * (1.0 + kAmplitude));
    return static_cast<float>(255.0 * signal);
  });
}

}  // namespace procedural

namespace {

using Fill = void (*)(uint8_t*, const procedural::Wanted&, const std::stop_token&);

Fill fillOf(std::string_view name) {
  if (name == "vessels") return procedural::fillVessels;
  if (name == "shells") return procedural::fillShells;
  if (name == "marschner-lobb") return procedural::fillMarschnerLobb;
  if (name == "block") return procedural::fillBlock;
  std::string known;
  for (const ProceduralVolume& volume : kProceduralVolumes)
    known += (known.empty() ? "" : ", ") + std::string(volume.name);
  throw InputError("there is no built-in volume \"" + std::string(name) + "\"; there are " + known);
}

}  // namespace

VolumePtr makeProceduralVolume(std::string_view name, const glm::uvec3& dims, uint32_t seed, const std::stop_token& stop, RanksPtr ranks) {
  const Fill fill = fillOf(name);
  VolumeGeometry geometry;
  geometry.dims = dims;
  const std::string source(name);
  const size_t count = validate(geometry, VoxelType::uint8, source);
  if (ranks || isTooLargeToKeep(geometry, VoxelType::uint8)) {
    const auto fillRows = [fill, dims, seed](const VoxelRows& rows, std::byte* voxels, const std::stop_token& filling) {
      fill(reinterpret_cast<uint8_t*>(voxels), {dims, rows, seed}, filling);
    };
    return makeSparseVolume(source, VoxelType::uint8, geometry, fillRows, stop, std::move(ranks), "built in");
  }
  requireMemory(count, source + ": " + std::to_string(dims.x) + "x" + std::to_string(dims.y) + "x" + std::to_string(dims.z) + " voxels: it");
  std::shared_ptr<uint8_t[]> voxels;
  try {
    voxels = std::make_shared_for_overwrite<uint8_t[]>(count);
  } catch (const std::bad_alloc&) {
    throw InputError(source + ": " + std::to_string(count) + " voxels do not fit into this machine's memory");
  }
  fill(voxels.get(), procedural::Wanted::all(dims, seed), stop);
  const void* first = voxels.get();
  return std::make_shared<Volume>(source, VoxelType::uint8, geometry, std::shared_ptr<const void>(voxels, first),
                                  first, stop);
}

}  // namespace warpscope

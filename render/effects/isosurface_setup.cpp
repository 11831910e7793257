// Values into interpolants, and cells by their ranges.
// See isosurface_setup.h.
#include "render/effects/isosurface_setup.h"

#include <algorithm>
#include <cmath>

#include "render/base/error.h"
#include "render/base/range.h"
#include "render/core/parallel.h"
#include "render/core/visible_bins.h"
#include "render/volume/cell_distances.h"

namespace warpscope {

static_assert(IsosurfaceSetup::kMost == static_cast<int>(IsoValues::kMost));

namespace {

/// Whether a surface may run through values from `lowest` to `highest`, of which there are none if the first is greater.
bool holdsSurface(const IsosurfaceSetup& setup, float lowest, float highest) {
  if (!(lowest < highest)) return false;  // equal values are interpolated exactly
  const float slack = kRangeSlack * std::max(std::abs(lowest), std::abs(highest));
  return std::any_of(setup.surfaces, setup.surfaces + setup.count,
                     [&](const Isosurface& surface) { return !isInside(lowest - slack, surface.value) && isInside(highest + slack, surface.value); });
}

}  // namespace

IsosurfaceSetup prepareIsosurfaces(const IsoValues& values, const TransferFunction& function, const ValueScale& scale) {
  IsosurfaceSetup setup;
  for (const IsoValue& value : values)
    if (value.opacity > 0.0f)
      setup.surfaces[setup.count++] = {static_cast<float>(scale.interpolantOf(value.value)), value.opacity,
                                       value.opacity * glm::vec3(function.at(value.value))};
  return setup;
}

std::vector<uint8_t> surfaceDistances(const Macrocells& cells, const IsosurfaceSetup& setup) {
  const glm::ivec3& dims = cells.dims();
  CellDistances distances(dims);
  parallelForRanges(static_cast<size_t>(dims.z), 1, [&](size_t begin, size_t end) {
    for (int z = static_cast<int>(begin); z < static_cast<int>(end); ++z) {
      for (int y = 0; y < dims.y; ++y) {
        const size_t row = (static_cast<size_t>(z) * dims.y + y) * dims.x;
        uint8_t* const marks = distances.row(y, z);
        for (int x = 0; x < dims.x; ++x)
          marks[x] = holdsSurface(setup, cells.lowest()[row + x], cells.highest()[row + x]) ? CellDistances::kMarked : CellDistances::kUnmarked;
      }
      distances.spreadInPlane(z);
    }
  });
  return distances.take();
}

void requireIsoValues(const IsoValues& values, const Volume& volume) {
  if (values.size() == 0)
    throw UsageError("the mode " + std::string(nameOf(RenderMode::isosurface)) + " wants the values of its surfaces: --isovalues \"VALUE[@OPACITY] ...\", or isovalues among the knobs of a scene's march");
  const VoxelStatistics& statistics = volume.statistics();
  for (const IsoValue& value : values)
    if (!(value.value >= statistics.lowest && value.value <= statistics.highest))
      throw UsageError("the iso-value " + numberText(value.value) + " lies outside the volume's range, " + rangeText({statistics.lowest, statistics.highest}));
}

}  // namespace warpscope

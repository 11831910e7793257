// Means of a volume's voxels on a coarser grid, whose rows are made in parallel and need not all be of the volume that is in memory.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "render/volume/linear_fit.h"
#include "render/volume/volume.h"

namespace warpscope {

/// What cells of a grid are means of, along each axis.
using GridMeans = std::array<std::vector<CellMean>, 3>;

/// Rows of a grid's cells, as they are counted along y and then z.
struct RowRange {
  size_t first = 0, end = 0;
};

/// Calls take(row, means) for each of the rows, on many threads; a mean is of the voxels that are finite, and NaN where none is whose place is in the cell. Of a volume that is not kept
/// whole `rows` are all there are. The same bits however much of it is kept. Throws OperationCancelled if `stop` is set.
void forRowsOfMeans(const Volume& volume, const GridMeans& means, const RowRange& rows, const std::stop_token& stop, const std::function<void(size_t row, std::span<const double> means)>& take);

}  // namespace warpscope

// Rows of voxels read from where a file has them as they are.
#pragma once

#include <cstdint>
#include <filesystem>

#include "render/volume/sparse_voxels.h"

namespace warpscope {

/// Reads rows of a volume whose first voxel is at `offsetBytes` of the file, x fastest. `isSwapped`: voxels' bytes are in the other order than this machine has them.
/// The file stays open. Throws InputError where it cannot be opened; what it gives throws InputError, which names the file and the bytes, where those cannot be read,
/// and OperationCancelled.
SparseVoxels::Fill storedRows(const std::filesystem::path& file, uint64_t offsetBytes, const glm::uvec3& dims, size_t voxelBytes, bool isSwapped);

}  // namespace warpscope

// Volumes that are hard on arithmetic: small, deterministic, each of a type and geometry of its own.
// Computed as the volumes of procedural.h are; what each is hard on is its summary.
#pragma once

#include <array>
#include <string_view>

#include "render/volume/volume.h"

namespace warpscope {

struct TortureVolume {
  std::string_view name;
  std::string_view summary;
};

inline constexpr std::array<TortureVolume, 9> kTortureVolumes{{
    {"torture/far-origin", "shells whose first voxel lies at 1e7 mm"},
    {"torture/tiny-spacing", "shells with voxels of 1e-9 mm"},
    {"torture/thin-slab", "a slab of one voxel"},
    {"torture/label-steps", "a label among 65,536, around labels beside it"},
    {"torture/outlier", "a ball in values of 0 to 1, and one voxel of -9999"},
    {"torture/nan-sprinkled", "a ball in which one voxel in a hundred is not a number"},
    {"torture/grazing-planes", "planes of one voxel, to be looked along"},
    {"torture/long-way", "a thousand units of haze, and a thin wall at their end"},
    {"torture/haze", "a thousand units of one value"},
}};

/// Computes the named volume. Throws InputError for an unknown name, OperationCancelled if `stop` is set.
VolumePtr makeTortureVolume(std::string_view name, const std::stop_token& stop = {});

}  // namespace warpscope

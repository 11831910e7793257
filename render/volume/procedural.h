// Volumes that are computed instead of loaded: small, deterministic, and each a hard case for image warping.
// marschner-lobb: Marschner, Lobb 1994, section 4; the others are ours.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "render/volume/volume.h"

namespace warpscope {

struct ProceduralVolume {
  std::string_view name;
  std::string_view summary;
  glm::uvec3 defaultDims;
};

/// Every built-in volume; the names are those of the built-in scenes.
inline constexpr std::array<ProceduralVolume, 4> kProceduralVolumes{{
    {"vessels", "a branching tree of thin tubes, some almost touching", {192, 192, 192}},
    {"shells", "nested translucent turbulent shells, the case that breaks depth heuristics", {160, 160, 160}},
    {"marschner-lobb", "the resolution test signal of Marschner and Lobb", {96, 96, 96}},
    {"block", "a machined solid with bores and sharp edges", {176, 128, 128}},
}};

/// The values of one shell of "shells": `upper` in its middle, `lower` at its walls; a soft edge of one voxel around it falls to 0.
struct ShellBand {
  uint8_t lower, upper;
};
/// Bands of the four shells, the outermost first; they do not overlap, so a transfer function can colour each shell.
inline constexpr std::array<ShellBand, 4> kShellBands{{{44, 72}, {100, 128}, {156, 184}, {212, 250}}};

/// Computes the named volume (8 bit, spacing 1) at `dims`. The same name, size and seed give the same voxels everywhere, whatever the
/// number of threads. `ranks`: see Volume; each makes what it is asked for of it, and so does this process of
/// what is too large for the limit of memory. Throws InputError for an unknown name or a size that `validate` refuses, OperationCancelled if `stop` is set.
VolumePtr makeProceduralVolume(std::string_view name, const glm::uvec3& dims, uint32_t seed = 1, const std::stop_token& stop = {},
                               RanksPtr ranks = nullptr);

}  // namespace warpscope

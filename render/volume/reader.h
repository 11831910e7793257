// Opens volume files: raw by the Open SciVis naming, everything else through ITK where it is built in.
// Open SciVis Datasets (Klacansky): `name_XxYxZ_type.raw`, x fastest, little endian.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "render/volume/volume.h"

namespace warpscope {

/// What a raw file's name says.
struct RawName {
  glm::uvec3 dims;
  VoxelType type;
};

/// Parses `name_XxYxZ_type.raw`; nothing if the name is not of that form. Throws InputError if it is but a number
/// overflows or the type is unknown.
std::optional<RawName> parseRawName(const std::filesystem::path& path);

/// Opens any supported volume. A raw file is mapped, not read; `spacing` (raw only) replaces 1 1 1.
/// Throws InputError that says what is wrong with the file and what would be right; OperationCancelled soon after `stop` is set: whatever is
/// reading then is left alone (render/base/abandonable.h).
/// `ranks`: processes that open the same file at the same time and share its voxels (Volume), which raw files and those that openSharedItkVolume() reads can be; null: this one alone.
VolumePtr openVolume(const std::filesystem::path& path, const std::optional<glm::dvec3>& spacing = {}, const std::stop_token& stop = {}, RanksPtr ranks = nullptr);

/// The files that a volume is read from: `path`, and those that its header names, as far as it can be read. Of what is no volume `path` alone.
std::vector<std::filesystem::path> filesOfVolume(const std::filesystem::path& path);

/// File name endings that openVolume takes in this build, with the dot; `.raw` first.
std::vector<std::string> supportedVolumeEndings();

}  // namespace warpscope

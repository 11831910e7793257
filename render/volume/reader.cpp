// Picks the reader by the file name's ending.
// See reader.h.
#include "render/volume/reader.h"

#include <algorithm>
#include <fstream>

#include "render/core/error.h"
#include "render/volume/raw_reader.h"
#if WARPSCOPE_WITH_ITK
#include "render/volume/itk_reader.h"
#endif

namespace warpscope {
namespace {

/// What the ITK reader takes. Known in every build, so that one without ITK can say what is missing.
constexpr std::array<std::string_view, 13> kItkEndings{".nrrd", ".nhdr", ".nii",  ".nii.gz",  ".mha", ".mhd", ".hdr",
                                                       ".img",  ".vtk",  ".gipl", ".gipl.gz", ".mrc", ".rec"};

bool hasEnding(const std::filesystem::path& path, std::string_view ending) {
  std::string name = path.filename().string();
  for (char& c : name)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return name.size() > ending.size() && name.ends_with(ending);
}

void requireReadableFile(const std::filesystem::path& path) {
  const std::string source = path.string();
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) throw InputError(source + ": there is no such file");
  if (status.type() == std::filesystem::file_type::directory)
    throw InputError(source + ": is a directory, not a volume file");
  if (status.type() == std::filesystem::file_type::none)
    throw InputError(source + ": cannot be looked at: " + error.message());
  if (status.type() != std::filesystem::file_type::regular) throw InputError(source + ": is not a regular file");
  if (!std::ifstream(path, std::ios::binary))
    throw InputError(source + ": cannot be read; the user needs permission to read it");
  if (std::filesystem::file_size(path, error) == 0) throw InputError(source + ": is empty");
}

}  // namespace

std::vector<std::string> supportedVolumeEndings() {
  std::vector<std::string> endings{".raw"};
#if WARPSCOPE_WITH_ITK
  endings.insert(endings.end(), kItkEndings.begin(), kItkEndings.end());
#endif
  return endings;
}

VolumePtr openVolume(const std::filesystem::path& path, const std::optional<glm::dvec3>& spacing) {
  requireReadableFile(path);
  if (hasEnding(path, ".raw")) return openRawVolume(path, spacing);
  if (std::any_of(kItkEndings.begin(), kItkEndings.end(), [&](auto ending) { return hasEnding(path, ending); })) {
#if WARPSCOPE_WITH_ITK
    if (spacing)
      throw InputError(path.string() + ": states its voxel spacing itself; only raw volumes take another one");
    return openItkVolume(path);
#else
    throw InputError(path.string() +
                     ": this build reads raw volumes only; build with -DWARPSCOPE_WITH_ITK=ON for this format");
#endif
  }
  std::string known;
  for (const std::string& ending : supportedVolumeEndings()) known += " " + ending;
  throw InputError(path.string() + ": its ending is not that of a volume; known are" + known);
}

}  // namespace warpscope

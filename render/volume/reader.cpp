// Picks the reader by the file name's ending.
// See reader.h.
#include "render/volume/reader.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "render/base/abandonable.h"
#include "render/base/error.h"
#include "render/core/floating_point.h"
#include "render/volume/raw_reader.h"
#include "render/volume/volume_format.h"
#if WARPSCOPE_WITH_ITK
#include "render/volume/itk_reader.h"
#include "render/volume/payload.h"
#endif

namespace warpscope {
namespace {

/// True for formats that this build reads.
constexpr bool isRead([[maybe_unused]] VolumeFormat format) {
#if WARPSCOPE_WITH_ITK
  return true;
#else
  return format == VolumeFormat::raw;
#endif
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
  errno = 0;
  if (!std::ifstream(path, std::ios::binary))
    throw InputError(source + ": cannot be read" + (errno == EACCES || errno == 0 ? "; the user needs permission to read it" : std::string(": ") + std::strerror(errno)));
  if (std::filesystem::file_size(path, error) == 0) throw InputError(source + ": is empty");
}

}  // namespace

std::vector<std::filesystem::path> filesOfVolume(const std::filesystem::path& path) {
  std::vector<std::filesystem::path> files{path};
#if WARPSCOPE_WITH_ITK
  if (!formatOf(path)) return files;
  try {
    const Payload payload = locatePayload(path);
    if (payload.file != path) files.push_back(payload.file);
    files.insert(files.end(), payload.others.begin(), payload.others.end());
  } catch (const InputError&) {  // it is read no more than it is
  }
#endif
  return files;
}

std::vector<std::string> supportedVolumeEndings() {
  std::vector<std::string> endings;
  for (const VolumeEnding& known : kVolumeEndings)
    if (isRead(known.format)) endings.emplace_back(known.ending);
  return endings;
}

VolumePtr openVolume(const std::filesystem::path& path, const std::optional<glm::dvec3>& spacing, const std::stop_token& stop, RanksPtr ranks) {
  requireReadableFile(path);
  const std::optional<VolumeFormat> format = formatOf(path);
  if (!format) {
    std::string known;
    for (const std::string& ending : supportedVolumeEndings()) known += " " + ending;
    throw InputError(path.string() + ": its ending is not that of a volume; known are" + known);
  }
  if (*format == VolumeFormat::raw) return abandonable([=] { return openRawVolume(path, spacing, stop, ranks); }, stop);
#if WARPSCOPE_WITH_ITK
  if (spacing) throw InputError(path.string() + ": states its voxel spacing itself; only raw volumes take another one");
  return abandonable([=] { return exceptionsExpected([&] { return ranks ? openSharedItkVolume(path, stop, ranks) : openItkVolume(path, stop); }); }, stop);  // ITK's own
#else
  throw InputError(path.string() +
                   ": this build reads raw volumes only; build with -DWARPSCOPE_WITH_ITK=ON for this format");
#endif
}

}  // namespace warpscope

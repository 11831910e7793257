// Looking endings up.
// See volume_format.h.
#include "render/volume/volume_format.h"

namespace warpscope {

std::optional<VolumeFormat> formatOf(const std::filesystem::path& path) {
  const std::string name = lowered(path.filename().string());
  for (const VolumeEnding& known : kVolumeEndings)
    if (name.size() > known.ending.size() && name.ends_with(known.ending)) return known.format;
  return std::nullopt;
}

std::string lowered(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

}  // namespace warpscope

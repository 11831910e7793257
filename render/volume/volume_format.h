// Which format a volume file's name promises: the one table of endings.
// Klacansky's naming for raw files; the other endings are those of NRRD, NIfTI, MetaImage, VTK, GIPL and MRC.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace warpscope {

enum class VolumeFormat { raw, nrrd, nifti, metaImage, vtk, gipl, mrc };

struct VolumeEnding {
  std::string_view ending;  ///< lower case, with the dot
  VolumeFormat format;
};

/// Every ending that is known, also in a build that cannot read the format; `.raw` first.
inline constexpr std::array<VolumeEnding, 14> kVolumeEndings{{
    {".raw", VolumeFormat::raw},
    {".nrrd", VolumeFormat::nrrd},
    {".nhdr", VolumeFormat::nrrd},
    {".nii", VolumeFormat::nifti},
    {".nii.gz", VolumeFormat::nifti},
    {".mha", VolumeFormat::metaImage},
    {".mhd", VolumeFormat::metaImage},
    {".hdr", VolumeFormat::nifti},
    {".img", VolumeFormat::nifti},
    {".vtk", VolumeFormat::vtk},
    {".gipl", VolumeFormat::gipl},
    {".gipl.gz", VolumeFormat::gipl},
    {".mrc", VolumeFormat::mrc},
    {".rec", VolumeFormat::mrc},
}};

/// By the file name's ending, in either case; nothing if it is unknown or all there is of the name.
std::optional<VolumeFormat> formatOf(const std::filesystem::path& path);

/// ASCII letters in lower case, whatever the locale; other bytes as they are.
std::string lowered(std::string text);

}  // namespace warpscope

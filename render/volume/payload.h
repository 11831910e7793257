// Whether a volume file holds as many voxel bytes as its header declares: asked before anything is allocated, and
// because a cut-off compressed file can read "successfully", its tail filled with zeros. Formats: NIfTI-1 and -2 (Cox
// et al. 2004), NRRD (Kindlmann), MetaImage (Kitware), MRC, GIPL, VTK legacy. Only what is needed to find the
// voxels is parsed; the meaning is left to ITK.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <vector>

#include "render/volume/volume.h"

namespace warpscope {

/// What is read of a header: libraries take time with the square of some of these, and memory for all.
inline constexpr size_t kMaxHeaderLines = 4096;             ///< NRRD, MetaImage
inline constexpr uint64_t kMaxHeaderBytes = 1 << 20;        ///< NRRD, MetaImage
inline constexpr size_t kMaxTextLine = 200;                 ///< MetaImage: bytes of a line with a text
inline constexpr size_t kMaxFieldLine = 512;                ///< NRRD: bytes of a line with a field, but for its content
inline constexpr size_t kMaxWord = 64;                      ///< bytes of a voxel that is written as text
inline constexpr size_t kMaxExtensions = 4096;              ///< NIfTI
inline constexpr uint64_t kMaxExtensionBytes = 16 << 20;    ///< of a NIfTI header's extensions together; of an MRC file's extended header

/// Where a file keeps its voxels.
struct Payload {
  enum class Encoding {
    plain,      ///< as they are in memory, byte order aside
    deflated,   ///< one or more gzip or zlib streams
    text,       ///< words, of which Words says what they are
    unchecked,  ///< unknown here; the reader must notice by itself
  };
  /// Of a text: how its library reads numbers. What it does not take for one, or its type does not hold, becomes another, and all behind it 0, without a word.
  enum class Words {
    nrrd,   ///< commas may stand beside them; nan and inf are known
    meta,   ///< as doubles, which become integers where they are some
    plain,  ///< as their type is written
  };
  std::filesystem::path file;  ///< the file itself, or the data file of a detached header
  std::vector<std::filesystem::path> others{};  ///< that the volume is read from besides: of a pair the header, of a NRRD header the files that it spreads the voxels over
  uint64_t offsetBytes = 0;    ///< of the voxels, or of the compressed stream in `file`
  uint64_t skipBytes = 0;      ///< bytes before the voxels inside the decompressed stream
  Encoding encoding = Encoding::unchecked;
  Words words = Words::plain;
  std::optional<uint64_t> deflatedBytes{};  ///< MetaImage only: of the compressed stream, as the header says it; the library reads no more
  std::optional<VoxelType> storedType{};  ///< NIfTI, of the voxels before the header's slope and intercept; MRC, of bytes whose sign the header says
  bool isDescending = false;              ///< NIfTI only: the slope is negative
  std::optional<bool> isBigEndian{};      ///< MetaImage and NIfTI, whose libraries do not tell: as the header says it; nothing where it says both
  bool hasOrientation = false;            ///< the header states the axes' directions in the world or the patient
};

/// Finds the voxels of `path` by its header. Throws InputError where the header is not one of the format that the name
/// promises, is larger than the limits above, or names a data file that is not there.
Payload locatePayload(const std::filesystem::path& path);

/// Throws InputError if the size of the file alone tells that it cannot hold `sizeBytes` bytes of voxels.
void requirePlausible(const std::filesystem::path& path, const Payload& payload, uint64_t sizeBytes);

/// Throws InputError, naming `path`, unless `payload` holds at least `sizeBytes` bytes of voxels (`count` of them).
/// Decompresses a compressed payload once, in small pieces, to its end or until enough is there, and checks it for
/// damage. Of a text, reads each number, which `type` has to hold. Throws OperationCancelled if `stop` is set.
void requirePayload(const std::filesystem::path& path, const Payload& payload, VoxelType type, uint64_t count, uint64_t sizeBytes,
                    const std::stop_token& stop = {});

}  // namespace warpscope

// Parses the names of raw volumes and maps their files.
// See raw_reader.h. Mapping by Boost.Interprocess, which has it for every operating system.
#include "render/volume/raw_reader.h"

#include <sys/mman.h>

#include <bit>
#include <boost/interprocess/file_mapping.hpp>
#include <boost/interprocess/mapped_region.hpp>
#include <charconv>
#include <regex>
#include <thread>

#include "render/base/error.h"
#include "render/base/mapped_files.h"
#include "render/base/memory_limit.h"
#include "render/volume/file_stamp.h"

namespace warpscope {
namespace {

constexpr std::array<VoxelType, 8> kVoxelTypes{VoxelType::uint8,   VoxelType::int8,   VoxelType::uint16,
                                               VoxelType::int16,   VoxelType::uint32, VoxelType::int32,
                                               VoxelType::float32, VoxelType::float64};

VoxelType typeNamed(std::string_view name, const std::filesystem::path& path) {
  std::string known;
  for (const VoxelType type : kVoxelTypes) {
    if (nameOf(type) == name) return type;
    known += (known.empty() ? "" : ", ") + std::string(nameOf(type));
  }
  throw InputError(path.string() + ": \"" + std::string(name) + "\" is not a voxel type; there are " + known);
}

uint32_t parseSide(const std::string& digits, const std::filesystem::path& path) {
  uint32_t side = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), side);
  if (error != std::errc{} || end != digits.data() + digits.size())
    throw InputError(path.string() + ": " + digits + " voxels along an axis are more than any volume has");
  return side;
}

std::string describe(const RawName& name) {
  return std::to_string(name.dims.x) + "x" + std::to_string(name.dims.y) + "x" + std::to_string(name.dims.z) + " " +
         std::string(nameOf(name.type));
}

using Region = boost::interprocess::mapped_region;

/// Lets go of what has been read of a mapped file. Boost asks by posix_madvise, which the GNU C Library does not do anything for.
void dropPages(const Region& region) { madvise(region.get_address(), region.get_size(), MADV_DONTNEED); }

/// The system reads its pages as they are needed.
class MappedFile final : public VoxelSource {
 public:
  /// `isShared`: with other processes, whose pieces of rays are marched as they come.
  MappedFile(std::shared_ptr<const Region> region, const std::string& name, uint32_t slices, bool isShared)
      : region_(std::move(region)),
        stamp_(stampOf(name)),
        note_(region_->get_address(), region_->get_size(), name),
        droppable_(region_->get_address(), [this] { dropPages(*region_); }, [=, bytes = region_->get_size()](uint64_t limit) { return bytesAtOnce(bytes, slices, isShared, limit); }) {}

  void provide(const VoxelRows& /*rows*/, const std::stop_token& /*stop*/) override {}
  /// What is dropped of a mapping of a file is read again.
  void release() override { dropPages(*region_); }
  std::string stamp() const override { return stamp_; }

 private:
  const std::shared_ptr<const Region> region_;
  const std::string stamp_;
  const MappedFileNote note_;
  const Droppable droppable_;

  static uint64_t bytesAtOnce(uint64_t bytes, uint32_t slices, bool isShared, uint64_t limit) {
    const uint64_t threads = std::max(1u, std::thread::hardware_concurrency()), sliceBytes = bytes / slices;
    constexpr uint64_t kSlicesOfLoop = 8;  // that loops over all voxels look at, a thread
    if (isShared) {
      // What a ray brings in on its way through all slices and along all of one, at its sides as well where gradients are wanted.
      constexpr uint64_t kAroundFault = 64 << 10, kSlicesOfRay = 4;
      return std::min(bytes, threads * kSlicesOfRay * kAroundFault * (slices + sliceBytes / kAroundFault));
    }
    // What the system has read of a file at once, it maps at once (Linux 6.18), up to what one table of pages has.
    constexpr uint64_t kMostAtFault = 2 << 20;
    const uint32_t atATime = slicesAtATime(sliceBytes, slices, limit);
    return atATime < slices ? std::min(bytes, atATime * sliceBytes + threads * kSlicesOfLoop * kMostAtFault) : bytes;
  }
};

}  // namespace

std::optional<RawName> parseRawName(const std::filesystem::path& path) {
  static const std::regex kForm(R"(.*_(\d+)x(\d+)x(\d+)_([A-Za-z0-9]+)\.[rR][aA][wW])");
  const std::string name = path.filename().string();
  // The standard's regular expressions recurse once a character: no file system takes longer names than this.
  constexpr size_t kLongestName = 1024;
  std::smatch match;
  if (name.size() > kLongestName || !std::regex_match(name, match, kForm)) return {};
  const glm::uvec3 dims(parseSide(match[1], path), parseSide(match[2], path), parseSide(match[3], path));
  return RawName{dims, typeNamed(match[4].str(), path)};
}

VolumePtr openRawVolume(const std::filesystem::path& path, const std::optional<glm::dvec3>& spacing, const std::stop_token& stop, RanksPtr ranks) {
  if constexpr (std::endian::native != std::endian::little)
    throw InputError(path.string() + ": raw volumes are little endian, which this machine cannot map");
  const std::string source = path.string();
  const std::optional<RawName> name = parseRawName(path);
  if (!name)
    throw InputError(source + ": a raw volume's name must say its size and type, as in name_256x256x128_uint8.raw");
  VolumeGeometry geometry;
  geometry.dims = name->dims;
  if (spacing) geometry.spacing = *spacing;
  const size_t expected = validate(geometry, name->type, source) * sizeBytes(name->type);

  namespace ipc = boost::interprocess;
  std::shared_ptr<const ipc::mapped_region> region;
  try {
    const ipc::file_mapping file(source.c_str(), ipc::read_only);
    const uintmax_t held = std::filesystem::file_size(path);
    if (held != expected)
      throw InputError(source + ": holds " + std::to_string(held) + " bytes, but its name says " + describe(*name) +
                       " = " + std::to_string(expected) + " bytes");
    region = std::make_shared<const ipc::mapped_region>(file, ipc::read_only, 0, expected);
  } catch (const ipc::interprocess_exception& error) {
    throw InputError(source + ": cannot be mapped into memory: " + error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    throw InputError(source + ": cannot be read: " + error.code().message());
  }
  const void* voxels = region->get_address();
  std::shared_ptr<VoxelSource> pages;
  try {
    pages = std::make_shared<MappedFile>(region, source, geometry.dims.z, ranks != nullptr);
  } catch (const InputError& error) {
    throw InputError(source + ": " + error.what());
  }
  return std::make_shared<Volume>(path.filename().string(), name->type, geometry, region, voxels, stop, std::move(ranks), std::move(pages));
}

}  // namespace warpscope

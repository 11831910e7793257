// Reads through itk::ImageIOBase directly: no itk::Image, hence no copy and no template for every voxel type.
// See itk_reader.h. Directions and negative spacing as itk::ImageFileReader treats them.
#include "render/volume/itk_reader.h"

#include <itkGiplImageIO.h>
#include <itkMRCImageIO.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkOutputWindow.h>
#include <itkVTKImageIO.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <iostream>
#include <mutex>
#include <new>
#include <streambuf>
#include <string_view>

#include "render/base/error.h"
#include "render/base/memory.h"
#include "render/volume/file_stamp.h"
#include "render/volume/payload.h"
#include "render/volume/sparse_voxels.h"
#include "render/volume/stored_rows.h"
#include "render/volume/volume_format.h"

namespace warpscope {
namespace {

/// What ITK and the libraries behind it say beside their exceptions, on the thread that reads.
class Murmur {
 public:
  Murmur() { heard() = &text_; }
  ~Murmur() { heard() = nullptr; }
  Murmur(const Murmur&) = delete;
  Murmur& operator=(const Murmur&) = delete;

  const std::string& text() const { return text_; }

  /// Keeps what is said on a thread that listens; false on any other.
  static bool note(std::string_view said) {
    constexpr size_t kEnough = 1024;
    std::string* const text = heard();
    if (text != nullptr) text->append(said.substr(0, kEnough - std::min(kEnough, text->size())));
    return text != nullptr;
  }

 private:
  static std::string*& heard() {
    thread_local std::string* text = nullptr;
    return text;
  }
  std::string text_;
};

class NotingOutputWindow : public itk::OutputWindow {
 public:
  using Self = NotingOutputWindow;
  using Superclass = itk::OutputWindow;
  using Pointer = itk::SmartPointer<Self>;
  itkFactorylessNewMacro(Self);
  itkTypeMacro(NotingOutputWindow, itk::OutputWindow);
  void DisplayText(const char* text) override { Murmur::note(text); }
};

/// In place of a stream's own buffer: MetaIO says on std::cerr and std::cout what it does not like. Other threads' words go where they did.
class NotingBuffer : public std::streambuf {
 public:
  explicit NotingBuffer(std::ostream& stream) : before_(stream.rdbuf(this)) {}

 protected:
  std::streamsize xsputn(const char* text, std::streamsize count) override {
    return Murmur::note({text, static_cast<size_t>(count)}) ? count : before_->sputn(text, count);
  }
  int_type overflow(int_type c) override {
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    const char one = traits_type::to_char_type(c);
    return Murmur::note({&one, 1}) ? c : before_->sputc(one);
  }
  int sync() override { return before_->pubsync(); }

 private:
  std::streambuf* const before_;
};

void listen() {
  itk::OutputWindow::SetInstance(NotingOutputWindow::New());
  itk::Object::SetGlobalWarningDisplay(false);
  // Never destroyed: the streams outlive everything.
  for (std::ostream* stream : {&std::cerr, &std::cout, &std::clog}) new NotingBuffer(*stream);
}

/// The reader is picked here and not by ITK's factories: those must be registered at start-up in every program that
/// links them.
itk::ImageIOBase::Pointer makeImageIO(const std::filesystem::path& path) {
  switch (formatOf(path).value_or(VolumeFormat::raw)) {
    case VolumeFormat::nrrd:
      return itk::NrrdImageIO::New().GetPointer();
    case VolumeFormat::nifti:
      return itk::NiftiImageIO::New().GetPointer();
    case VolumeFormat::metaImage:
      return itk::MetaImageIO::New().GetPointer();
    case VolumeFormat::vtk:
      return itk::VTKImageIO::New().GetPointer();
    case VolumeFormat::gipl:
      return itk::GiplImageIO::New().GetPointer();
    case VolumeFormat::mrc:
      return itk::MRCImageIO::New().GetPointer();
    case VolumeFormat::raw:
      break;
  }
  throw InputError(path.string() + ": its ending is of no format that ITK reads");
}

VoxelType voxelTypeOf(const itk::ImageIOBase& io, const std::string& source) {
  if (io.GetNumberOfComponents() != 1)
    throw InputError(source + ": has " + std::to_string(io.GetNumberOfComponents()) +
                     " values a voxel (colours, vectors or complex numbers); only scalar volumes are read");
  using Component = itk::IOComponentEnum;
  switch (io.GetComponentType()) {
    case Component::UCHAR:
      return VoxelType::uint8;
    case Component::CHAR:
      return VoxelType::int8;
    case Component::USHORT:
      return VoxelType::uint16;
    case Component::SHORT:
      return VoxelType::int16;
    case Component::UINT:
      return VoxelType::uint32;
    case Component::INT:
      return VoxelType::int32;
    case Component::ULONG:
      if constexpr (sizeof(unsigned long) == 4) return VoxelType::uint32;
      break;
    case Component::LONG:
      if constexpr (sizeof(long) == 4) return VoxelType::int32;
      break;
    case Component::FLOAT:
      return VoxelType::float32;
    case Component::DOUBLE:
      return VoxelType::float64;
    default:
      break;
  }
  throw InputError(source + ": voxels of type " + itk::ImageIOBase::GetComponentTypeAsString(io.GetComponentType()) +
                   " are not read; convert it to an integer of at most 32 bits or to floating point");
}

itk::IOComponentEnum componentOf(VoxelType type) {
  return visitVoxelType(type, [](auto voxel) { return itk::ImageIOBase::MapPixelType<decltype(voxel)>::CType; });
}

VolumeGeometry geometryOf(const itk::ImageIOBase& io, const std::string& source) {
  const unsigned axes = io.GetNumberOfDimensions();
  VolumeGeometry geometry;
  for (unsigned axis = 0; axis < axes; ++axis) {
    const itk::SizeValueType side = io.GetDimensions(axis);
    // Where ITK has lost the sign.
    if (const auto asWritten = static_cast<int64_t>(side); asWritten < 0)
      throw InputError(source + ": its header declares " + std::to_string(asWritten) + " voxels along axis " + std::to_string(axis + 1));
    if (axis >= 3 && side > 1)
      throw InputError(source + ": has " + std::to_string(axes) + " axes; only single 3D volumes are read");
    if (axis >= 3) continue;
    if (side > std::numeric_limits<uint32_t>::max())
      throw InputError(source + ": " + std::to_string(side) + " voxels along an axis are more than any volume has");
    const int index = static_cast<int>(axis);
    geometry.dims[index] = static_cast<uint32_t>(side);
    geometry.spacing[index] = io.GetSpacing(axis);
    geometry.origin[index] = io.GetOrigin(axis);
    const std::vector<double> direction = io.GetDirection(axis);
    for (int row = 0; row < 3; ++row)
      geometry.direction[index][row] =
          static_cast<size_t>(row) < direction.size() ? direction[static_cast<size_t>(row)] : 0.0;
    if (geometry.spacing[index] < 0.0) {
      geometry.spacing[index] = -geometry.spacing[index];
      geometry.direction[index] = -geometry.direction[index];
    }
    if (geometry.spacing[index] == 0.0 && side == 1) geometry.spacing[index] = 1.0;
  }
  for (int axis = static_cast<int>(axes); axis < 3; ++axis) geometry.dims[axis] = 1;
  return geometry;
}

/// ITK's texts are long and name its source files; the part after the last location is what a user can use.
std::string firstSentence(const char* text) {
  std::string sentence(text);
  if (const size_t at = sentence.find("): "); at != std::string::npos) sentence = sentence.substr(at + 3);
  // NrrdIO tells the whole chain of calls, the cause last.
  if (const size_t at = sentence.rfind("[nrrd] "); at != std::string::npos) {
    sentence = sentence.substr(at + 7);
    if (const size_t colon = sentence.find(": "); colon != std::string::npos) sentence = sentence.substr(colon + 2);
  }
  constexpr std::string_view kPrefix = "ITK ERROR: ";
  if (sentence.starts_with(kPrefix)) sentence.erase(0, kPrefix.size());
  for (char& c : sentence)
    if (c == '\n' || c == '\r' || c == '\t') c = ' ';
  while (!sentence.empty() && sentence.back() == ' ') sentence.pop_back();
  constexpr size_t kLongest = 300;
  return sentence.substr(0, kLongest);
}

/// What a file says of its voxels.
struct Header {
  Payload payload;
  itk::ImageIOBase::Pointer io;
  VoxelType type{};
  VolumeGeometry geometry;
  size_t count = 0;
  uint64_t storedBytes = 0;
};

/// Throws InputError, too, where the size of the file alone tells that it cannot be right.
Header readHeader(const std::filesystem::path& path) {
  const std::string source = path.string();
  Header header;
  header.payload = locatePayload(path);
  header.io = makeImageIO(path);
  if (!header.io->CanReadFile(source.c_str()))
    throw InputError(source + ": its content is not of the format that its ending promises, or its header is damaged");
  header.io->SetFileName(source);
  header.io->ReadImageInformation();

  // ITK would widen voxels with a slope and an intercept to float. Those as stored differ only by an affine map, which
  // a transfer function over their range does not see; where the slope is negative it would, and the widening stays.
  if (auto* nifti = dynamic_cast<itk::NiftiImageIO*>(header.io.GetPointer());
      nifti && header.payload.storedType && !header.payload.isDescending) {
    nifti->SetRescaleSlope(1.0);
    nifti->SetRescaleIntercept(0.0);
    nifti->SetComponentType(componentOf(*header.payload.storedType));
  }
  header.type = voxelTypeOf(*header.io, source);
  if (formatOf(path) == VolumeFormat::mrc) header.type = header.payload.storedType.value_or(header.type);  // ITK takes bytes for signed by the least that the header states
  header.geometry = geometryOf(*header.io, source);
  header.geometry.hasOrientation = header.payload.hasOrientation;
  header.count = validate(header.geometry, header.type, source);
  header.storedBytes = header.count * sizeBytes(header.payload.storedType.value_or(header.type));
  requirePlausible(path, header.payload, header.storedBytes);
  return header;
}

/// Why several processes cannot each read rows of voxels from where they lie, nor one that has no room for all; empty: they can.
std::string whyNotByRows(const std::filesystem::path& path, const Header& header) {
  const Payload& payload = header.payload;
  const VolumeFormat format = formatOf(path).value_or(VolumeFormat::raw);
  if (format != VolumeFormat::nifti && format != VolumeFormat::nrrd && format != VolumeFormat::metaImage) return "several processes share raw, NIfTI, NRRD and MetaImage volumes alone";
  if (payload.encoding != Payload::Encoding::plain || payload.skipBytes > 0)
    return "several processes share volumes whose voxels are not compressed and lie in one file as they are; this one is to be written so first";
  if (payload.storedType.value_or(header.type) != header.type || payload.isDescending) return "its voxels are scaled to others, which several processes do not share";
  if (payload.offsetBytes == 0 && std::filesystem::file_size(payload.file) != header.storedBytes) return "where its voxels begin is not certain enough for several processes";
  if (format == VolumeFormat::metaImage && !payload.isBigEndian) return "in which order the bytes of its voxels are is not certain enough for several processes";
  return "";
}

/// One whose rows can be read so.
VolumePtr readByRows(const std::filesystem::path& path, const Header& header, const std::stop_token& stop, RanksPtr ranks) {
  const Payload& payload = header.payload;
  const bool isBigEndian = payload.isBigEndian.value_or(header.io->GetByteOrder() == itk::IOByteOrderEnum::BigEndian);
  const bool isSwapped = sizeBytes(header.type) > 1 && isBigEndian != (std::endian::native == std::endian::big);
  return makeSparseVolume(path.filename().string(), header.type, header.geometry, storedRows(payload.file, payload.offsetBytes, header.geometry.dims, sizeBytes(header.type), isSwapped), stop,
                          std::move(ranks), stampOf(payload.file));
}

VolumePtr readItkVolume(const std::filesystem::path& path, const std::stop_token& stop) {
  const std::string source = path.string();
  const Header header = readHeader(path);
  const auto& [payload, io, type, geometry, count, storedBytes] = header;
  if (isTooLargeToKeep(geometry, type) && whyNotByRows(path, header).empty()) {
    requirePayload(path, payload, type, count, storedBytes, stop);
    return readByRows(path, header, stop, nullptr);
  }
  // The library behind NIfTI reads into memory of its own first.
  const bool isReadTwice = dynamic_cast<itk::NiftiImageIO*>(io.GetPointer()) != nullptr;
  requireMemory(count * sizeBytes(type) + (isReadTwice ? storedBytes : 0), source + ": it");
  requirePayload(path, payload, payload.storedType.value_or(type), count, storedBytes, stop);

  // Pages of zeros come for free from the system; memory as it was found would show where ITK stops early without a
  // word.
  const std::shared_ptr<void> voxels(std::calloc(count, sizeBytes(type)), std::free);
  if (!voxels) throw std::bad_alloc();
  itk::ImageIORegion region(io->GetNumberOfDimensions());
  for (unsigned axis = 0; axis < io->GetNumberOfDimensions(); ++axis) {
    region.SetIndex(axis, 0);
    region.SetSize(axis, io->GetDimensions(axis));
  }
  io->SetIORegion(region);
  io->Read(voxels.get());
  return std::make_shared<Volume>(path.filename().string(), type, geometry, voxels, voxels.get(), stop);
}

VolumePtr shareItkVolume(const std::filesystem::path& path, const std::stop_token& stop, RanksPtr ranks) {
  const Header header = readHeader(path);
  if (const std::string reason = whyNotByRows(path, header); !reason.empty()) throw InputError(path.string() + ": " + reason);
  return readByRows(path, header, stop, std::move(ranks));
}

/// The reason that an exception gives, and what was said besides.
std::string reasonOf(const char* what, const Murmur& murmur) {
  const std::string reason = firstSentence(what), said = firstSentence(murmur.text().c_str());
  return said.empty() ? reason : reason + " (" + said + ")";
}

/// Calls `read()`; what goes wrong is a sentence that names the file.
template <class Read>
VolumePtr saying(const std::filesystem::path& path, const Read& read) {
  static std::once_flag listening;
  std::call_once(listening, listen);
  const Murmur murmur;
  try {
    return read();
  } catch (const InputError&) {
    throw;
  } catch (const OperationCancelled&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw InputError(path.string() + ": does not fit into this machine's memory");
  } catch (const itk::ExceptionObject& error) {
    throw InputError(path.string() + ": cannot be read: " + reasonOf(error.GetDescription(), murmur));
  } catch (const std::exception& error) {
    throw InputError(path.string() + ": cannot be read: " + reasonOf(error.what(), murmur));
  }
}

}  // namespace

VolumePtr openItkVolume(const std::filesystem::path& path, const std::stop_token& stop) {
  return saying(path, [&] { return readItkVolume(path, stop); });
}

VolumePtr openSharedItkVolume(const std::filesystem::path& path, const std::stop_token& stop, RanksPtr ranks) {
  return saying(path, [&] { return shareItkVolume(path, stop, std::move(ranks)); });
}

}  // namespace warpscope

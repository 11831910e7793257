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

#include <cstdlib>
#include <new>

#include "render/base/error.h"
#include "render/volume/payload.h"
#include "render/volume/volume_format.h"

namespace warpscope {
namespace {

/// ITK's warnings: swallowed, because what matters of them comes back as an exception.
class SilentOutputWindow : public itk::OutputWindow {
 public:
  using Self = SilentOutputWindow;
  using Superclass = itk::OutputWindow;
  using Pointer = itk::SmartPointer<Self>;
  itkFactorylessNewMacro(Self);
  itkTypeMacro(SilentOutputWindow, itk::OutputWindow);
  void DisplayText(const char*) override {}
};

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

VolumePtr readItkVolume(const std::filesystem::path& path, const std::stop_token& stop) {
  const std::string source = path.string();
  const Payload payload = locatePayload(path);
  const itk::ImageIOBase::Pointer io = makeImageIO(path);
  if (!io->CanReadFile(source.c_str()))
    throw InputError(source + ": its content is not of the format that its ending promises, or its header is damaged");
  io->SetFileName(source);
  io->ReadImageInformation();

  // ITK would widen voxels with a slope and an intercept to float. Those as stored differ only by an affine map, which
  // a transfer function over their range does not see; where the slope is negative it would, and the widening stays.
  if (auto* nifti = dynamic_cast<itk::NiftiImageIO*>(io.GetPointer());
      nifti && payload.storedType && !payload.isDescending) {
    nifti->SetRescaleSlope(1.0);
    nifti->SetRescaleIntercept(0.0);
    nifti->SetComponentType(componentOf(*payload.storedType));
  }
  const VoxelType type = voxelTypeOf(*io, source);
  VolumeGeometry geometry = geometryOf(*io, source);
  geometry.hasOrientation = payload.hasOrientation;
  const size_t count = validate(geometry, type, source);
  requirePayload(path, payload, count, count * sizeBytes(payload.storedType.value_or(type)), stop);

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

}  // namespace

VolumePtr openItkVolume(const std::filesystem::path& path, const std::stop_token& stop) {
  static const bool kIsSilent = [] {
    itk::OutputWindow::SetInstance(SilentOutputWindow::New());
    itk::Object::SetGlobalWarningDisplay(false);
    return true;
  }();
  static_cast<void>(kIsSilent);
  try {
    return readItkVolume(path, stop);
  } catch (const InputError&) {
    throw;
  } catch (const OperationCancelled&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw InputError(path.string() + ": does not fit into this machine's memory");
  } catch (const itk::ExceptionObject& error) {
    throw InputError(path.string() + ": cannot be read: " + firstSentence(error.GetDescription()));
  } catch (const std::exception& error) {
    throw InputError(path.string() + ": cannot be read: " + firstSentence(error.what()));
  }
}

}  // namespace warpscope

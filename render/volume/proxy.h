// A coarse copy of a volume for those who have none: filtered, 8 bits a voxel, few enough to be sent with a picture.
// It has the volume's bounds and unit of volume space, so that rays, lights and cuts of the one are those of the other.
#pragma once

#include "render/core/transfer_function.h"
#include "render/volume/volume.h"

namespace warpscope {

/// What the codes of a copy stand for.
struct ProxyScale {
  double lowest = 0.0;      ///< value of the first code
  double perCode = 1.0;     ///< values from one code to the next, > 0
  bool hasMissing = false;  ///< the code 0 is no value: voxels there were missing. Values begin at code 1

  bool operator==(const ProxyScale&) const = default;
  /// By halves: values may be farther apart than the largest number.
  double codeOf(double value) const { return (0.5 * value - 0.5 * lowest) / (0.5 * perCode) + (hasMissing ? 1.0 : 0.0); }
};

struct Proxy {
  VolumePtr volume;  ///< of 8 bits
  ProxyScale scale;
  TransferFunction function;  ///< of the values that codes stand for
  bool isExact = false;       ///< it has each of the volume's voxels as it is

  /// Of its voxels.
  size_t sizeBytes() const { return volume->sizeBytes(); }
};
using ProxyPtr = std::shared_ptr<const Proxy>;

/// What a copy's voxels hold.
enum class CopyFilter {
  leastSquares,  ///< what is nearest to the volume once it is interpolated (linear_fit.h): for pictures. Means, interpolated, are blurred twice, and thin things are lost in them
  means,         ///< means of what lies in each (cf. Williams 1983, "Pyramidal parametrics"): for light, where each voxel stands for what it has taken
};

/// The copy has `longest` voxels along the volume's longest edge and as nearly cubic ones as that allows, along no axis more than the volume has. Voxels that
/// are not finite are left out; where there is no other whose place is in one of the copy's, that has none. Throws OperationCancelled if `stop` is set.
Proxy makeProxy(const Volume& volume, const TransferFunction& function, int longest, CopyFilter filter, const std::stop_token& stop = {});

/// Its function as one of codes.
TransferFunction functionOfCodes(const Proxy& proxy);

}  // namespace warpscope

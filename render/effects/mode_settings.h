// What a ray makes of the values along it, as settings: all of them together, the greatest, or surfaces of chosen values; and the values' text form.
// See mip.h and isosurface.h.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "render/base/named_value.h"
#include "render/base/short_list.h"

namespace warpscope {

enum class RenderMode {
  composite,   ///< emission and absorption of all that lies along the ray
  mip,         ///< the greatest value alone
  isosurface,  ///< surfaces on which the volume has a value
};

inline constexpr std::array<NamedValue<RenderMode>, 3> kRenderModes{{
    {RenderMode::composite, "composite", "all that lies along a ray shines and absorbs, as the transfer function says"},
    {RenderMode::mip, "mip", "the greatest value along a ray alone, in the transfer function's colour and opacity there (maximum intensity projection)"},
    {RenderMode::isosurface, "isosurface", "surfaces on which the volume has one of the iso-values, in the transfer function's colour there"},
}};
inline std::string_view nameOf(RenderMode mode) { return nameOf(kRenderModes, mode); }

struct IsoValue {
  double value = 0.0;     ///< in the units of the volume's file, finite
  float opacity = 1.0f;   ///< of the surface, 0..1; 0: it is not looked for

  bool operator==(const IsoValue&) const = default;
};

using IsoValues = ShortList<IsoValue, 4>;

/// "300 1200@0.5": VALUE[@OPACITY] with blanks between values; "none" for none. Reads back as the same.
std::string textOf(const IsoValues& values);
/// Back. Throws UsageError that begins with `name` and says which value is wrong and why.
IsoValues parseIsoValues(std::string_view text, std::string_view name);

}  // namespace warpscope

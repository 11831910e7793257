// A sample a pixel.
// See spread_map.h.
#include "app/picture/spread_map.h"

#include <cmath>
#include <cstring>

#include "render/base/error.h"
#include "render/march/own_picture.h"

namespace warpscope {

Image<float> spreadMap(const SampleFrame& frame) {
  const SamplePlane* const plane = frame.plane(kSpreadPlane);
  if (plane == nullptr || plane->element != PlaneElement::float32 || plane->values.size() != frame.size() * sizeof(float))
    throw InputError("the frame does not say how its samples' depths are spread");
  const Image<uint32_t> seen = ownPicture(frame);
  Image<float> map;
  map.resize(seen.width(), seen.height());
  for (uint32_t y = 0; y < map.height(); ++y)
    for (uint32_t x = 0; x < map.width(); ++x) {
      map(x, y) = 0.0f;
      if (seen(x, y) == kNoSample) continue;
      std::memcpy(&map(x, y), plane->values.data() + size_t{seen(x, y)} * sizeof(float), sizeof(float));
      if (!(map(x, y) >= 0.0f) || !std::isfinite(map(x, y))) throw InputError("the frame has spreads of depth that are no lengths");
    }
  return map;
}

}  // namespace warpscope

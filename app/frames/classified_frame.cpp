// See classified_frame.h.
#include "app/frames/classified_frame.h"

#include "render/volume/proxy.h"

namespace warpscope {

SampleFramePtr classifiedBy(const TransferFunction& function, const SampleFramePtr& frame) {
  if (!frame->proxy || frame->proxy->function == function) return frame;
  auto changed = std::make_shared<SampleFrame>(*frame);
  auto proxy = std::make_shared<Proxy>(*frame->proxy);
  proxy->function = function;
  changed->proxy = std::move(proxy);
  return changed;
}

}  // namespace warpscope

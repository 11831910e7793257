// See link_sign.h.
#include "app/frames/link_sign.h"

namespace warpscope {

LinkSign signOf(const net::DuplexLinkSettings& link, bool hasOutage) {
  constexpr const char* kOutage = "Simulated outage: nothing passes";
  if (hasOutage) return {kOutage, kOutage, true};
  if (link.isTransparent()) return {};
  const net::LinkWords words = net::wordsOf(link);
  return {"Simulated link: " + words.full, "Simulated link: " + words.brief};
}

}  // namespace warpscope

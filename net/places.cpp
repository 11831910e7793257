// The longest of no use, of one address or of all.
// See places.h.
#include "net/places.h"

#include <algorithm>
#include <tuple>

namespace warpscope::net {

Admission admit(std::span<const Occupant> occupants, const std::string& address, const PlaceLimits& limits, TimePoint now) {
  const auto isOfAddress = [&](const Occupant& occupant) { return occupant.address == address; };
  const bool isAddressFull = static_cast<size_t>(std::ranges::count_if(occupants, isOfAddress)) >= limits.mostOfAnAddress;
  if (!isAddressFull && occupants.size() < limits.most) return {.isPossible = true, .whoGoes = {}};
  const Occupant* goes = nullptr;
  for (const Occupant& occupant : occupants) {
    if (occupant.isKept || now - occupant.lastOfUse < limits.leastIdleness || (isAddressFull && !isOfAddress(occupant))) continue;
    if (goes == nullptr || std::tuple(!occupant.isSilent, occupant.lastOfUse, occupant.id) < std::tuple(!goes->isSilent, goes->lastOfUse, goes->id))
      goes = &occupant;
  }
  if (goes == nullptr) return {};
  return {.isPossible = true, .whoGoes = goes->id};
}

}  // namespace warpscope::net

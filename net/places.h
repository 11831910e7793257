// Who has to go when one more wants in: places that are counted, in all and for each address.
// As with caches: whoever has been of no use for longest goes first, never the newcomer, whom nothing is known of yet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "net/times.h"

namespace warpscope::net {

struct PlaceLimits {
  size_t most = 0;               ///< in all
  size_t mostOfAnAddress = 0;    ///< of them, from one address
  Duration leastIdleness{0};     ///< nobody who was of use so lately goes
};

/// Who has a place.
struct Occupant {
  uint64_t id = 0;
  std::string address;
  TimePoint lastOfUse;     ///< when it was let in, or did something since
  bool isSilent = false;   ///< it has not said anything yet: goes before all others
  bool isKept = false;     ///< it waits for something: does not go
};

struct Admission {
  bool isPossible = false;
  std::optional<uint64_t> whoGoes;  ///< first
};

/// Whether one more from `address` may come. Where it has as many places as an address may have, one of its own goes.
Admission admit(std::span<const Occupant> occupants, const std::string& address, const PlaceLimits& limits, TimePoint now);

}  // namespace warpscope::net

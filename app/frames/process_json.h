// What a process did that marches a part of a volume, as reports have it.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

#include "net/messages.h"

namespace warpscope {

inline nlohmann::json toJson(const net::ProcessFields& process) {
  // Threads, rounded as finely as the wire has them.
  const auto threads = [&](const std::array<uint8_t, net::kProcessSlots>& slots) {
    nlohmann::json counts = nlohmann::json::array();
    for (const uint8_t slot : slots) counts.push_back(std::round(100.0 * static_cast<double>(process.mostThreads) * slot / 255.0) / 100.0);
    return counts;
  };
  return {{"lower", process.lower},
          {"upper", process.upper},
          {"tiles", process.tiles},
          {"deviceTiles", process.deviceTiles},
          {"marchMs", process.marchMs},
          {"waitMs", process.waitMs},
          {"sentBytes", process.sentBytes},
          {"slotMs", process.slotMs},
          {"marching", threads(process.marching)},
          {"waiting", threads(process.waiting)}};
}

}  // namespace warpscope

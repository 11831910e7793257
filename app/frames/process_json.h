// What a process did that marches a part of a volume, as reports have it.
#pragma once

#include <nlohmann/json.hpp>

#include "net/messages.h"

namespace warpscope {

inline nlohmann::json toJson(const net::ProcessFields& process) {
  return {{"lower", process.lower},         {"upper", process.upper},   {"tiles", process.tiles},        {"deviceTiles", process.deviceTiles},
          {"marchMs", process.marchMs}, {"waitMs", process.waitMs}, {"sentBytes", process.sentBytes}};
}

}  // namespace warpscope

// How frames travel, in JSON: reports, and sessions.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/frames/frame_source.h"

namespace warpscope {

class Node;

/// The link as the command line writes it, and every knob under its key.
nlohmann::json toJson(const TransportSettings& transport);

/// Back, of what is there. Throws InputError that names the file, the line and the key.
void readTransport(const Node& node, TransportSettings& transport);

}  // namespace warpscope

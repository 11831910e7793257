// Views in JSON: those of scene files, and of sessions.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/scene/scene.h"

namespace warpscope {

class Node;

/// Throws InputError that names the file, the line and the key.
View readView(const Node& node);
nlohmann::json toJson(const View& view);

}  // namespace warpscope

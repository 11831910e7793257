// Fields of CSV tables, as RFC 4180 wants them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace warpscope {

/// Numbers and words as JSON has them, strings in quotes where they need some; null is empty.
std::string csvField(const nlohmann::json& value);

}  // namespace warpscope

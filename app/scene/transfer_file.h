// Transfer functions as files: this program's own, and colour maps as ParaView exports and imports them (Kitware, "Color Map" presets in JSON).
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "render/core/transfer_function.h"

namespace warpscope {

class JsonDocument;
class Node;

/// "transferFunction" of a scene file. Throws InputError that names the file, the line and the key.
TransferFunction readTransferFunction(const Node& node);

/// As readTransferFunction() reads it.
nlohmann::json toJson(const TransferFunction& function);

/// A file of either kind, told apart by what it holds. A ParaView colour map without opacities is opaque where its values are greatest: a ramp. Throws InputError.
TransferFunction readTransferFile(const std::filesystem::path& path);

/// Whether it looks like either kind, right or wrong, and not like a scene or a sweep.
bool isTransferFile(const JsonDocument& document);

/// The text of this program's own file.
std::string transferText(const TransferFunction& function);
/// The text of a colour map with opacities for ParaView; its colours are interpolated as sRGB there and linearly here: corners in between keep it within a code
/// of 255.
std::string paraviewText(const TransferFunction& function, const std::string& name);

}  // namespace warpscope

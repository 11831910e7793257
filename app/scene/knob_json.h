// Values of knobs as JSON: numbers, names, flags.
// Which ones there are, and what they may be: render/base/knob.h.
#pragma once

#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>

#include "render/base/knob.h"
#include "render/march/march_knobs.h"

namespace warpscope {

class Node;

/// The value under the knob's type: a number, a whole number, a choice's name, true or false.
nlohmann::json jsonOf(const Knob& knob, double value);

/// Back. Throws InputError that names the file, the line and the key.
double readKnob(const Node& node, const Knob& knob);

/// Sets what the node holds as text. Throws InputError that names the file, the line and the key.
void readText(const Node& node, const MarchText& text, MarchSettings& settings);

/// Sets what the object holds under the keys of knobs and lists, which may be no others. Throws likewise.
void readMarch(const Node& node, MarchSettings& march);
/// Of techniques' knobs. Throws likewise.
void readWarpKnobs(const Node& node, KnobValues& knobs);

/// Voxels along each axis, 1 to 65536. Throws likewise.
glm::uvec3 readSize(const Node& node);

/// Three numbers, 0..1: sRGB in files, linear here. Throws likewise.
glm::vec3 readColor(const Node& node);

/// All of a march's, under their keys.
nlohmann::json toJson(const MarchSettings& settings);

}  // namespace warpscope

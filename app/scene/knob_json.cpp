// Values of knobs from JSON and back.
// See knob_json.h.
#include "app/scene/knob_json.h"

#include "app/scene/json_document.h"
#include "render/base/error.h"
#include "render/base/nearest_name.h"
#include "render/core/color.h"
#include "render/warp/warp.h"

namespace warpscope {

nlohmann::json jsonOf(const Knob& knob, double value) {
  switch (knob.type) {
    // The nearest decimal that is the same in single precision: 0.8, not 0.800000011920929.
    case KnobType::number: return parseNumber(textOf(knob, value)).value_or(value);
    case KnobType::whole: return static_cast<int64_t>(value);
    case KnobType::choice: return textOf(knob, value);
    case KnobType::flag: return value != 0.0;
  }
  return nullptr;
}

double readKnob(const Node& node, const Knob& knob) {
  switch (knob.type) {
    case KnobType::number: return static_cast<float>(node.number(knob.range));
    case KnobType::whole: return static_cast<double>(node.integer(static_cast<int64_t>(knob.range.lowest), static_cast<int64_t>(knob.range.highest)));
    case KnobType::flag: return node.boolean() ? 1.0 : 0.0;
    case KnobType::choice: break;
  }
  const std::string name = node.string();
  if (findNamed(knob.choices, name) == nullptr) node.fail("holds an " + unknownNameIn(knob.choices, knob.noun, name));
  return parseKnob(knob, name, knob.noun);
}

void readText(const Node& node, const MarchText& text, MarchSettings& settings) {
  const std::string value = node.string();
  try {
    text.set(settings, value, "its " + std::string(text.noun));
  } catch (const UsageError& error) {
    node.fail(std::string("holds what is no list of ") + std::string(text.noun) + ": " + error.what());
  }
}

void readMarch(const Node& node, MarchSettings& march) {
  std::vector<std::string_view> keys;
  for (const MarchKnob& row : marchKnobs()) keys.push_back(row.knob->key);
  for (const MarchText& text : marchTexts()) keys.push_back(text.key);
  node.requireObject(keys);
  for (const MarchKnob& row : marchKnobs())
    if (const auto given = node.find(row.knob->key)) row.set(march, readKnob(*given, *row.knob));
  for (const MarchText& text : marchTexts())
    if (const auto given = node.find(text.key)) readText(*given, text, march);
}

void readWarpKnobs(const Node& node, KnobValues& knobs) {
  std::vector<std::string_view> keys;
  for (const Knob* knob : warpKnobs()) keys.push_back(knob->key);
  node.requireObject(keys);
  for (const Knob* knob : warpKnobs())
    if (const auto given = node.find(knob->key)) knobs.set(*knob, readKnob(*given, *knob));
}

glm::uvec3 readSize(const Node& node) {
  const std::vector<Node> elements = node.elements(3, 3);
  glm::uvec3 size;
  for (int axis = 0; axis < 3; ++axis) size[axis] = static_cast<uint32_t>(elements[static_cast<size_t>(axis)].integer(1, 65536));
  return size;
}

glm::vec3 readColor(const Node& node) {
  const std::vector<Node> elements = node.elements(3, 3);
  glm::vec3 color;
  for (size_t i = 0; i < 3; ++i) color[static_cast<int>(i)] = linearFromSrgb(static_cast<float>(elements[i].number(0.0, 1.0)));
  return color;
}

nlohmann::json toJson(const MarchSettings& settings) {
  nlohmann::json json;
  for (const MarchKnob& row : marchKnobs()) json[std::string(row.knob->key)] = jsonOf(*row.knob, row.get(settings));
  for (const MarchText& text : marchTexts()) json[std::string(text.key)] = text.get(settings);
  return json;
}

}  // namespace warpscope

// Values of knobs as text, and what is refused.
// See knob.h.
#include "render/base/knob.h"

#include <algorithm>

#include "render/base/error.h"
#include "render/base/nearest_name.h"

namespace warpscope {
namespace {

constexpr size_t kMostShown = 40;  // characters of what was typed

bool isKnownChoice(const Knob& knob, double value) { return value >= 0.0 && value < static_cast<double>(knob.choices.size()) && value == std::floor(value); }

}  // namespace

std::string textOf(const Knob& knob, double value) {
  switch (knob.type) {
    case KnobType::number: return numberText(static_cast<float>(value));
    case KnobType::whole: return numberText(value);
    case KnobType::choice: return isKnownChoice(knob, value) ? std::string(knob.choices[static_cast<size_t>(value)].name) : "?";
    case KnobType::flag: return value != 0.0 ? "true" : "false";
  }
  return "?";
}

void validate(const Knob& knob, double value, std::string_view name) {
  switch (knob.type) {
    case KnobType::number:
      // As it was typed, where it was: in single precision 1e300 is infinite. What is single precision already counts as that.
      if (static_cast<double>(static_cast<float>(value)) == value)
        requireRange(static_cast<float>(value), knob.range, name);
      else
        requireRange(value, knob.range, name);
      return;
    case KnobType::whole:
      requireRange(value, knob.range, name);
      if (value != std::floor(value)) throw UsageError(std::string(name) + " must be a whole number, not " + numberText(value));
      return;
    case KnobType::choice:
      if (!isKnownChoice(knob, value)) throw UsageError(std::string(name) + " must be one of: " + valuesText(knob));
      return;
    case KnobType::flag:
      if (value != 0.0 && value != 1.0) throw UsageError(std::string(name) + " must be true or false");
      return;
  }
}

double parseKnob(const Knob& knob, std::string_view text, std::string_view name) {
  if (knob.type == KnobType::choice) {
    if (const KnobChoice* choice = findNamed(knob.choices, text)) return static_cast<double>(choice - knob.choices.data());
    throw UsageError(unknownNameIn(knob.choices, knob.noun, text.substr(0, kMostShown)));
  }
  if (knob.type == KnobType::flag) {
    if (text != "true" && text != "false") throw UsageError(std::string(name) + " must be true or false");
    return text == "true" ? 1.0 : 0.0;
  }
  const double value = requireNumber(text, knob.range, name);
  validate(knob, value, name);
  return knob.type == KnobType::number ? static_cast<double>(static_cast<float>(value)) : value;
}

std::string valuesText(const Knob& knob) {
  switch (knob.type) {
    case KnobType::number:
    case KnobType::whole: return rangeText(knob.range);
    case KnobType::flag: return "true or false";
    case KnobType::choice: break;
  }
  return listOf(knob.choices);
}

std::string phraseOf(const Knob& knob, double value) {
  std::string phrase(knob.phrase);
  if (const size_t place = phrase.find("{}"); place != std::string::npos) phrase.replace(place, 2, textOf(knob, value));
  return phrase;
}

double KnobValues::operator[](const Knob& knob) const {
  for (const auto& [known, value] : set_)
    if (known == &knob) return value;
  return knob.defaultValue;
}

void KnobValues::set(const Knob& knob, double value) {
  validate(knob, value, "the " + std::string(knob.noun));
  std::erase_if(set_, [&](const auto& entry) { return entry.first == &knob; });
  if (value == knob.defaultValue) return;
  const auto place = std::find_if(set_.begin(), set_.end(), [&](const auto& entry) { return entry.first->key > knob.key; });
  set_.insert(place, {&knob, value});
}

KnobValues KnobValues::only(std::span<const Knob* const> knobs) const {
  KnobValues values;
  for (const auto& entry : set_)
    if (std::find(knobs.begin(), knobs.end(), entry.first) != knobs.end()) values.set_.push_back(entry);
  return values;
}

}  // namespace warpscope

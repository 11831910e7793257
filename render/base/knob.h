// A knob is something that a user can turn, described once. Options and their help, plans of sweeps, keys of JSON and CSV, names in reports, widgets,
// fields on the wire and validation all read its row; what it turns brings the row in its own file pair.
// Values are double: a number as it is, a choice as its place among the choices, a flag as 0 or 1.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "render/base/named_value.h"
#include "render/base/range.h"

namespace warpscope {

enum class KnobType {
  number,  ///< held in single precision
  whole,
  choice,  ///< one of Knob::choices
  flag,
};

/// To what it belongs.
enum class KnobOwner { rendering, sampling, technique, effect, transport, display };

/// The first of a picture's stages that has to be done again once it was turned; behind the stages, none of them.
enum class KnobStage { march, encode, build, draw, nothing };

/// How a slider's track is divided.
enum class KnobScale { linear, logarithmic };

/// When a configuration's name says the value.
enum class KnobNaming {
  always,
  unlessDefault,
  whereDiffering,  ///< among configurations with another value
};

struct KnobChoice {
  std::string_view name;
  std::string_view summary;
};

/// As a knob's choices; the table holds the values of an enumeration in their order.
template <class Enum, size_t kCount>
constexpr std::array<KnobChoice, kCount> choicesOf(const std::array<NamedValue<Enum>, kCount>& table) {
  std::array<KnobChoice, kCount> choices{};
  for (size_t i = 0; i < kCount; ++i) {
    if (static_cast<size_t>(table[i].value) != i) throw "the table is not in the order of its enumeration";  // at compile time
    choices[i] = {table[i].name, table[i].summary};
  }
  return choices;
}

/// How sweeps go through its values.
struct KnobAxis {
  std::string_view key;     ///< in plans: "pointSizes"; empty: sweeps leave it as it is
  std::string_view option;  ///< on the command line: "--point-sizes"
  std::string_view help;    ///< what the values are: "Sizes of points in pixels"
  std::span<const double> values{};  ///< that a sweep takes by itself; empty: the one that is set
};

struct Knob {
  std::string_view key;      ///< in JSON, CSV, scene files and on the wire: "pointSize"
  std::string_view option{}; ///< on the command line: "--point-size"; empty: none
  std::string_view label{};  ///< beside its widget: "Point size"; empty: it has none
  std::string_view noun;     ///< in sentences: "point size"
  std::string_view help;     ///< one sentence without its full stop: what it does; where that is from
  std::string_view unit{};   ///< behind a value: " px"; with its blank, if there is to be one
  KnobType type = KnobType::number;
  KnobOwner owner = KnobOwner::technique;
  KnobStage stale = KnobStage::draw;
  /// Of techniques', several of which may have it: each panel of the window has its own value, to be compared side by side.
  bool isOfPanel = false;
  Range range{0.0, 0.0};     ///< of a number
  Range track{0.0, 0.0};     ///< the part of it that a slider goes through
  KnobScale scale = KnobScale::linear;
  int decimals = 2;          ///< of a number beside its slider
  double defaultValue = 0.0;
  std::span<const KnobChoice> choices{};
  KnobAxis axis{};
  std::string_view phrase{}; ///< in a configuration's name, the value for {}: " of {} px"; empty: names leave it out
  KnobNaming naming = KnobNaming::always;
};

/// The value as files, options and the wire write it; reads back as the same. For a choice its name.
std::string textOf(const Knob& knob, double value);

/// Back. Throws UsageError that names the knob as `name` (an option, or its noun) and says what would be right: for another type, an unknown
/// choice, or what validate() refuses.
double parseKnob(const Knob& knob, std::string_view text, std::string_view name);

/// Throws UsageError "NAME must be ..." unless the knob can have that value: in its range, whole, one of the choices.
void validate(const Knob& knob, double value, std::string_view name);

/// "0.001 to 1000", or the names of the choices.
std::string valuesText(const Knob& knob);

/// `knob.phrase` with the value in its place; the value's unit is the phrase's business.
std::string phraseOf(const Knob& knob, double value);

/// Values of knobs that no structure has a member for. What was not set has its default; equal values compare equal, set or not.
class KnobValues {
 public:
  double operator[](const Knob& knob) const;
  float number(const Knob& knob) const { return static_cast<float>((*this)[knob]); }
  int whole(const Knob& knob) const { return static_cast<int>((*this)[knob]); }
  template <class Enum>
  Enum choice(const Knob& knob) const {
    return static_cast<Enum>(whole(knob));
  }

  /// Throws UsageError for a value that the knob cannot have.
  void set(const Knob& knob, double value);
  template <class Enum>
    requires std::is_enum_v<Enum>
  void set(const Knob& knob, Enum value) {
    set(knob, static_cast<double>(value));
  }

  /// Of these knobs alone; all others are at their defaults.
  KnobValues only(std::span<const Knob* const> knobs) const;

  bool operator==(const KnobValues&) const = default;

 private:
  std::vector<std::pair<const Knob*, double>> set_;  // by rising key, without values that are the default
};

/// Those that a row of a structure turns: its knob, and how the structure holds it.
template <class Settings>
struct KnobRow {
  const Knob* knob = nullptr;
  double (*get)(const Settings&) = nullptr;
  void (*set)(Settings&, double) = nullptr;
};

}  // namespace warpscope

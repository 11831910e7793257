// Options made from the rows of knobs: names, help, what is refused.
// Typed texts are kept as they are until check() reads them, so that a number is judged as it was typed.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "render/base/knob.h"

namespace warpscope {

/// Values of those knobs that were given.
class GivenKnobs {
 public:
  void set(const Knob& knob, double value) { values_[&knob] = value; }
  /// Nothing for a knob that was not given.
  std::optional<double> find(const Knob& knob) const;

 private:
  std::map<const Knob*, double> values_;
};

/// Under which heading of the help the options stand that are added as long as it lives. Those of a command itself stand above all headings.
class HelpSection {
 public:
  HelpSection(CLI::App& command, const std::string& heading);
  ~HelpSection();
  HelpSection(const HelpSection&) = delete;
  HelpSection& operator=(const HelpSection&) = delete;

 private:
  CLI::App& command_;
  std::string outer_;
};

class KnobOptions {
 public:
  /// Adds the knob's option, if it has one. `otherwise`: what holds without it, for the help. `owners`: to what it belongs, likewise; may be empty.
  void add(CLI::App& command, const Knob& knob, const std::string& otherwise, std::span<const std::string_view> owners = {});

  /// Whether something was typed for it.
  bool has(const Knob& knob) const;
  /// Throws UsageError for a value that its knob cannot have; the sentence names the option.
  GivenKnobs check() const;

 private:
  std::map<const Knob*, std::string> typed_;  // empty: not given
};

}  // namespace warpscope

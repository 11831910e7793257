// Options from rows.
// See knob_options.h.
#include "app/commands/knob_options.h"

namespace warpscope {
namespace {

const char* typeName(KnobType type) {
  switch (type) {
    case KnobType::number: return "FLOAT";
    case KnobType::whole: return "INT";
    case KnobType::choice: return "NAME";
    case KnobType::flag: return "BOOL";
  }
  return "TEXT";
}

/// "Edge of a point in pixels, 1 to 16, for points; default: 2".
std::string helpOf(const Knob& knob, const std::string& otherwise, std::span<const std::string_view> owners) {
  std::string help(knob.help);
  help += (knob.type == KnobType::choice ? ": " : ", ") + valuesText(knob);
  for (size_t i = 0; i < owners.size(); ++i) help += (i == 0 ? ", for " : " and ") + std::string(owners[i]);
  return help + "; default: " + otherwise;
}

}  // namespace

HelpSection::HelpSection(CLI::App& command, const std::string& heading) : command_(command), outer_(command.option_defaults()->get_group()) {
  command.option_defaults()->group(heading);
}

HelpSection::~HelpSection() { command_.option_defaults()->group(outer_); }

std::optional<double> GivenKnobs::find(const Knob& knob) const {
  const auto found = values_.find(&knob);
  return found == values_.end() ? std::nullopt : std::optional(found->second);
}

void KnobOptions::add(CLI::App& command, const Knob& knob, const std::string& otherwise,
                      std::span<const std::string_view> owners) {
  if (knob.option.empty()) return;
  command.add_option(std::string(knob.option), typed_[&knob], helpOf(knob, otherwise, owners))->type_name(typeName(knob.type));
}

bool KnobOptions::has(const Knob& knob) const {
  const auto typed = typed_.find(&knob);
  return typed != typed_.end() && !typed->second.empty();
}

GivenKnobs KnobOptions::check() const {
  GivenKnobs given;
  for (const auto& [knob, text] : typed_)
    if (!text.empty()) given.set(*knob, parseKnob(*knob, text, knob->option));
  return given;
}

}  // namespace warpscope

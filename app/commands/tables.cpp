// Tables of rows and registries.
// See tables.h.
#include "app/commands/tables.h"

#include "app/experiment/configuration.h"
#include "app/picture/content.h"
#include "app/session/actions.h"
#include "app/session/demos.h"
#include "app/frames/transport_knobs.h"
#include "app/scene/scene.h"
#include "app/session/picture_plan.h"
#include "net/link_settings.h"
#include "render/base/error.h"
#include "render/base/nearest_name.h"
#include "render/march/march_knobs.h"
#include "render/warp/warp.h"

namespace warpscope {
namespace {

using Row = std::vector<std::string>;

/// A bar would end the cell.
std::string cell(std::string_view text) {
  std::string escaped;
  for (const char c : text) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
  return escaped;
}

std::string code(std::string_view text) { return text.empty() ? "" : "`" + std::string(text) + "`"; }

std::string lines(const Row& head, const std::vector<Row>& rows) {
  std::string text;
  const auto add = [&](const Row& row) {
    text += "|";
    for (const std::string& value : row) text += value.empty() ? " |" : " " + cell(value) + " |";
    text += "\n";
  };
  add(head);
  text += "|";
  for (size_t i = 0; i < head.size(); ++i) text += "---|";
  text += "\n";
  for (const Row& row : rows) add(row);
  return text;
}

std::string_view ownerName(KnobOwner owner) {
  switch (owner) {
    case KnobOwner::rendering: return "what the picture is";
    case KnobOwner::sampling: return "what is sent of it";
    case KnobOwner::technique: return "technique";
    case KnobOwner::effect: return "effect";
    case KnobOwner::transport: return "how it travels";
    case KnobOwner::display: return "display";
  }
  return "";
}

std::string_view stageName(KnobStage stage) {
  switch (stage) {
    case KnobStage::march: return "march";
    case KnobStage::encode: return "encode";
    case KnobStage::build: return "build";
    case KnobStage::draw: return "draw";
    case KnobStage::nothing: return "nothing";
  }
  return "";
}

/// `usual`: the value that it has where nobody says anything.
Row knobRow(const Knob& knob, const std::string& owner, double usual) {
  const std::string unit(knob.unit.substr(knob.unit.starts_with(' ') ? 1 : 0));
  const bool hasDefault = &knob != &kServerSideKnob;
  return {code(knob.key),
          code(knob.option),
          code(knob.axis.option),
          std::string(knob.label),
          std::string(knob.help),
          valuesText(knob) + (unit.empty() ? "" : " " + unit),
          hasDefault ? textOf(knob, usual) : "the pictures' longer side",
          owner,
          std::string(stageName(knob.stale))};
}

Row knobRow(const Knob& knob, const std::string& owner) { return knobRow(knob, owner, knob.defaultValue); }

std::string knobTable(const CLI::App&) {
  std::vector<Row> rows;
  for (const MarchKnob& row : marchKnobs()) rows.push_back(knobRow(*row.knob, std::string(ownerName(row.knob->owner)), row.get(defaultMarch())));
  for (const MarchText& text : marchTexts())
    rows.push_back({code(text.key), code(text.option), "", std::string(text.label), std::string(text.help), std::string(text.values),
                    text.get(defaultMarch()), std::string(ownerName(KnobOwner::effect)), std::string(stageName(KnobStage::march))});
  rows.push_back(knobRow(kServerSideKnob, std::string(ownerName(kServerSideKnob.owner))));
  for (const Knob* knob : warpKnobs()) {
    std::string owners;
    for (const std::string_view owner : ownersOf(*knob)) owners += (owners.empty() ? "" : ", ") + code(owner);
    rows.push_back(knobRow(*knob, owners));
  }
  for (const auto& row : transportKnobs()) rows.push_back(knobRow(*row.knob, std::string(ownerName(row.knob->owner))));
  rows.push_back(knobRow(kShortcutsKnob, std::string(ownerName(kShortcutsKnob.owner))));
  return lines({"key", "option", "option of `sweep`", "in the window", "what it does", "values", "default", "belongs to", "makes stale"}, rows);
}

std::string techniqueTable(const CLI::App&) {
  std::vector<Row> rows;
  for (const WarpDescriptor& technique : warpRegistry()) {
    std::string knobs;
    for (const Knob* knob : technique.knobs) knobs += (knobs.empty() ? "" : " ") + code(knob->option);
    rows.push_back({code(technique.name), std::string(technique.summary), knobs, technique.runsOnCuda ? "CPU, CUDA" : technique.usesFrame ? "CPU" : "as it marches"});
  }
  return lines({"technique", "what it draws", "own knobs", "runs on"}, rows);
}

template <class Table>
std::string choiceTable(const char* head, const Table& table) {
  std::vector<Row> rows;
  for (const auto& entry : table) rows.push_back({code(entry.name), std::string(entry.summary)});
  return lines({head, "meaning"}, rows);
}

std::string heuristicTable(const CLI::App&) { return choiceTable("heuristic", kHeuristics); }
std::string radiusTable(const CLI::App&) { return choiceTable("radius policy", kRadiusPolicies); }
std::string linkKeyTable(const CLI::App&) {
  std::vector<Row> rows;
  for (const net::LinkKey& key : net::linkKeys())
    rows.push_back({code(key.name), std::string(key.form), std::string(key.help)});
  return lines({"key", "value", "what"}, rows);
}

std::string linkTable(const CLI::App&) { return choiceTable("`--link`", net::linkPresets()); }

std::string commandTable(const CLI::App& program) {
  std::vector<Row> rows;
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; }))
    rows.push_back({code("warpscope " + command->get_name()), command->get_description()});
  return lines({"command", "what it does"}, rows);
}

std::string keyTable(const CLI::App&) {
  std::vector<Row> rows;
  for (const ActionDescriptor& action : windowActions()) rows.push_back({std::string(action.keys), std::string(action.help)});
  return lines({"key", "what it does"}, rows);
}

std::string contentTable(const CLI::App&) {
  std::vector<Row> rows;
  for (const ContentDescriptor& content : pictureContents())
    rows.push_back({code(content.name), std::string(content.label), std::string(content.help), content.unit == "1" ? "a share" : std::string(content.unit)});
  return lines({"`--show`", "in the window", "what is seen", "its ramp is in"}, rows);
}

std::string demoTable(const CLI::App&) {
  std::vector<Row> rows;
  for (const Demo& demo : demos()) {
    std::string techniques;
    for (const std::string_view name : demo.techniques) techniques += (techniques.empty() ? "" : ", ") + code(name);
    rows.push_back({std::string(demo.name), std::string(demo.summary), code(demo.link), std::string(describe(demo.motion).label), techniques});
  }
  return lines({"demo", "what one sees", "link", "camera", "panels"}, rows);
}

struct Table {
  std::string_view name;
  std::string (*text)(const CLI::App& program);
};

constexpr Table kTables[] = {{"commands", commandTable}, {"contents", contentTable}, {"demos", demoTable},      {"heuristics", heuristicTable},
                             {"keys", keyTable},         {"knobs", knobTable},       {"link-keys", linkKeyTable}, {"links", linkTable},
                             {"radii", radiusTable},     {"techniques", techniqueTable}};

}  // namespace

std::vector<std::string_view> tableNames() {
  std::vector<std::string_view> names;
  for (const Table& table : kTables) names.push_back(table.name);
  return names;
}

std::string tableText(std::string_view name, const CLI::App& program) {
  if (const Table* table = findNamed(kTables, name)) return table->text(program);
  throw UsageError(unknownNameIn(kTables, "table", name));
}

}  // namespace warpscope

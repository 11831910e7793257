// To JSON, back, and to options.
// See session_file.h.
#include "app/session/session_file.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/frames/transport_json.h"
#include "app/frames/transport_knobs.h"
#include "app/scene/json_document.h"
#include "app/scene/knob_json.h"
#include "app/scene/session_key.h"
#include "app/scene/transfer_file.h"
#include "app/scene/view_json.h"
#include "app/session/picture_plan.h"
#include "render/base/error.h"
#include "render/base/printable.h"
#include "render/base/shell_word.h"
#include "render/volume/volume_format.h"

namespace warpscope {
namespace {

using Json = nlohmann::json;

constexpr int64_t kVersion = 1;

/// Of techniques' knobs, those that are not at their defaults.
Json toJson(const KnobValues& knobs) {
  Json json = Json::object();
  for (const Knob* knob : warpKnobs())
    if (knobs[*knob] != knob->defaultValue) json[std::string(knob->key)] = jsonOf(*knob, knobs[*knob]);
  return json;
}

Json colorOf(Rgba8 mark) { return mark == 0 ? Json(nullptr) : Json({mark & 255, mark >> 8 & 255, mark >> 16 & 255}); }

Rgba8 readMark(const Node& node) {
  if (node.isNull()) return 0;
  Rgba8 mark = 0xff000000u;
  const std::vector<Node> channels = node.elements(3, 3);
  for (size_t i = 0; i < 3; ++i) mark |= static_cast<Rgba8>(channels[i].integer(0, 255)) << (8 * i);
  return mark;
}

Json toJson(const SceneOrigin& origin) {
  Json json{{"scene", origin.spec}};
  const SceneOverrides& overrides = origin.overrides;
  if (overrides.volume) json["volume"] = overrides.volume->string();
  if (overrides.mask) json["mask"] = overrides.mask->string();
  if (overrides.proceduralDims) json["volumeSize"] = {overrides.proceduralDims->x, overrides.proceduralDims->y, overrides.proceduralDims->z};
  if (overrides.fovYDeg) json["fovYDeg"] = *overrides.fovYDeg;
  json["seed"] = overrides.seed;
  return json;
}

SceneOrigin readOrigin(const Node& node) {
  constexpr std::string_view kKeys[] = {"scene", "volume", "mask", "volumeSize", "fovYDeg", "seed"};
  node.requireObject(kKeys);
  SceneOrigin origin{node.at("scene").string(), {}};
  SceneOverrides& overrides = origin.overrides;
  if (const auto volume = node.find("volume")) overrides.volume = volume->string();
  if (const auto mask = node.find("mask")) overrides.mask = mask->string();
  if (const auto size = node.find("volumeSize")) overrides.proceduralDims = readSize(*size);
  if (const auto fov = node.find("fovYDeg")) overrides.fovYDeg = fov->number(kFovYDegRange);
  if (const auto seed = node.find("seed")) overrides.seed = static_cast<uint32_t>(seed->integer(0, 0xffffffff));
  return origin;
}

Json toJson(const PanelSettings& panel, const std::optional<View>& ownView) {
  Json json{{"technique", panel.isAutomatic ? Json("auto") : Json(panel.technique->name)},
            {"knobs", toJson(panel.knobs)},
            {"content", describe(panel.content).name}};
  if (panel.contentRange) json["range"] = *panel.contentRange;
  if (ownView) json["view"] = toJson(*ownView);
  return json;
}

/// The descriptor with that name, or a complaint.
template <class Descriptors>
const auto& namedIn(const Descriptors& all, const Node& name) {
  const std::string text = name.string();
  const auto found = std::ranges::find_if(all, [&](const auto& one) { return one.name == text; });
  if (found == all.end()) name.fail("is none that there is");
  return *found;
}

void readPanel(const Node& node, SessionFile& file) {
  constexpr std::string_view kKeys[] = {"technique", "knobs", "content", "range", "view"};
  node.requireObject(kKeys);
  PanelSettings panel;
  const Node technique = node.at("technique");
  panel.isAutomatic = technique.string() == "auto";
  panel.technique = panel.isAutomatic ? &findWarp("splats") : &namedIn(warpRegistry(), technique);
  if (const auto knobs = node.find("knobs")) readWarpKnobs(*knobs, panel.knobs);
  if (const auto content = node.find("content")) panel.content = namedIn(pictureContents(), *content).value;
  if (const auto range = node.find("range")) panel.contentRange = static_cast<float>(range->number(kContentRange));
  file.panels.push_back(panel);
  const auto view = node.find("view");
  file.arrangement.ownViews.push_back(view ? std::optional(readView(*view)) : std::nullopt);
}

void requireUtf8(const std::string& name) {
  try {
    static_cast<void>(Json(name).dump());
  } catch (const Json::exception&) {
    throw InputError(printable(name) + ": its name is no UTF-8: a session could not find it again");
  }
}

}  // namespace

SessionFile sessionFileOf(const Session& session) {
  if (session.scene() == nullptr) throw InputError("there is no scene yet");
  if (!session.origin()) throw InputError("this scene cannot be opened again by its name");
  SessionFile file;
  file.origin = *session.origin();
  requireUtf8(file.origin.spec);
  for (const std::optional<std::filesystem::path>* path : {&file.origin.overrides.volume, &file.origin.overrides.mask})
    if (*path) requireUtf8((*path)->string());
  file.knobs = session.knobs();
  file.arrangement.view = session.view();
  file.arrangement.march = session.knobs().march;
  if (session.whyFunctionIsFixed().empty()) file.arrangement.transferFunction = session.scene()->transferFunction;
  for (size_t i = 0; i < session.panelCount(); ++i) {
    file.panels.push_back(session.panel(i));
    file.arrangement.ownViews.push_back(session.hasOwnCamera(i) ? std::optional(session.view(i)) : std::nullopt);
  }
  return file;
}

namespace {

Json jsonOf(const SessionFile& file) {
  Json panels = Json::array();
  for (size_t i = 0; i < file.panels.size(); ++i) panels.push_back(toJson(file.panels[i], file.arrangement.ownViews[i]));
  Json json{{std::string(kSessionKey), kVersion},
            {"origin", toJson(file.origin)},
            {"view", toJson(*file.arrangement.view)},
            {"march", toJson(*file.arrangement.march)},
            {"panels", panels},
            {"display", toJson(file.knobs.warp.knobs)},
            {"transport", toJson(file.knobs.transport)},
            {"serverSidePx", file.knobs.serverSidePx},
            {"screenPixels", file.knobs.screenPixels},
            {"uncovered", colorOf(file.knobs.marks.uncovered)},
            {"filled", colorOf(file.knobs.marks.filled)},
            {"shortcuts", file.knobs.takesShortcuts},
            {"budgetMs", file.knobs.budgetMs}};
  if (file.arrangement.transferFunction) json["transferFunction"] = toJson(*file.arrangement.transferFunction);
  return json;
}

/// Takes out of an object what stands in `usual` as well.
void dropUsual(Json& json, const Json& usual) {
  for (const auto& [key, value] : usual.items())
    if (json.contains(key) && json[key] == value) json.erase(key);
}

/// The same session in as few words as it can be read from, on one line.
std::string briefTextOf(const SessionFile& file) {
  SessionFile usual;
  usual.arrangement.view = View{};
  usual.arrangement.march = MarchSettings{};
  Json json = jsonOf(file);
  const Json usualJson = jsonOf(usual);
  for (const char* const key : {"march", "display", "transport"}) dropUsual(json[key], usualJson[key]);
  for (const char* const key : {"serverSidePx", "screenPixels", "uncovered", "filled", "shortcuts", "budgetMs"})
    if (json[key] == usualJson[key]) json.erase(key);
  for (const char* const key : {"display", "transport"})
    if (json[key].empty()) json.erase(key);
  for (Json& panel : json["panels"]) {
    if (panel["knobs"].empty()) panel.erase("knobs");
    if (panel["content"] == describe(PictureContent::picture).name) panel.erase("content");
  }
  return json.dump();
}

}  // namespace

std::string textOf(const SessionFile& file) { return textOf(jsonOf(file)); }

bool isSession(const JsonDocument& document) { return document.root().isObject() && document.root().find(kSessionKey).has_value(); }

bool isSessionFile(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error) || formatOf(path)) return false;  // volumes may be large
  try {
    return isSession(JsonDocument::fromFile(path, JsonDocument::kLargestMeasured));
  } catch (const InputError&) {
    return false;
  }
}

SessionFile readSession(const JsonDocument& document) {
  const Node root = document.root();
  constexpr std::string_view kKeys[] = {kSessionKey, "origin", "view", "march", "transferFunction", "panels", "display", "transport", "serverSidePx", "screenPixels",
                                        "uncovered", "filled", "shortcuts", "budgetMs"};
  root.requireObject(kKeys);
  const Node version = root.at(kSessionKey);
  if (version.integer(1, 1 << 30) != kVersion) version.fail("is of a later program: this one reads version " + std::to_string(kVersion));
  SessionFile file;
  file.origin = readOrigin(root.at("origin"));
  file.arrangement.view = readView(root.at("view"));
  file.arrangement.march = MarchSettings{};
  readMarch(root.at("march"), *file.arrangement.march);
  if (const auto function = root.find("transferFunction")) file.arrangement.transferFunction = readTransferFunction(*function);
  for (const Node& panel : root.at("panels").elements(1, kMaxPanels)) readPanel(panel, file);
  if (const auto display = root.find("display")) readWarpKnobs(*display, file.knobs.warp.knobs);
  if (const auto transport = root.find("transport")) readTransport(*transport, file.knobs.transport);
  if (const auto side = root.find("serverSidePx")) file.knobs.serverSidePx = static_cast<uint32_t>(side->integer(1, kMaxImageSide));
  if (const auto pixels = root.find("screenPixels")) file.knobs.screenPixels = static_cast<uint32_t>(pixels->integer(0, 16));
  if (const auto mark = root.find("uncovered")) file.knobs.marks.uncovered = readMark(*mark);
  if (const auto mark = root.find("filled")) file.knobs.marks.filled = readMark(*mark);
  if (const auto shortcuts = root.find("shortcuts")) file.knobs.takesShortcuts = shortcuts->boolean();
  if (const auto budget = root.find("budgetMs")) file.knobs.budgetMs = budget->number(kBudgetMsRange);
  return file;
}

SessionFile readSessionFile(const std::filesystem::path& path) { return readSession(JsonDocument::fromFile(path)); }
SessionFile readSessionText(const std::string& text, const std::string& source) { return readSession(JsonDocument(text, source)); }

namespace {

void setUp(const SessionFile& file, Session& session) {
  session.setPanels(file.panels);
  for (size_t i = 0; i < file.panels.size(); ++i) session.setOwnCamera(i, file.arrangement.ownViews[i].has_value());
  session.setMotion(CameraMotion::none);
  LiveSettings knobs = file.knobs;
  knobs.march = session.knobs().march;  // of the scene that is still on show; the file's come with its own
  session.setKnobs(knobs);
}

}  // namespace

void restore(const SessionFile& file, Session& session, const OriginOpener& opener) {
  LoadJob job = opener(file.origin);
  job.open = [open = std::move(job.open), arrangement = file.arrangement](const std::function<void()>& onNews, const std::stop_token& stop) {
    ConnectedScene opened = open(onNews, stop);
    opened.arrangement = arrangement;
    return opened;
  };
  if (session.scene() == nullptr)
    setUp(file, session);  // there is nothing that it would take away
  else
    job.whenOpened = [file, &session] { setUp(file, session); };
  session.load(std::move(job));
}

namespace {

/// Whether options say all that is on show. A recording says itself what they would; of cameras, contents and edits of the transfer function there are none, and of techniques' knobs one set.
bool areOptionsEnough(const SessionFile& file, const Session& session) {
  const LiveSettings usual;
  const bool isView = file.arrangement.view == session.scene()->views.front() && std::ranges::none_of(file.arrangement.ownViews, &std::optional<View>::has_value);
  const auto isPlain = [](const PanelSettings& panel) { return panel.content == PictureContent::picture; };
  const KnobValues ofOthers = file.panels.back().knobs;
  const auto hasKnobs = [&](const PanelSettings& panel) {
    const auto place = static_cast<size_t>(&panel - file.panels.data());
    return panel.knobs == (takesOptions(place, file.panels.size()) ? ofOthers : KnobValues{});
  };
  return !session.playback().isOpen() && isView && !session.hasOwnFunction() && std::ranges::all_of(file.panels, isPlain) && std::ranges::all_of(file.panels, hasKnobs) &&
         file.knobs.serverSidePx == usual.serverSidePx && file.knobs.screenPixels == usual.screenPixels;
}

std::string optionsFor(const SessionFile& file, const Session& session) {
  const LiveSettings& knobs = file.knobs;
  std::string line = "warpscope view";
  const auto add = [&](std::string_view option, const std::string& value) { line += " " + std::string(option) + " " + shellWord(value); };
  const bool isServer = file.origin.spec.find("://") != std::string::npos;
  if (isServer)
    add("--connect", file.origin.spec);
  else
    line += " " + shellWord(file.origin.spec);
  const SceneOverrides& overrides = file.origin.overrides;
  if (overrides.volume) add("--volume", overrides.volume->string());
  if (overrides.mask) add("--mask", overrides.mask->string());
  if (overrides.proceduralDims)
    add("--volume-size", std::to_string(overrides.proceduralDims->x) + "x" + std::to_string(overrides.proceduralDims->y) + "x" + std::to_string(overrides.proceduralDims->z));
  if (overrides.fovYDeg) add("--fov", Json(*overrides.fovYDeg).dump());
  if (overrides.seed != SceneOverrides{}.seed) add("--seed", std::to_string(overrides.seed));
  if (overrides.transferFunction) add("--tf", overrides.transferFunction->string());
  std::string panels;
  for (const PanelSettings& panel : file.panels) panels += (panels.empty() ? "" : ",") + (panel.isAutomatic ? std::string("auto") : std::string(panel.technique->name));
  add("--panels", panels);
  const MarchSettings usual = session.scene()->describedMarch.value_or(session.scene()->march);
  for (const MarchKnob& row : marchKnobs())
    if (row.get(knobs.march) != row.get(usual) && !row.knob->option.empty()) add(row.knob->option, textOf(*row.knob, row.get(knobs.march)));
  for (const MarchText& text : marchTexts())
    if (text.get(knobs.march) != text.get(usual)) add(text.option, text.get(knobs.march));
  // The last panel takes them.
  for (const Knob* knob : warpKnobs()) {
    const double value = knob->isOfPanel ? file.panels.back().knobs[*knob] : knobs.warp.knobs[*knob];
    if (value != knob->defaultValue && !knob->option.empty()) add(knob->option, textOf(*knob, value));
  }
  if (!(knobs.transport.link == net::DuplexLinkSettings{})) add("--link", net::toString(knobs.transport.link));
  for (const TransportKnob& row : transportKnobs())
    if (row.get(knobs.transport) != row.get(TransportSettings{}) && !row.knob->option.empty()) add(row.knob->option, textOf(*row.knob, row.get(knobs.transport)));
  const auto colorText = [](Rgba8 mark) {
    char text[8];
    std::snprintf(text, sizeof text, "%02x%02x%02x", mark & 255, mark >> 8 & 255, mark >> 16 & 255);
    return std::string(text);
  };
  if (knobs.marks.uncovered != 0) add("--uncovered", colorText(knobs.marks.uncovered));
  if (knobs.marks.filled != 0) add("--filled", colorText(knobs.marks.filled));
  if (knobs.budgetMs != kDefaultBudgetMs) add("--budget-ms", Json(knobs.budgetMs).dump());
  const double takesShortcuts = knobs.takesShortcuts ? 1.0 : 0.0;
  if (takesShortcuts != kShortcutsKnob.defaultValue) add(kShortcutsKnob.option, textOf(kShortcutsKnob, takesShortcuts));
  return line;
}

}  // namespace

std::string commandLineOf(const Session& session) {
  constexpr size_t kMostBytes = 100 << 10;  // Linux takes 128 KiB for one argument
  SessionFile file = sessionFileOf(session);
  if (areOptionsEnough(file, session)) return optionsFor(file, session);
  if (!session.hasOwnFunction() && !file.origin.overrides.transferFunction) file.arrangement.transferFunction.reset();  // the scene has it
  const std::string line = "warpscope view --session " + shellWord(briefTextOf(file));
  if (line.size() > kMostBytes) throw InputError("that is more than a command line takes: save the session (Ctrl+S), and open its file");
  return line;
}

}  // namespace warpscope

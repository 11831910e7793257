// The knobs of the network, and what the connection is doing.
// See parts.h.
#include <algorithm>
#include <array>
#include <cmath>

#include "app/frames/transport_knobs.h"
#include "app/ui/knob_parts.h"
#include "app/ui/parts.h"
#include "net/link_settings.h"

namespace warpscope::ui {
namespace {

constexpr float kMbit = 1e6f;

constexpr std::string_view kLinkHelp = "What is simulated between this program and the server, on top of what is there.",
                           kDelayHelp = "Delay: there and back, half of it each way.",
                           kJitterHelp = "Jitter: by how much the delay of each way varies, evenly; at most by the delay.",
                           kDownHelp = "How much passes from the server to here, in Mbit/s. All the way to the left: unlimited.",
                           kUpHelp = "How much passes from here to the server, in Mbit/s. All the way to the left: unlimited.",
                           kLossHelp = "Segments that are lost and sent again, as TCP does.";

/// Below this, in Mbit/s, a rate stands for none.
constexpr float kLeastMbit = 0.05f;

/// What of a link has knobs. Its two directions have the rate of their own; the rest is shared between them, or the same.
struct LinkKnobs {
  float roundTripMs = 0.0f;
  float jitterMs = 0.0f;
  float downMbit = 0.0f, upMbit = 0.0f;
  float lossPercent = 0.0f;

  bool operator==(const LinkKnobs&) const = default;
};

LinkKnobs knobsOf(const net::DuplexLinkSettings& link) {
  return {static_cast<float>(link.up.delayMs + link.down.delayMs), static_cast<float>(link.down.jitterMs),
          static_cast<float>(link.down.rateBitPerS) / kMbit, static_cast<float>(link.up.rateBitPerS) / kMbit,
          static_cast<float>(100.0 * link.down.loss)};
}

/// Bits a second, to a tenth of a Mbit; 0 is unlimited.
double rateOf(float mbit) { return mbit < kLeastMbit ? 0.0 : std::round(mbit * 10.0f) / 10.0 * kMbit; }

/// A share, to two digits of the percentage: no more than a slider can be set to.
double lossOf(float percent) {
  if (!(percent > 0.0f)) return 0.0;
  const double unit = std::pow(10.0, std::floor(std::log10(percent)) - 1.0);
  return std::round(percent / unit) * unit / 100.0;
}

/// `link` with what was edited; everything else of it stays.
void apply(const LinkKnobs& before, const LinkKnobs& edited, net::DuplexLinkSettings& link) {
  for (net::LinkSettings* way : {&link.up, &link.down}) {
    if (edited.roundTripMs != before.roundTripMs) way->delayMs = 0.5 * edited.roundTripMs;
    if (edited.jitterMs != before.jitterMs) {
      way->jitterMs = edited.jitterMs;
      way->jitter = edited.jitterMs > 0.0f ? net::Jitter::uniform : net::Jitter::none;
    }
    if (edited.lossPercent != before.lossPercent) way->loss = lossOf(edited.lossPercent);
    // No more than the delay: bytes do not arrive before they are sent.
    way->jitterMs = std::min(way->jitterMs, way->delayMs + (way->trace ? way->trace->meanMs() : 0.0));
    if (way->jitterMs == 0.0) way->jitter = net::Jitter::none;
  }
  if (edited.downMbit != before.downMbit) link.down.rateBitPerS = rateOf(edited.downMbit);
  if (edited.upMbit != before.upMbit) link.up.rateBitPerS = rateOf(edited.upMbit);
}

Track rateTrack(float mbit, const char* limited, const char* unlimited) { return {0.0f, 1000.0f, mbit < kLeastMbit ? unlimited : limited, true}; }

void drawPreset(net::DuplexLinkSettings& link, const Look& look) {
  label("Link", look, std::string(kLinkHelp));
  std::string shown = "own";
  for (const net::LinkPreset& preset : net::linkPresets())
    if (preset.settings == link) shown = preset.name;
  const bool isOpen = ImGui::BeginCombo("##link", shown.c_str());
  if (!isOpen) return tooltip(std::string(kLinkHelp) + " Now: " + net::inWords(link) + ".", look);
  for (const net::LinkPreset& preset : net::linkPresets()) {
    if (ImGui::Selectable(std::string(preset.name).c_str(), preset.settings == link)) link = preset.settings;
    tooltip(std::string(preset.summary), look);
  }
  ImGui::EndCombo();
}

constexpr std::chrono::milliseconds kOutage(2000);

void drawOutageButton(Session& session, const Look& look) {
  if (ImGui::Button("Outage, 2 s", {-1.0f, 0.0f})) session.beginOutage(kOutage, look.now);
  tooltip("Nothing passes for two seconds, neither here nor to the server: what has come so far must do.", look);
}

}  // namespace

size_t drawLinkKnobs(net::DuplexLinkSettings& link, const KnobFilter& isWanted, const Look& look) {
  const LinkKnobs before = knobsOf(link);
  LinkKnobs edited = before;
  size_t count = 0;
  const auto row = [&](std::initializer_list<std::string_view> words, const auto& draw) {
    if (!std::ranges::any_of(words, isWanted)) return;
    ++count;
    draw();
  };
  row({"Link", kLinkHelp}, [&] { drawPreset(link, look); });
  row({"Delay, jitter", "latency", "round trip", kDelayHelp, kJitterHelp}, [&] {
    label("Delay, jitter", look, std::string(kDelayHelp) + " " + std::string(kJitterHelp));
    beginHalves();
    bareSlider("delay", edited.roundTripMs, {0.0f, 2000.0f, "%.0f ms"}, kDelayHelp.data(), look);
    nextHalf();
    bareSlider("jitter", edited.jitterMs, {0.0f, 200.0f, "± %.1f ms"}, kJitterHelp.data(), look);
  });
  row({"Rate, Mbit/s", "bandwidth", kDownHelp, kUpHelp}, [&] {
    label("Rate, Mbit/s", look, std::string(kDownHelp));
    beginHalves();
    bareSlider("down", edited.downMbit, rateTrack(edited.downMbit, "↓ %.1f", "↓ any"), kDownHelp.data(), look);
    nextHalf();
    bareSlider("up", edited.upMbit, rateTrack(edited.upMbit, "↑ %.1f", "↑ any"), kUpHelp.data(), look);
  });
  row({"Loss", kLossHelp}, [&] {
    // As text, not as a format: its digits are those of the value. A slider without digits of its own begins at 0.001 %.
    const std::string loss = net::lossText(link.down.loss) + "%";
    slider("Loss", edited.lossPercent, {0.0f, 20.0f, loss.c_str(), true}, kLossHelp.data(), look);
  });
  if (edited != before) apply(before, edited, link);
  return count;
}

void drawNetwork(Session& session, LiveSettings& knobs, const Look& look) {
  if (!section("NETWORK", look)) return;
  TransportSettings& transport = knobs.transport;
  drawLinkKnobs(transport.link, [](std::string_view) { return true; }, look);
  for (const TransportKnob& row : transportKnobs())
    if (!row.isOfServer && row.matters(transport)) knobWidget(row, transport, look);
  drawOutageButton(session, look);

  const std::optional<SourceStatus> status = session.sourceStatus();
  if (!status || status->where.empty()) return;
  std::string text = status->isConnected ? status->where : "not connected to " + status->where;
  if (status->isConnected && status->roundTripMs > 0.0) text += ", round trip " + durationText(status->roundTripMs);
  ImGui::PushFont(look.fonts.small);
  ImGui::PushTextWrapPos(0.0f);
  ImGui::TextColored(status->isConnected ? palette().dimText : palette().errorText, "%s", text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::PopFont();
  drawProcesses(status->processes, look);
}

void drawLinkSign(const Session& session, const Look& look) {
  auto [text, brief, isOutage] = session.linkSign(look.now);  // in full or, where that has no room, by what says most
  if (text.empty() && !session.isRecording()) return;
  const bool hasLink = !isOutage && !text.empty();
  if (session.isRecording()) {
    text = "Recording. " + (text.empty() ? std::string("Ctrl+R ends it") : text);
    brief = "Recording. " + brief;
  } else if (session.playback().isOpen()) {
    text = "Recorded. " + text;
    brief = "Recorded. " + brief;
  }
  constexpr float kTimesTheUsual = 1.25f;
  const float size = kTimesTheUsual * ImGui::GetFontSize(), height = size + look.px(8.0f), width = ImGui::GetContentRegionAvail().x;
  const auto fits = [&](const std::string& words) { return kTimesTheUsual * ImGui::CalcTextSize(words.c_str()).x <= width - look.px(20.0f); };
  // What came of it, which the link's own delay is a part of, rather than all that the link does.
  std::string measured;
  for (size_t i = 0; i < session.panelCount() && measured.empty(); ++i)
    if (const FrameLatency latency = session.panel(i).latency; hasLink && latency.wireMs > 0.0)
      measured = ". A frame takes " + durationText(latency.totalMs()) + ", the wire " + durationText(latency.wireMs) + " of it";
  const std::array<std::string, 4> choices{text + measured, brief + measured, text, brief};
  const auto chosen = std::ranges::find_if(choices, fits);
  text = chosen != choices.end() ? *chosen : brief;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::Dummy({width, height});
  tooltip("What is on show is older than a round trip: a frame is marched, coded, sent and drawn as well, and may wait for the one before it. The coloured bars beneath the pictures say where the time goes. Where the march takes most of it, "
          "\"While moving\" (Server) makes it take less.", look);
  ImDrawList* list = ImGui::GetWindowDrawList();
  const ImVec2 to{at.x + width, at.y + height};
  list->AddRectFilled(at, to, ImGui::GetColorU32(isOutage ? palette().errorBackground : palette().noticeBackground), look.px(4.0f));
  list->PushClipRect(at, to, true);
  list->AddText(ImGui::GetFont(), size, {at.x + look.px(10.0f), at.y + look.px(4.0f)}, ImGui::GetColorU32(palette().noticeText), text.c_str());
  list->PopClipRect();
}

std::string connectionTrouble(const Session& session, const Look& look) {
  const std::optional<SourceStatus> status = session.sourceStatus();
  if (!status || status->isConnected) return {};
  std::string text = status->sentence.empty() ? "Connecting to " + status->where : "No connection: " + status->sentence;
  if (status->next) {
    const double waitMs = std::max(0.0, millisecondsBetween(look.now, *status->next));
    text += "; trying again in " + std::to_string(static_cast<int>(std::ceil(waitMs / 1e3))) + " s";
  }
  if (const std::optional<double> age = session.frames().ageOfNewestMs(look.now)) text += ". The frame on show is " + durationText(*age) + " old.";
  return text;
}

}  // namespace warpscope::ui

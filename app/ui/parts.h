// The parts of the window. Each reads the session, draws itself, and tells the session what the user changed.
// Sizes are in ImGui units; `scale` times a length at scale 1.
#pragma once

#include <imgui.h>

#include <array>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "app/session/actions.h"
#include "app/session/remembered.h"
#include "app/session/session.h"
#include "app/ui/run_window.h"
#include "app/ui/texture.h"
#include "app/ui/theme.h"
#include "render/march/march_knobs.h"

namespace warpscope::ui {

/// For how long the pointer has been on one item, so that explanations do not pop up on its way.
class Hover {
 public:
  /// `item` is the corner of the item under the pointer; true once it has been the same for a while.
  bool hasRested(const ImVec2& item, Session::TimePoint now);

 private:
  ImVec2 item_{-1.0f, -1.0f};
  Session::TimePoint since_{};
  int lastFrame_ = 0;
};

/// What every part needs to draw itself.
struct Look {
  Fonts fonts;
  float scale = 1.0f;
  float pixelsPerUnit = 1.0f;
  Session::TimePoint now;
  Hover* hover = nullptr;
  bool isDoubleClicked = false;  ///< by the left button, since the last picture
  Remembered* remembered = nullptr;  ///< what is folded up; MainView's
  const WindowGl* gl = nullptr;      ///< MainView's

  float px(float atScale1) const { return atScale1 * scale; }
};

/// How much of the measurements beneath a picture there is room for.
enum class MeasurementSpace { all, oneLine, none };

/// What is measured of a panel, as figures and as a line of its error, over the width of the current window; or the figures that say most, in one line.
/// `measurementsHeight` is what that takes of a width, in ImGui units.
void drawMeasurements(const Session& session, size_t index, MeasurementSpace space, const Look& look);
float measurementsHeight(float width, MeasurementSpace space, const Look& look);

/// Where the time of the panel's frame went, as a bar that fills the line. For techniques without frames the bar is empty.
void drawTimeline(const Panel& panel, const Look& look);
inline constexpr float kTimelinePx = 7.0f;  ///< its height at scale 1

/// Whether a knob with these words in its label or its explanation is to be drawn.
using KnobFilter = std::function<bool(std::string_view)>;

/// The knobs of a simulated link, as far as they are wanted; how many.
size_t drawLinkKnobs(net::DuplexLinkSettings& link, const KnobFilter& isWanted, const Look& look);

/// The part of the column of knobs that is about the network.
void drawNetwork(Session& session, LiveSettings& knobs, const Look& look);

/// What processes did for a frame that the server's volume is spread over: a bar each; nothing where there are none.
void drawProcesses(std::span<const net::ProcessFields> processes, const Look& look);

/// What is simulated between here and the server, in large letters over the panels' width; nothing where nothing is.
void drawLinkSign(const Session& session, const Look& look);

/// What to say about a connection that does not stand; empty if it does.
std::string connectionTrouble(const Session& session, const Look& look);

/// What a scene asks for beside emission and absorption. A list that is typed is taken once it is left; what is wrong with it stands below it.
class EffectKnobs {
 public:
  void draw(MarchSettings& settings, const Look& look);
  /// One list's field.
  void drawText(const MarchText& text, MarchSettings& settings, const Look& look);

 private:
  struct Typed {
    std::array<char, 512> text{};
    bool isActive = false;
    std::string refusal;  // empty where the text is the setting
    std::string setting;  // when it was refused
  };

  std::map<const MarchText*, Typed> typed_;
};

/// Each stage of the newest frame's march: in or out, why, and what it costs. Folded up until somebody wants to know.
class PlanList {
 public:
  void draw(Session& session, const Look& look);

 private:
  bool wasOpen_ = false;
};

/// Colours that pixels are marked with, or will be when somebody wants that: sRGB.
struct MarkColors {
  std::array<float, 3> uncovered{1.0f, 0.0f, 0.78f}, filled{0.0f, 0.85f, 1.0f};

  /// Takes over those that are in use.
  void take(const PixelMarks& marks) {
    const auto takeOne = [](Rgba8 mark, std::array<float, 3>& color) {
      for (size_t i = 0; mark != 0 && i < 3; ++i) color[i] = static_cast<float>(mark >> (8 * i) & 255) / 255.0f;
    };
    takeOne(marks.uncovered, uncovered);
    takeOne(marks.filled, filled);
  }
};

/// Scene, samples, rates: one line.
void drawStatusBar(const Session& session, double displayFramesPerSecond, const Look& look);

/// The session's error, or else the connection's trouble, as a sentence over the width of the window that it is called in, at its lower edge: titles stay in sight. Nothing without one.
void drawErrorBanner(Session& session, const Look& look);

/// Explains the item drawn last while the pointer rests on it.
void tooltip(const std::string& text, const Look& look);

/// The same, by what an action does and its key.
void tooltip(Action action, const Look& look);

/// A linear colour as the screen shows it.
ImU32 screenColor(const glm::vec3& linear, float opacity = 1.0f);

/// "1.2 ms", "123 ms", "12 s".
std::string durationText(double milliseconds);

/// "812 bytes", "72 kB", "1.25 MB".
std::string bytesText(size_t bytes);

}  // namespace warpscope::ui

// What the march of the newest frame has to do: each stage in or out, what it costs, and why.
// See parts.h.
#include <cmath>
#include <utility>

#include "app/ui/knob_parts.h"
#include "app/ui/parts.h"

namespace warpscope::ui {
namespace {

/// "+12.3 ms", "−0.42 ms".
std::string addedText(double ms) { return (ms < 0.0 ? "−" : "+") + durationText(std::abs(ms)); }

std::string spreadText(const Measured& measured) {
  return "median " + addedText(measured.medianMs) + ", half of the runs within " + durationText(measured.spreadMs);
}

void drawSmall(const ImVec4& color, const std::string& text, const Look& look) {
  ImGui::PushFont(look.fonts.small);
  ImGui::PushTextWrapPos(0.0f);
  ImGui::TextColored(color, "%s", text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::PopFont();
}

void drawStage(const StageDescriptor& stage, const PlannedStage& planned, const Measured* cost, bool isCurrent, const Look& look) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float right = at.x + ImGui::GetContentRegionAvail().x, radius = look.px(3.5f), line = ImGui::GetTextLineHeight();
  const ImVec2 center{at.x + radius, at.y + 0.5f * line};
  ImDrawList* list = ImGui::GetWindowDrawList();
  if (planned.isIn)
    list->AddCircleFilled(center, radius, ImGui::GetColorU32(palette().accent));
  else
    list->AddCircle(center, radius - look.px(0.5f), ImGui::GetColorU32(palette().faintText), 0, look.px(1.2f));

  ImGui::Indent(look.px(14.0f));
  ImGui::BeginGroup();
  const std::string name(stage.name);
  if (planned.isIn)
    ImGui::TextUnformatted(name.c_str());
  else
    ImGui::TextColored(palette().dimText, "%s", name.c_str());
  if (cost != nullptr) {
    const std::string text = addedText(cost->medianMs);
    ImGui::SameLine();
    ImGui::SetCursorScreenPos({right - ImGui::CalcTextSize(text.c_str()).x, at.y});
    if (isCurrent)
      ImGui::TextUnformatted(text.c_str());
    else
      ImGui::TextColored(palette().faintText, "%s", text.c_str());
  }
  drawSmall(palette().dimText, (planned.isIn ? "in: " : "out: ") + planned.reason, look);
  ImGui::EndGroup();
  std::string help = "The stage " + name + ": " + std::string(stage.summary) + ".";
  if (cost != nullptr)
    help += " By it the march takes " + spreadText(*cost) + (isCurrent ? "." : "; measured at an earlier camera.");
  tooltip(help, look);
  ImGui::Unindent(look.px(14.0f));
}

/// How it stands with the plan and its figures.
std::string standingText(const LivePlan& plan) {
  if (!plan.error().empty()) return plan.error();
  if (!plan.plan()) return plan.isKnown() ? "The server plans: `warpscope plan` says it there." : "No frame yet.";
  if (plan.isMeasuring()) return "Measuring: marches with and without each stage.";
  if (!plan.costs()) return "What each costs is measured when all rests.";
  return "The march took " + durationText(plan.costs()->march.medianMs) + " on this machine, by each stage so much of it" +
         (plan.areCurrent() ? ":" : " (at an earlier camera):");
}

}  // namespace

void PlanList::draw(Session& session, const Look& look) {
  ImGui::SetNextItemOpen(session.showsPlan());
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {look.px(4.0f), look.px(3.0f)});
  const bool isOpen = ImGui::TreeNodeEx("What a frame takes", ImGuiTreeNodeFlags_NoTreePushOnOpen | ImGuiTreeNodeFlags_SpanAvailWidth);
  ImGui::PopStyleVar();
  tooltip("Each stage of the march: in or out, why, and what it costs. Key E.", look);
  session.setShowsPlan(isOpen);
  if (isOpen && !std::exchange(wasOpen_, isOpen)) ImGui::SetScrollHereY(0.0f);  // by the key it may open out of sight
  wasOpen_ = isOpen;
  if (!isOpen) return;
  const LivePlan& plan = session.plan();
  drawSmall(plan.error().empty() ? palette().dimText : palette().errorText, standingText(plan), look);
  if (!plan.plan()) return;
  for (const bool isIn : {true, false})
    for (const StageDescriptor& stage : kStages) {
      const PlannedStage& planned = (*plan.plan())[stage.stage];
      if (planned.isIn != isIn) continue;
      drawStage(stage, planned, plan.costs() ? plan.costs()->of(stage.stage) : nullptr, plan.areCurrent(), look);
    }
}

}  // namespace warpscope::ui

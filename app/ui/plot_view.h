// The window's plot: accuracy against time of what was on show, and of a sweep, if there is one.
// Filled points are live, hollow ones the sweep's; rings are what nothing else of their kind beats.
#pragma once

#include <optional>
#include <string>

#include "app/experiment/sweep_file.h"
#include "app/picture/plot.h"
#include "app/ui/parts.h"

namespace warpscope::ui {

class PlotView {
 public:
  explicit PlotView(std::optional<SweepFile> sweep) : sweep_(std::move(sweep)) {}

  /// Of a window's body of that height (ImGui units): less where there is little room, or when it is folded up.
  float height(float bodyHeight, const Look& look) const;
  /// Fills the current child window. A point that is clicked on is taken over by the session, its technique by that panel.
  void draw(Session& session, size_t panel, const Look& look);

  /// Its points for a file, and as CSV: a line each, with what it stands for.
  Plot plot(const Session& session) const;
  std::string csv(const Session& session) const;

  bool isUnfolded() const { return isUnfolded_; }
  void showSweep(SweepFile sweep);
  /// Why a sweep could not be read.
  void showError(std::string error) { error_ = std::move(error); }

  static constexpr const char* kHeading = "Error against time";

 private:
  struct Shown;
  Shown shownOf(const Session& session, size_t panel) const;
  void drawHeader(const Look& look);
  void drawMeasuring(Session& session, const Look& look);

  std::optional<SweepFile> sweep_;
  std::string error_, measuringError_;
  bool isUnfolded_ = true;
};

}  // namespace warpscope::ui

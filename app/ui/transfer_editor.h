// The transfer function: its histogram, its two curves, presets, files; every change is shown at once.
// Edits are those of app/scene/transfer_curves.h.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "app/scene/transfer_curves.h"
#include "app/session/actions.h"
#include "app/session/edit_history.h"
#include "app/session/watched_function.h"
#include "app/ui/parts.h"

namespace warpscope::ui {

class TransferEditor {
 public:
  /// Once for each frame, whether or not it is drawn: another scene, a file that was written.
  void update(Session& session, Session::TimePoint now);
  /// In the current window, over its width.
  void draw(Session& session, const EditHistory& history, const Look& look);

  /// Those that are edited; null where the function is not the user's to choose.
  const TransferCurves* curves(const Session& session) const;
  /// Edits those from now on.
  void setCurves(Session& session, const TransferCurves& curves);
  /// Whether the pointer holds a corner or the window.
  bool isHeld() const { return grip_ != Grip::none; }
  /// Shows that function from now on; what is wrong with it is said in the editor.
  void set(Session& session, const TransferFunction& function);
  /// What was asked for by its menu since the last call; whoever has dialogs asks for the file.
  enum class FileWish { load, save, saveForParaview };
  std::optional<FileWish> takeFileWish() { return std::exchange(fileWish_, std::nullopt); }
  /// Throws InputError for a file that cannot be written.
  void save(const Session& session, const std::filesystem::path& path, bool isForParaview) const;
  /// Something to be said of what was done, once.
  std::optional<std::string> takeNote() { return std::exchange(note_, std::nullopt); }
  /// Which of undo and redo its buttons asked for since the last call.
  std::optional<Action> takeAction() { return std::exchange(action_, std::nullopt); }
  /// Follows a file: whenever it is written, it is loaded (watched_function.h). Empty: none.
  void watch(const std::filesystem::path& path, std::function<void()> onNews) { watched_.watch(path, std::move(onNews)); }

  /// Why the last function could not be loaded or shown; empty if it could.
  const std::string& error() const { return error_; }

 private:
  /// What the pointer holds.
  enum class Grip { none, opacity, color, window };
  struct Chart;

  void followScene(const Session& session);
  void followFile(Session& session, Session::TimePoint now);
  void show(Session& session, const TransferFunction& function);
  void apply(Session& session);
  void drawChart(Session& session, const Look& look);
  static void drawOpacities(ImDrawList& list, const Chart& chart, const Look& look);
  void drawColorBar(Session& session, const Look& look);
  /// The values beneath both.
  void drawAxis(const Session& session, const Look& look) const;
  void drawFields(Session& session, const Look& look);
  void drawButtons(Session& session, const EditHistory& history, const Look& look);
  void drawFilePopup();
  /// What a field is for: of which corner of opacities or colours.
  enum class Field { value, alpha, colorValue };
  /// A field for a number of a corner. What is typed there holds when the field is left.
  void drawNumber(Session& session, Field field, size_t corner, double value, const char* pattern);
  /// What was typed holds, of the corner that it was typed for, whichever is chosen now.
  void takeTyped(Session& session);
  Chart chartOf(const Session& session, const ImVec2& from, const ImVec2& to) const;

  TransferCurves curves_;
  TransferFunction shown_;       // that the curves are of
  TransferCurves curvesAtGrip_;  // when what is held was taken
  ImVec2 gripAt_{0.0f, 0.0f};
  Grip grip_ = Grip::none;
  std::optional<size_t> opacity_, color_;  // corners that are chosen; at most one of both
  std::optional<size_t> toRemove_;         // by letting go of the right button there
  std::optional<std::string> note_;
  std::string sceneName_;
  const Volume* volume_ = nullptr;
  std::string error_;
  std::string reading_;             // of what is pointed at
  struct Typed {
    Field field = Field::value;
    size_t corner = 0;
    double value = 0.0;
  };
  std::optional<Typed> typed_;      // into a field that has not been left yet
  std::optional<FileWish> fileWish_;
  std::optional<Action> action_;
  struct Spread {
    std::string preset;         // whose units are not the volume's; empty: none
    TransferFunction function;  // that it became
  };
  Spread spread_;
  WatchedFunction watched_;
};

}  // namespace warpscope::ui

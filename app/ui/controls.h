// The column of knobs: scene, transfer function, server, effects, network, display, camera.
#pragma once

#include <functional>
#include <string>

#include "app/ui/parts.h"
#include "app/ui/transfer_editor.h"

namespace warpscope::ui {

/// The column of knobs.
class Controls {
 public:
  using FileOpener = std::function<void(const std::string&)>;

  /// `openFile` takes whatever path or URL is typed.
  void draw(Session& session, const SceneOpener& openScene, const FileOpener& openFile, const EditHistory& history, const Look& look);
  /// Puts the keyboard into the field in which knobs are searched, and chooses what is there.
  void search();
  /// Looks for nothing any more; whether it did.
  bool endSearch();
  /// What is looked for there; empty: nothing.
  std::string_view searched() const { return search_.data(); }
  /// How many knobs, or groups of some, were found last.
  size_t foundKnobs() const { return found_; }
  TransferEditor& transferEditor() { return transferEditor_; }
  const TransferEditor& transferEditor() const { return transferEditor_; }

 private:
  void drawScene(Session& session, const SceneOpener& openScene, const FileOpener& openFile, const Look& look);

  void drawSearch(const Look& look);
  /// All knobs that have what was typed in their names or explanations.
  void drawFound(Session& session, LiveSettings& knobs, const Look& look);

  std::array<char, 64> search_{};
  bool wantsSearch_ = false;
  size_t found_ = 0;
  TransferEditor transferEditor_;
  EffectKnobs effects_;
  PlanList plan_;
  std::array<char, 1024> path_{};
  MarkColors markColors_;
};

}  // namespace warpscope::ui

// The column of knobs: scene, transfer function, server, effects, network, display, camera.
#pragma once

#include "app/ui/parts.h"
#include "app/ui/transfer_editor.h"

namespace warpscope::ui {

/// The column of knobs.
class Controls {
 public:
  void draw(Session& session, const SceneOpener& openScene, const Look& look);
  TransferEditor& transferEditor() { return transferEditor_; }
  const TransferEditor& transferEditor() const { return transferEditor_; }

 private:
  void drawScene(Session& session, const SceneOpener& openScene, const Look& look);

  TransferEditor transferEditor_;
  EffectKnobs effects_;
  PlanList plan_;
  std::array<char, 1024> path_{};
  MarkColors markColors_;
};

}  // namespace warpscope::ui

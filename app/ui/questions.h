// What is asked before something is done: how a film is to be, and whether to quit while one is being written.
#pragma once

#include <optional>

#include "app/ui/parts.h"

namespace warpscope::ui {

/// How the recording on show is to be exported. Its answers stay for the next time.
class ExportQuestion {
 public:
  void ask() { isAsked_ = true; }
  /// The answer, once.
  std::optional<ExportLook> draw(const Session& session, const Look& look);

 private:
  bool isAsked_ = false;
  size_t size_ = 0;  // of those that can be chosen
  bool hasLabels_ = true, hasErrors_ = false;
};

/// Whether to quit while an export is at work.
class QuitQuestion {
 public:
  void ask() { isAsked_ = true; }
  bool isOpen() const { return isOpen_; }
  /// It was closed otherwise.
  void dismiss() { isOpen_ = false; }
  /// True, once, where the answer is yes.
  bool draw(const Session& session);

 private:
  bool isAsked_ = false, isOpen_ = false;
};

}  // namespace warpscope::ui

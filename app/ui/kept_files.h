// Files that the user writes from the window: sessions, recordings, pictures, films; and what is said of them.
// Each function that writes gives a sentence without its full stop, for the bottom of the window.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/session/file_keeper.h"
#include "app/session/remembered.h"
#include "app/session/session.h"

namespace warpscope::ui {

class KeptFiles {
 public:
  /// `remembered` outlives it; `onNews` is called on another thread when something was written, or could not be.
  KeptFiles(Remembered& remembered, std::function<void()> onNews);

  /// Throws UsageError where the session reads that file now.
  void requireUnread(const Session& session, const std::filesystem::path& path) const;
  /// These three throw InputError for a file that cannot be written.
  std::string saveSession(const Session& session, const std::filesystem::path& path);
  std::string startRecording(Session& session, const std::filesystem::path& path);
  std::string startExport(Session& session, const std::filesystem::path& path, const ExportLook& look);
  std::string endRecording(Session& session);
  /// A recording was begun elsewhere.
  void noteRecording(const std::filesystem::path& path) { recordedFile_ = path; }

  /// Files of the next free number in the folder where the program was started. What becomes of them takeNote() says.
  void keep(std::vector<FileKeeper::File> files) { keeper_.keep(std::move(files)); }
  /// The panels' pictures. False where there is none yet.
  bool keepPanels(const Session& session);

  /// What has come to its end since the last call; once a frame.
  std::optional<std::string> takeNote(Session& session);

 private:
  Remembered& remembered_;
  FileKeeper keeper_;
  std::filesystem::path recordedFile_;  // that is being recorded; empty where it was not begun here
};

}  // namespace warpscope::ui

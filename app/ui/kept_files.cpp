// Names, and sentences.
// See kept_files.h.
#include "app/ui/kept_files.h"

#include <utility>

#include "app/picture/picture.h"
#include "app/session/recorded_scene.h"
#include "app/session/session_file.h"
#include "app/shell/output_files.h"

namespace warpscope::ui {
namespace {

/// What is read of them while they are on show, so that nothing may be written there.
std::vector<std::filesystem::path> filesOnShow(const Session& session) {
  std::vector<std::filesystem::path> files;
  if (const std::optional<SceneOrigin>& origin = session.origin()) {
    files.emplace_back(origin->spec);
    for (const auto& more : {origin->overrides.volume, origin->overrides.mask, origin->overrides.transferFunction})
      if (more) files.push_back(*more);
  }
  if (session.scene() != nullptr) files.insert(files.end(), session.scene()->files.begin(), session.scene()->files.end());
  if (session.playback().isOpen()) files.push_back(session.playback().recording().file);
  return files;
}

std::filesystem::path currentFolder() {
  std::error_code failed;
  const std::filesystem::path folder = std::filesystem::current_path(failed);
  return failed ? "." : folder;
}

}  // namespace

KeptFiles::KeptFiles(Remembered& remembered, std::function<void()> onNews) : remembered_(remembered), keeper_(currentFolder(), std::move(onNews)) {}

void KeptFiles::requireUnread(const Session& session, const std::filesystem::path& path) const {
  try {
    requireNoneOf(path, filesOnShow(session));
  } catch (const UsageError& error) {
    throw InputError(error.what());  // no command line's
  }
}

std::string KeptFiles::saveSession(const Session& session, const std::filesystem::path& path) {
  requireUnread(session, path);
  writeFileWhole(path, textOf(sessionFileOf(session)));
  remembered_.addFile(path);
  return "saved " + path.string();
}

std::string KeptFiles::startRecording(Session& session, const std::filesystem::path& path) {
  requireUnread(session, path);
  session.startRecording(path, textForRecording(session));
  recordedFile_ = path;
  return "recording into " + path.string();
}

std::string KeptFiles::startExport(Session& session, const std::filesystem::path& path, const ExportLook& look) {
  requireUnread(session, path);
  session.startExport(path, look);
  return "exporting into " + path.string();
}

std::string KeptFiles::endRecording(Session& session) {
  const size_t leftOut = session.stopRecording();
  std::string note = "the recording has ended";
  if (!recordedFile_.empty()) {
    remembered_.addFile(recordedFile_);
    note = "recorded " + std::exchange(recordedFile_, {}).string() + "; File > Open again shows it, and then File > Export film makes a film of it";
  }
  if (leftOut > 0) note += "; " + std::to_string(leftOut) + " frames are not in it: they came faster than they could be written, or went with their device";
  return note;
}

bool KeptFiles::keepPanels(const Session& session) {
  std::vector<FileKeeper::File> files;
  for (size_t i = 0; i < session.panelCount(); ++i) {
    const Panel& panel = session.panel(i);
    const ShownPicture shown = panel.hasContentOnShow() ? panel.shownContent.picture : panel.picture;
    if (!shown || panel.isHidden) continue;
    files.push_back({"-" + std::to_string(i + 1) + "-" + std::string(panel.technique->name) + ".png", [shown] {
                       if (shown.host) return encodePng(*shown.host);
                       Image<Rgba8> picture(shown.width(), shown.height());
                       shown.device->download({picture.data(), picture.size()});
                       return encodePng(picture);
                     }});
  }
  if (files.empty()) return false;
  keep(std::move(files));
  return true;
}

std::optional<std::string> KeptFiles::takeNote(Session& session) {
  if (!recordedFile_.empty() && !session.isRecording()) {  // another scene was opened, or the disk is full, which is said elsewhere
    remembered_.addFile(recordedFile_);
    return "the recording has ended: " + std::exchange(recordedFile_, {}).string();
  }
  if (std::optional<std::string> note = session.exporting().takeNote()) return note;
  return keeper_.takeNote();
}

}  // namespace warpscope::ui

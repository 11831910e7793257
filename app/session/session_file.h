// A session as a file: the scene, how it looks, the camera, the panels and every knob; and the command that shows the same.
// JSON; the format is in app/README.md. What was measured, and frames, are not in it.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/session/session.h"

namespace warpscope {

class JsonDocument;

struct SessionFile {
  SceneOrigin origin;
  SceneArrangement arrangement;  ///< all of it said; a view of its own, or nothing, for each panel
  std::vector<PanelSettings> panels;
  LiveSettings knobs;
};

/// Makes jobs that open scenes.
using OriginOpener = std::function<LoadJob(const SceneOrigin&)>;

/// Whether what stands where a file's name could is the text of one.
inline bool isSessionText(std::string_view text) { return text.starts_with('{'); }
/// Whether it looks like one, right or wrong.
bool isSession(const JsonDocument& document);
/// Of a file, whatever its name ends with; false for one that cannot be read, or is no JSON.
bool isSessionFile(const std::filesystem::path& path);

/// What is on show now. Throws InputError where there is no scene, or one that cannot be opened again.
SessionFile sessionFileOf(const Session& session);
std::string textOf(const SessionFile& file);
/// Throws InputError that names the file, the line and the key.
SessionFile readSession(const JsonDocument& document);
SessionFile readSessionFile(const std::filesystem::path& path);

/// As readSessionFile(), of its text; `source` names it in complaints.
SessionFile readSessionText(const std::string& text, const std::string& source);

/// Opens the scene in the background, and sets up panels and knobs with it: where it cannot be opened, all stays as it is. Where there is no scene yet they are set
/// up at once.
void restore(const SessionFile& file, Session& session, const OriginOpener& opener);

/// "warpscope view ..." that shows the same: by options where they say all of it, else by the text of the session, `--session '{...}'`. Throws as sessionFileOf(),
/// and InputError where no command line would take that much.
std::string commandLineOf(const Session& session);

}  // namespace warpscope

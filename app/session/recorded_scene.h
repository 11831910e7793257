// A recording as a scene of the window: its frames, its camera, and what was recorded of how it was shown.
// Its volume is opened again where it is at hand: for the ground truth, and for techniques that march.
#pragma once

#include <filesystem>
#include <optional>

#include "app/session/session_file.h"

namespace warpscope {

/// What marches the volume that was recorded, by the transfer function that the recording began with. Throws InputError with the reason where that is not to be had here.
MarcherPtr marcherOf(const Recording& recording, Backend backend, const std::stop_token& stop);

/// Opens a recording. Where its volume is not here, there is no ground truth, and techniques that march say why. `onNews`: as connectFrameSource's. Throws as
/// readRecording().
ConnectedScene openRecording(const std::filesystem::path& path, Backend backend, std::function<void()> onNews, const std::stop_token& stop);

/// What is written into a recording of a session about how it was recorded; empty where its scene cannot be opened again. Of one that shows a recording: the scene
/// of that, so that there is a ground truth.
std::string textForRecording(const Session& session);

/// The session that was recorded, as one whose scene is the recording; nothing where the recording does not tell. Throws as readRecording() and readSessionText().
std::optional<SessionFile> sessionFileOfRecording(const std::filesystem::path& path, const std::stop_token& stop = {});

}  // namespace warpscope

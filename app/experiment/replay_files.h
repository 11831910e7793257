// A replay written into files: numbered pictures, a film by the program ffmpeg, or both.
// The pictures are replay.h's.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "app/experiment/replay.h"

namespace warpscope {

/// Whether there is the program that makes films.
bool canFilm();

struct ReplayFiles {
  std::filesystem::path folder;  ///< made where it is not there
  std::string prefix{};          ///< of pictures, before their numbers: PREFIX000001.png and so on
  std::string film{};            ///< a name in that folder that ends with .mp4 or .gif; empty: none
  bool hasPictures = true;       ///< false: the film alone
};

/// How many files writeReplay() makes, as steps.
size_t stepsOf(const Recording& recording, double picturesPerSecond, const ReplayFiles& files);
/// Name of a picture, counted from 0.
std::string pictureNameOf(const std::string& prefix, size_t index);
/// One of such a name that is in the folder; nothing where none is.
std::optional<std::filesystem::path> pictureThere(const ReplayFiles& files);

/// Writes all of it; `onStep` is called before each step with what that is. Returns the number of pictures. Numbered pictures that an earlier run had more of are
/// removed. Pictures stay where the film alone fails. Throws InputError where a technique can show nothing of the recording, for a frame that cannot be decoded, where
/// files cannot be written and where ffmpeg fails; OperationCancelled if `stop` is set; then nothing has changed, but for pictures that were whole.
size_t writeReplay(const Recording& recording, const ReplaySettings& settings, const ReplayFiles& files, const std::function<void(const std::string&)>& onStep,
                   const std::stop_token& stop);

}  // namespace warpscope

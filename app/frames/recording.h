// A recording: what came from a server and where the camera was, each with its time, so that it can be shown again by any technique.
// A file: the eight bytes kRecordingMagic (recording_format.h), then records, each the seconds since its beginning (a double), a type (one byte), the length of what follows (four
// bytes), and that; all little-endian (wire.h). Scenes, frames and their heads are as in net/messages.h, payloads as the packed codec makes them, without loss
// (Zstandard); transfer functions as in scene files, JSON; links in words. Records are appended as they come: of a program that was killed what had come in its last second is missing, or
// was waiting to be coded, and a record that is cut off is left out.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "app/frames/link_sign.h"
#include "app/scene/camera_motion.h"
#include "app/scene/scene.h"
#include "net/messages.h"

namespace warpscope {

/// What was recorded. Frames stay in their file until somebody wants them: it may be larger than memory.
struct Recording {
  struct Frame {
    double seconds = 0.0;
    net::FrameHead head;
    uint64_t payloadAt = 0;  ///< in the file, in bytes from its beginning
    size_t payloadBytes = 0;
    bool hasProxy = false;   ///< frames after it without one are of the same copy of the volume
  };

  struct Function {
    double seconds = 0.0;
    TransferFunction function;
  };

  struct Link {
    double seconds = 0.0;
    LinkSign sign;  ///< in words: what the settings name may be elsewhere
  };

  std::filesystem::path file;
  Scene scene;        ///< without its volume; its function is the first of `functions`
  std::string text;   ///< as it was handed over
  CameraPath path;
  std::vector<Frame> frames;  ///< by rising time
  std::vector<Function> functions;  ///< by rising time, the first at 0; none where the volume was a server's, which knows how it looks
  std::vector<Link> links;    ///< by rising time; none where nothing was simulated, or was not recorded
  double seconds = 0.0;       ///< of its last record
};

/// Whether it looks like one, right or wrong.
bool isRecording(const std::filesystem::path& path);

/// Throws InputError for a file that is none, or of another version, and where it holds no view; OperationCancelled if `stop` is set.
Recording readRecording(const std::filesystem::path& path, const std::stop_token& stop = {});

/// The index of the frame that was the newest at that time; nothing before the first.
std::optional<size_t> frameAt(const Recording& recording, double seconds);

/// The index of the view of its path that the frame was asked with, as far as its camera tells: the likest, of several the last before it came.
size_t viewAskedWith(const Recording& recording, const Recording::Frame& arrived, const Camera& camera);

/// When the camera was no longer where that view has it: seconds; the end, where it stayed there.
double leftAt(const Recording& recording, size_t view);

/// What was simulated at that time.
LinkSign linkAt(const Recording& recording, double seconds);

/// The function that the scene was shown by at that time; null where none is known.
const TransferFunction* functionAt(const Recording& recording, double seconds);

}  // namespace warpscope

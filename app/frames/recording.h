// A recording: what came from a server and where the camera was, each with its time, so that it can be shown again by any technique.
// A file: the eight bytes kRecordingMagic, then records, each the seconds since its beginning (a double), a type (one byte), the length of what follows (four
// bytes), and that; all little-endian (wire.h). Scenes, frames and their heads are as in net/messages.h, payloads as the packed codec makes them, without loss
// (Zstandard); transfer functions as in scene files, JSON; links in words. Records are appended as they come: of a program that was killed what had come in its last second is missing, or
// was waiting to be coded, and a record that is cut off is left out.
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "app/scene/camera_motion.h"
#include "net/link_settings.h"
#include "net/messages.h"
#include "render/codec/codec.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// Its last byte is the format's version.
inline constexpr std::string_view kRecordingMagic{"WSCOPER\x01", 8};

/// What a sign says of what is simulated between a server and a client, in full and where room is scarce; empty where nothing is.
struct LinkSign {
  std::string full, brief;
  bool isOutage = false;

  bool operator==(const LinkSign&) const = default;
};
LinkSign signOf(const net::DuplexLinkSettings& link, bool hasOutage);

/// Records in a thread of its own; nothing of it waits. On one thread.
class RecordingWriter {
 public:
  /// Begins a file, replacing one that is there. `text`: whatever is to be known of how it was recorded (a session's file). Throws InputError.
  RecordingWriter(const std::filesystem::path& path, const Scene& scene, const std::string& text);
  /// As finish().
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// Times do not fall.
  void addView(double seconds, const View& view);
  void addFrame(double seconds, SampleFramePtr frame);
  /// The function that the scene is shown by from then on; that of the scene it began with is there already.
  void addFunction(double seconds, const TransferFunction& function);
  /// What is simulated between the server and here from then on; nothing, until this is called.
  void addLink(double seconds, const LinkSign& sign);
  /// Why it goes on no more (the disk is full); empty while it does. Frames that come faster than they can be written are left out, and counted.
  std::string error() const;
  size_t framesLeftOut() const;
  /// Writes what is left, and waits for that: nothing may be added from then on. Why not all of it is in the file; empty if it is.
  std::string finish();

 private:
  class Work;
  const std::unique_ptr<Work> work_;
};

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

/// The frames of a recording, read and decoded as they are asked for.
class RecordedFrames {
 public:
  /// `recording` and its file must stay.
  explicit RecordedFrames(const Recording& recording) : recording_(recording), file_(recording.file, std::ios::binary) {}

  /// The frame that was the newest at that time, its copy of the volume by the function of that time; null before the first. Throws InputError for one that cannot be read or decoded.
  SampleFramePtr at(double seconds);
  /// Of the frame that at() gave last, as it was recorded; of the copy of the volume, whichever frame that came with.
  const FrameBytes& bytes() const { return bytes_; }

 private:
  SampleFrame decoded(size_t index);
  SampleFramePtr read(double seconds);

  const Recording& recording_;
  std::ifstream file_;
  FrameCodec codec_;
  std::optional<size_t> decoded_, proxyFrame_;  // whose frame_ and proxy_ are
  SampleFramePtr frame_;
  ProxyPtr proxy_;
  FrameBytes bytes_;
  size_t proxyBytes_ = 0;
};

}  // namespace warpscope

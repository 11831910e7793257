// A recording: what came from a server and where the camera was, each with its time, so that it can be shown again by any technique.
// A file: the eight bytes kRecordingMagic, then records, each the seconds since its beginning (a double), a type (one byte), the length of what follows (four
// bytes), and that; all little-endian (wire.h). Scenes, frames and their heads are as in net/messages.h, payloads as the packed codec makes them, without loss
// (Zstandard). Records are appended as they come: of a program that was killed at most the last second is missing, and a record that is cut off is left out.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "app/scene/camera_motion.h"
#include "net/messages.h"
#include "render/codec/codec.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// Its last byte is the format's version.
inline constexpr std::string_view kRecordingMagic{"WSCOPER\x01", 8};

/// Records in a thread of its own; nothing of it waits. On one thread.
class RecordingWriter {
 public:
  /// Begins a file, replacing one that is there. `text`: whatever is to be known of how it was recorded (a session's file). Throws InputError.
  RecordingWriter(const std::filesystem::path& path, const Scene& scene, const std::string& text);
  /// Writes what is left, and waits for that.
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// Times do not fall.
  void addView(double seconds, const View& view);
  void addFrame(double seconds, SampleFramePtr frame);
  /// Why it goes on no more (the disk is full); empty while it does. Frames that come faster than they can be written are left out, and counted.
  std::string error() const;
  size_t framesLeftOut() const;

 private:
  class Work;
  const std::unique_ptr<Work> work_;
};

/// What was recorded.
struct Recording {
  struct Frame {
    double seconds = 0.0;
    net::FrameHead head;
    std::vector<std::byte> payload;
  };

  Scene scene;        ///< without its volume
  std::string text;   ///< as it was handed over
  CameraPath path;
  std::vector<Frame> frames;  ///< by rising time
  double seconds = 0.0;       ///< of its last record
};

/// Throws InputError for a file that is none, or of another version, and where it holds no view; OperationCancelled if `stop` is set.
Recording readRecording(const std::filesystem::path& path, const std::stop_token& stop = {});

/// The frames of a recording, decoded as they are asked for.
class RecordedFrames {
 public:
  /// `recording` must stay.
  explicit RecordedFrames(const Recording& recording) : recording_(recording) {}

  /// The frame that was the newest at that time; null before the first. Throws InputError for one that cannot be decoded.
  SampleFramePtr at(double seconds);

 private:
  const Recording& recording_;
  FrameCodec codec_;
  std::optional<size_t> decoded_;
  SampleFramePtr frame_;
  ProxyPtr proxy_;
};

}  // namespace warpscope

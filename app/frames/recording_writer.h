// Makes a recording (recording.h), beside whoever shows what is recorded.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "app/frames/link_sign.h"
#include "app/scene/scene.h"
#include "render/core/crew.h"
#include "render/core/transfer_function.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// Records in a thread of its own; nothing of it waits. On one thread.
class RecordingWriter {
 public:
  /// Begins a file, replacing one that is there at once: it is to be whole up to the last second whatever comes, and so cannot be put in place when it is. `text`: whatever is to be known of how it was recorded (a session's file). `crew`: that its loops run on; its thread stands back then. Throws InputError.
  RecordingWriter(const std::filesystem::path& path, const Scene& scene, const std::string& text, std::shared_ptr<Crew> crew = nullptr);
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

}  // namespace warpscope

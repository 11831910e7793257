// The frames of a recording (recording.h), one after the other.
#pragma once

#include <fstream>
#include <optional>

#include "app/frames/recording.h"
#include "render/codec/codec.h"

namespace warpscope {

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

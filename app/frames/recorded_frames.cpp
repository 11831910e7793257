// A frame's place in the file is known; its copy of the volume may be another's.
// See recorded_frames.h.
#include "app/frames/recorded_frames.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "app/frames/classified_frame.h"
#include "app/frames/recording_format.h"
#include "app/frames/wire_fields.h"
#include "render/base/error.h"

namespace warpscope {

SampleFrame RecordedFrames::decoded(size_t index) {
  const Recording::Frame& recorded = recording_.frames[index];
  const auto fail = [&](const std::string& why) { return InputError("the recording's frame " + std::to_string(index + 1) + why); };
  std::vector<std::byte> payload(recorded.payloadBytes);
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(recorded.payloadAt));
  if (!readExactly(file_, payload.data(), payload.size())) throw fail(" cannot be read any more: " + recording_.file.string() + " has changed");
  try {
    return decodedFrom(recorded.head, payload, codec_);
  } catch (const InputError& error) {
    throw fail(std::string(" is damaged: ") + error.what());
  }
}

SampleFramePtr RecordedFrames::at(double seconds) {
  const SampleFramePtr frame = read(seconds);
  const TransferFunction* const function = functionAt(recording_, seconds);
  if (frame && function != nullptr) frame_ = classifiedBy(*function, frame);
  return frame ? frame_ : nullptr;
}

SampleFramePtr RecordedFrames::read(double seconds) {
  const std::optional<size_t> wanted = frameAt(recording_, seconds);
  if (!wanted) return nullptr;
  if (decoded_ == wanted) return frame_;
  const auto hasProxy = [&](size_t index) { return recording_.frames[index].hasProxy; };
  size_t source = *wanted;  // of the copy of the volume
  while (source > 0 && !hasProxy(source)) --source;
  if (source != *wanted && hasProxy(source) && proxyFrame_ != source) {
    proxy_ = decoded(source).proxy;
    proxyBytes_ = codec_.bytes().proxy;
    proxyFrame_ = source;
  }
  SampleFrame frame = decoded(*wanted);
  bytes_ = codec_.bytes();
  if (frame.proxy) {
    proxy_ = frame.proxy;
    proxyBytes_ = bytes_.proxy;
    proxyFrame_ = wanted;
  } else if (hasProxy(source) && proxy_) {
    frame.proxy = proxy_;
    bytes_.proxy = proxyBytes_;
    frame.settings.sample.proxy = static_cast<int>(std::max({proxy_->volume->dims().x, proxy_->volume->dims().y, proxy_->volume->dims().z}));
  }
  frame.geometry = recording_.scene.geometry();
  frame_ = std::make_shared<const SampleFrame>(std::move(frame));
  decoded_ = wanted;
  return frame_;
}

}  // namespace warpscope

// One frame as a client gets it, for commands that wait for it: marched here and sent through the codec, or asked of a server.
// What a window does all the time is in frame_source.h.
#pragma once

#include <functional>
#include <stop_token>

#include "app/frames/frame_source.h"
#include "render/core/color.h"
#include "render/march/marcher.h"
#include "render/warp/warp.h"

namespace warpscope {

/// A frame from wherever it comes. Throws as marching and the network do.
using FrameFetch = std::function<ServedFrame(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop)>;

/// Marches here, encodes and decodes: the frame has whatever the codec makes of it, and its times and bytes. One call at a time.
FrameFetch fetchHere(MarcherPtr marcher, const CodecSettings& codec);

/// What one frame's way through the codec takes, by the host's clock.
struct CodecTrip {
  FrameBytes bytes;  ///< of the payload
  double encodeMs = 0.0, decodeMs = 0.0;
};
/// Encodes `sent` and decodes it into `received`, which may be the same frame; its members other than samples and colours must be those of `sent`. Its copy of
/// the volume stays the same object. Throws InputError if what was encoded cannot be decoded.
CodecTrip throughCodec(FrameCodec& codec, const SampleFrame& sent, const CodecSettings& settings, SampleFrame& received, DecodedPlace place = DecodedPlace::host);

/// What a technique draws of a frame of so many bytes: the samples', or the segments', or neither.
inline size_t bytesFor(const WarpDescriptor& technique, const FrameBytes& bytes) {
  if (technique.uses.segments) return bytes.segments;
  return technique.usesFrame && !technique.uses.proxy ? bytes.samples : 0;
}
/// Whether a technique could draw the same from the frame's picture: then it is charged for pictureBytes.
inline bool drawsPictureAlone(const WarpDescriptor& technique) {
  const SampleUse& uses = technique.uses;
  return technique.usesFrame && !uses.depth && !uses.segments && !uses.proxy;
}

/// Asks `source`, and waits. Throws InputError with the connection's trouble if that does not end within some seconds. `onBusy`, if any, is
/// called with the number of others that the server works for meanwhile, when it says so.
FrameFetch fetchFrom(FrameSourcePtr source, std::function<void(uint16_t)> onBusy = {});

/// What a viewer that streams images would have been sent instead of the frame: its picture over `background` (linear RGB), coded as
/// the codec codes colours: JPEG of its quality, or PNG.
size_t pictureBytes(const SampleFramePtr& frame, const glm::vec3& background, const CodecSettings& codec);

}  // namespace warpscope

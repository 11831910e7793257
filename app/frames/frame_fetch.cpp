// Serving and waiting.
// See frame_fetch.h.
#include "app/frames/frame_fetch.h"

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "app/frames/backend.h"
#include "app/picture/picture.h"
#include "app/shell/log.h"
#include "render/base/error.h"
#include "render/base/stopwatch.h"
#include "render/codec/jpeg.h"
#include "render/warp/warp.h"

namespace warpscope {
namespace {

/// A connection that is down for longer is given up; one that is down for a moment is not spoken of.
constexpr std::chrono::seconds kPatience(15), kMoment(1);
constexpr std::chrono::milliseconds kLookAgain(2);

ServedFrame waitFor(FrameSource& source, uint64_t id, const std::function<void(uint16_t)>& onBusy,
                    const std::stop_token& stop) {
  auto connectedAt = std::chrono::steady_clock::now();
  bool isSaid = false;
  while (!stop.stop_requested()) {
    if (std::optional<ServedFrame> served = source.tryTake(); served && served->requestId == id) {
      if (!served->frame) throw InputError("the server: " + served->error);
      return std::move(*served);
    }
    const auto now = std::chrono::steady_clock::now();
    const SourceStatus status = source.status();
    if (status.isRefused) throw InputError(status.sentence);
    if (status.isConnected) connectedAt = now;
    if (status.busyWith && onBusy) onBusy(*status.busyWith);
    if (now - connectedAt > kPatience) throw InputError(status.sentence);
    if (now - connectedAt > kMoment && !std::exchange(isSaid, true))
      logWarning(status.sentence + "; trying again for " + std::to_string(kPatience.count()) + " s");
    std::this_thread::sleep_for(kLookAgain);
  }
  const SourceStatus status = source.status();
  throw WaitCancelled(status.isConnected ? "" : status.sentence);
}

}  // namespace

FrameFetch fetchHere(MarcherPtr marcher, const CodecSettings& coding) {
  return [marcher, codec = std::make_shared<FrameCodec>(makeTiledCoder(marcher->backend())), coding](const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) {
    ServedFrame served;
    served.requestedAt = std::chrono::steady_clock::now();
    auto frame = std::make_shared<SampleFrame>(marcher->march(camera, settings, stop));
    served.latency = latencyOf(frame->timings);
    const CodecTrip trip = throughCodec(*codec, *frame, coding, *frame);
    served.latency.encodeMs = trip.encodeMs;
    served.latency.decodeMs = trip.decodeMs;
    served.bytes = trip.bytes;
    served.frame = std::move(frame);
    served.arrivedAt = std::chrono::steady_clock::now();
    return served;
  };
}

CodecTrip throughCodec(FrameCodec& codec, const SampleFrame& sent, const CodecSettings& settings, SampleFrame& received, DecodedPlace place) {
  CodecTrip trip;
  ByteVector payload;
  trip.encodeMs = milliseconds([&] { payload = codec.encode(sent, settings); });
  trip.bytes = codec.bytes();
  const size_t count = sent.size();
  const ProxyPtr proxy = sent.proxy;
  DecodeError error;
  trip.decodeMs = milliseconds([&] { error = codec.decode(payload, count, received, {.place = place}); });
  if (error) throw InputError("the program's own frame cannot be decoded: " + *error);
  received.proxy = proxy;  // equal to what came, and one for all frames, as where it comes once
  return trip;
}

FrameFetch fetchFrom(FrameSourcePtr source, std::function<void(uint16_t)> onBusy) {
  return [source = std::move(source), onBusy = std::move(onBusy), last = std::make_shared<std::atomic<uint64_t>>(0)](
             const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) {
    const uint64_t id = ++*last;  // of all copies of this
    source->post({id, camera, settings}, std::chrono::steady_clock::now());
    return waitFor(*source, id, onBusy, stop);
  };
}

size_t pictureBytes(const SampleFramePtr& frame, const glm::vec3& background, const CodecSettings& codec) {
  if (codec.format == PayloadFormat::packed && codec.color == ColorCoding::jpeg)
    return encodeFramePicture(*onHost(frame), background, codec.jpegQuality).size();
  const std::unique_ptr<Warp> hold = makeWarp(findWarp("hold"), {});
  hold->setFrame(frame, {}, {});
  WarpedImage image;
  hold->draw(frame->camera, {}, image, {});
  return encodePng(toScreen(image, background)).size();
}

}  // namespace warpscope

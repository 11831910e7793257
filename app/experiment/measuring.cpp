// Stages and their clocks.
// See measuring.h.
#include "app/experiment/measuring.h"

#include "app/frames/frame_fetch.h"
#include "render/base/stopwatch.h"

namespace warpscope {
namespace {

/// Takes the frame once: what uploading and building took.
std::array<double, 2> builtMs(Warp& warp, const SampleFramePtr& frame, const WarpSettings& settings, const std::stop_token& stop) {
  const double tookMs = milliseconds([&] { warp.setFrame(frame, settings, stop); });
  const std::optional<DeviceTimings> timings = warp.deviceTimings();
  return timings ? std::array{timings->uploadMs, timings->buildMs} : std::array{0.0, tookMs};
}

MarchSettings withoutProxy(MarchSettings settings) {
  settings.sample.proxy = 0;
  return settings;
}

struct DrawnOnce {
  double tookMs = 0.0;
  bool isOnDevice = false;
};

DrawnOnce drawnOnce(const Drawing& drawing, const Camera& camera, WarpedImage& image, const std::stop_token& stop) {
  DrawnOnce drawn;
  drawn.tookMs = milliseconds([&] {
    drawn.isOnDevice = drawing.warp.drawForScreen(camera, drawing.settings, drawing.background, {}, stop) != nullptr;
    if (!drawn.isOnDevice) drawing.warp.draw(camera, drawing.settings, image, stop);
  });
  if (const std::optional<DeviceTimings> timings = drawing.warp.deviceTimings()) drawn.tookMs = timings->drawMs;
  return drawn;
}

}  // namespace

Measured Measuring::time(const std::function<void()>& work) const {
  return parts([&] { return std::array{milliseconds(work)}; })[0];
}

MeasuredMarch measureMarch(const Measuring& measuring, Marcher& marcher, const Camera& camera, const MarchSettings& settings) {
  MeasuredMarch result;
  const auto measured = measuring.parts([&] {
    result.frame.reset();  // its memory is the next one's
    SampleFrame made;
    const double tookMs = milliseconds([&] { made = marcher.march(camera, settings, measuring.withinRuns); });
    const ServerTimings timings = made.timings;
    result.frame = std::make_shared<const SampleFrame>(std::move(made));
    return std::array{timings.marchMs, timings.compactMs, timings.copyMs, tookMs};
  });
  result.march = measured[0];
  result.compact = measured[1];
  result.copy = measured[2];
  result.samples = measured[3];
  return result;
}

MeasuredCoding measureCoding(const Measuring& measuring, FrameCodec& codec, const SampleFramePtr& frame, const CodecSettings& settings, DecodedPlace place) {
  MeasuredCoding result;
  auto received = std::make_shared<SampleFrame>(*frame);
  const auto measured = measuring.parts([&] {
    const CodecTrip trip = throughCodec(codec, *frame, settings, *received, place);
    result.bytes = trip.bytes;
    return std::array{trip.encodeMs, trip.decodeMs};
  });
  if (onHost(received)->samples != onHost(frame)->samples) throw InputError("the codec gives back other samples than it got");
  result.frame = std::move(received);
  result.encode = measured[0];
  result.decode = measured[1];
  return result;
}

Measured measureService(const Measuring& measuring, Marcher& marcher, FrameCodec& codec, const Camera& camera, const MarchSettings& settings, const CodecSettings& coding) {
  const MarchSettings later = withoutProxy(settings);
  return measuring.time([&] {
    codec.encode(FrameCodec::codesOnDevices(coding) ? marcher.marchToCode(camera, later, measuring.withinRuns) : marcher.march(camera, later, measuring.withinRuns), coding);
  });
}

MeasuredBuild measureBuild(const Measuring& measuring, Warp& warp, const SampleFramePtr& frame, const WarpSettings& settings) {
  const auto measured = measuring.parts([&] { return builtMs(warp, frame, settings, measuring.withinRuns); });
  return {measured[0], measured[1]};
}

MeasuredDraw drawOnce(const Drawing& drawing, const Camera& camera, WarpedImage& image, const std::stop_token& stop) {
  const DrawnOnce drawn = drawnOnce(drawing, camera, image, stop);
  return {measuredOf({drawn.tookMs}), drawn.isOnDevice};
}

MeasuredDraw measureDraw(const Measuring& measuring, const Drawing& drawing, const Camera& camera, WarpedImage& image) {
  MeasuredDraw result;
  result.draw = measuring.parts([&] {
    const DrawnOnce drawn = drawnOnce(drawing, camera, image, measuring.withinRuns);
    result.isOnDevice = drawn.isOnDevice;
    return std::array{drawn.tookMs};
  })[0];
  return result;
}

MeasuredFirstPicture measureFirstPicture(const Measuring& measuring, const Drawing& drawing, const SampleFramePtr& frame, const Camera& camera,
                                         WarpedImage& image) {
  const auto measured = measuring.parts([&] {
    std::array<double, 2> built{};
    const double tookMs = milliseconds([&] {
      built = builtMs(drawing.warp, frame, drawing.settings, measuring.withinRuns);
      drawnOnce(drawing, camera, image, measuring.withinRuns);
    });
    return std::array{built[0], built[1], tookMs};
  });
  return {{measured[0], measured[1]}, measured[2]};
}

Measured measureArrival(const Measuring& measuring, const Drawing& drawing, FrameCodec& codec, const CodecSettings& coding, const SampleFramePtr& frame,
                        const Camera& camera, WarpedImage& image) {
  SampleFrame head = *frame;
  head.settings = withoutProxy(head.settings);
  const ByteVector payload = codec.encode(head, coding);
  const size_t count = head.size();
  head.samples = {};
  head.colors = {};
  head.segments = {};
  for (SamplePlane& plane : head.planes) plane.values = {};
  return measuring.parts([&] {
    auto received = std::make_shared<SampleFrame>(head);
    DecodeError error;
    const double tookMs = milliseconds([&] {
      error = codec.decode(payload, count, *received, {.place = DecodedPlace::device});
      received->settings = frame->settings;
      received->proxy = frame->proxy;  // which came before
      if (error) return;
      builtMs(drawing.warp, std::move(received), drawing.settings, measuring.withinRuns);
      drawnOnce(drawing, camera, image, measuring.withinRuns);
    });
    if (error) throw InputError("the program's own frame cannot be decoded: " + *error);
    return std::array{tookMs};
  })[0];
}

MeasuredPicture measurePicture(const Measuring& measuring, const Drawing& drawing, FrameCodec& codec, const CodecSettings& coding,
                               const SampleFramePtr& frame, const Camera& camera) {
  MeasuredPicture picture;
  picture.decode = measureCoding(measuring, codec, frame, coding, drawing.place).decode;
  picture.build = measureBuild(measuring, drawing.warp, frame, drawing.settings);
  WarpedImage image;
  picture.draw = measureDraw(measuring, drawing, camera, image).draw;
  return picture;
}

}  // namespace warpscope

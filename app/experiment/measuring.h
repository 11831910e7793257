// What a measurement is, for every command and for the window: one run that warms up and does not count, then several, of which the median and the
// spread between the quartiles are kept. And what each stage is timed from and to.
// After Hoefler, Belli: Scientific Benchmarking of Parallel Computing Systems, SC 2015, section 3: times are not normally distributed.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <stop_token>
#include <tuple>
#include <type_traits>
#include <vector>

#include "app/experiment/measured.h"
#include "render/base/error.h"
#include "render/codec/codec.h"
#include "render/warp/warp.h"

namespace warpscope {

/// How often work is done, and what ends it early.
struct Measuring {
  int runs = 3;                 ///< that count, at least 1
  std::stop_token betweenRuns;  ///< looked at before each run: what is measured is never left half way
  std::stop_token withinRuns;   ///< handed to marching and warping, which may then end half way

  Measuring(int runCount, const std::stop_token& stop) : runs(runCount), betweenRuns(stop), withinRuns(stop) {}
  /// Whatever is measured stays usable when `stop` ends it.
  static Measuring inWholeRuns(int runs, const std::stop_token& stop) {
    Measuring measuring(runs, stop);
    measuring.withinRuns = {};
    return measuring;
  }

  /// Calls `work`, which says in milliseconds what its parts took: an array. One Measured for each part. Throws OperationCancelled.
  template <class Work>
  auto parts(const Work& work) const {
    constexpr size_t kParts = std::tuple_size_v<std::invoke_result_t<Work>>;
    std::array<std::vector<double>, kParts> times;
    for (int run = -1; run < runs; ++run) {
      if (betweenRuns.stop_requested()) throw OperationCancelled();
      const std::array<double, kParts> took = work();
      for (size_t i = 0; run >= 0 && i < kParts; ++i) times[i].push_back(took[i]);
    }
    std::array<Measured, kParts> measured;
    for (size_t i = 0; i < kParts; ++i) measured[i] = measuredOf(std::move(times[i]));
    return measured;
  }

  /// What calling `work` takes by the host's clock.
  Measured time(const std::function<void()>& work) const;
};

/// A frame of a marcher.
struct MeasuredMarch {
  SampleFramePtr frame;           ///< the last
  Measured march, compact, copy;  ///< the marcher's stages (ServerTimings); `copy` is from the device to the host, 0 on the CPU
  Measured samples;               ///< camera to samples in host memory, by the host's clock
};
MeasuredMarch measureMarch(const Measuring& measuring, Marcher& marcher, const Camera& camera, const MarchSettings& settings);

/// A frame's way through the codec, on the CPU.
struct MeasuredCoding {
  SampleFramePtr frame;  ///< as a client gets it
  FrameBytes bytes;      ///< of its payload
  Measured encode, decode;
};
/// Throws InputError if the codec does not give back the samples.
MeasuredCoding measureCoding(const Measuring& measuring, FrameCodec& codec, const SampleFramePtr& frame, const CodecSettings& settings,
                             DecodedPlace place = DecodedPlace::host);

/// From the camera to bytes that are ready to be sent, by the host's clock: what a server does for any frame but a scene's first, which brings the copy of the volume.
Measured measureService(const Measuring& measuring, Marcher& marcher, FrameCodec& codec, const Camera& camera, const MarchSettings& settings, const CodecSettings& coding);

/// A frame in host memory until a technique can draw it. On a device both are between events there, on the CPU by the host's clock.
struct MeasuredBuild {
  Measured upload;  ///< frame to the device's memory; 0 on the CPU
  Measured build;   ///< what the technique derives from it (a hierarchy, a vertex buffer)
};
MeasuredBuild measureBuild(const Measuring& measuring, Warp& warp, const SampleFramePtr& frame, const WarpSettings& settings);

/// How a technique draws for a display: over a background, left on the device if there is one.
struct Drawing {
  Warp& warp;
  const WarpSettings& settings;
  const glm::vec3& background;  ///< linear RGB
  DecodedPlace place = DecodedPlace::host;  ///< of the frames that it is given: placeFor() the technique
};
/// Where frames are to be that it draws from as they are: who draws on the host waits for them to be brought.
inline DecodedPlace placeFor(const WarpDescriptor& technique) { return technique.runsOnCuda ? DecodedPlace::device : DecodedPlace::host; }

/// From the camera to finished colours in the memory of the backend that drew them: on a device between events there, on the CPU by the host's clock.
struct MeasuredDraw {
  Measured draw;
  bool isOnDevice = false;  ///< the picture was left there; else the image that was handed over holds it
};
/// Draws once, for what is warm already and takes long.
MeasuredDraw drawOnce(const Drawing& drawing, const Camera& camera, WarpedImage& image, const std::stop_token& stop);
MeasuredDraw measureDraw(const Measuring& measuring, const Drawing& drawing, const Camera& camera, WarpedImage& image);

/// A build with a draw after it.
struct MeasuredFirstPicture {
  MeasuredBuild build;
  Measured firstPicture;  ///< frame in host memory to its first picture, by the host's clock
};
MeasuredFirstPicture measureFirstPicture(const Measuring& measuring, const Drawing& drawing, const SampleFramePtr& frame, const Camera& camera,
                                         WarpedImage& image);

/// From such bytes (measureService) to the first picture of `camera`, by the host's clock. The technique has the frame afterwards.
Measured measureArrival(const Measuring& measuring, const Drawing& drawing, FrameCodec& codec, const CodecSettings& coding, const SampleFramePtr& frame,
                        const Camera& camera, WarpedImage& image);

/// What a picture costs at the client if every frame is new.
struct MeasuredPicture {
  Measured decode;
  MeasuredBuild build;
  Measured draw;

  double frameMs() const { return decode.medianMs + build.upload.medianMs + build.build.medianMs + draw.medianMs; }
};
/// `frame` is coded anew, to be decoded. The technique has it afterwards.
MeasuredPicture measurePicture(const Measuring& measuring, const Drawing& drawing, FrameCodec& codec, const CodecSettings& coding,
                               const SampleFramePtr& frame, const Camera& camera);

}  // namespace warpscope

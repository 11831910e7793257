// Timing what has been checked.
// See benchmark.h.
#include "app/experiment/benchmark.h"

#include <algorithm>

#include "render/base/error.h"
#include "render/base/stopwatch.h"
#include "render/codec/codec.h"
#include "render/metrics/psnr.h"
#include "render/warp/spheres_warp.h"

namespace warpscope {
namespace {

/// Least PSNR of a right picture in the server's own view: techniques reach 20 dB and more, a picture of something else does not.
constexpr double kLeastPsnrDb = 12.0;
/// Share of pixels in which backends may see different samples.
constexpr double kMostDifferent = 1e-5;

class Repeated {
 public:
  Repeated(int runs, const std::stop_token& stop) : runs_(runs), stop_(stop) {}

  /// Calls `work(false)` once to warm up, then `work(true)` `runs` times. Throws OperationCancelled between two if the token is set.
  template <class Work>
  void operator()(const Work& work) const {
    for (int run = -1; run < runs_; ++run) {
      if (stop_.stop_requested()) throw OperationCancelled();
      work(run >= 0);
    }
  }

 private:
  const int runs_;
  const std::stop_token& stop_;
};

BackendBenchmark measureServer(Marcher& marcher, const Camera& camera, const BenchmarkSettings& settings, const Repeated& repeat,
                               const std::stop_token& stop, SampleFramePtr& frame) {
  std::vector<double> march, compact, copy, server;
  repeat([&](bool counts) {
    frame.reset();  // its memory is the next one's
    SampleFrame made;
    const double ms = milliseconds([&] { made = marcher.march(camera, settings.march, stop); });
    frame = std::make_shared<const SampleFrame>(std::move(made));
    if (!counts) return;
    server.push_back(ms);
    march.push_back(frame->timings.marchMs);
    compact.push_back(frame->timings.compactMs);
    copy.push_back(frame->timings.copyMs);
  });
  BackendBenchmark result;
  result.backend = marcher.backend();
  result.samples = frame->size();
  result.rawBytes = frame->sizeBytes();
  FrameCodec codec;
  std::vector<std::byte> payload;
  SampleFrame decoded = *frame;
  std::vector<double> encode, decode;
  repeat([&](bool counts) {
    const double encodeMs = milliseconds([&] { payload = codec.encode(*frame, {}); });
    DecodeError error;
    const double decodeMs = milliseconds([&] { error = codec.decode(payload, frame->size(), decoded); });
    if (error || decoded.samples != frame->samples) throw InputError("the codec does not give back the frame: " + error.value_or("other samples"));
    if (!counts) return;
    encode.push_back(encodeMs);
    decode.push_back(decodeMs);
  });
  result.bytes = payload.size();
  result.encode = measuredOf(encode);
  result.decode = measuredOf(decode);
  result.march = measuredOf(march);
  result.compact = measuredOf(compact);
  result.copy = measuredOf(copy);
  result.server = measuredOf(server);
  return result;
}

class TechniqueRun {
 public:
  TechniqueRun(const Scene& scene, const BenchmarkSettings& settings, const std::vector<Camera>& cameras, const std::stop_token& stop)
      : scene_(scene), settings_(settings), cameras_(cameras), stop_(stop), repeat_(settings.runs, stop) {}

  /// The reference in the server's own view.
  void setReference(Marcher& marcher) { marcher.render(cameras_.front(), settings_.march.render, reference_, stop_); }

  TechniqueBenchmark measure(const WarpDescriptor& technique, const WarpResources& resources, const SampleFramePtr& frame) {
    const std::unique_ptr<Warp> warp = makeWarp(technique, resources);
    warp->setFrame(frame, settings_.warp, stop_);
    check(technique, resources, *warp, frame);

    TechniqueBenchmark result;
    result.technique = &technique;
    std::vector<double> upload, build, first;
    repeat_([&](bool counts) {
      const double buildMs = milliseconds([&] { warp->setFrame(frame, settings_.warp, stop_); });
      const double drawMs = draw(*warp, cameras_.front());
      if (!counts) return;
      const std::optional<DeviceTimings> timings = warp->deviceTimings();
      upload.push_back(timings ? timings->uploadMs : 0.0);
      build.push_back(timings ? timings->buildMs : buildMs);
      first.push_back(buildMs + drawMs);
    });
    result.upload = measuredOf(upload);
    result.build = measuredOf(build);
    result.firstPicture = measuredOf(first);
    for (const Camera& camera : cameras_) {
      std::vector<double> times;
      repeat_([&](bool counts) {
        const double drawMs = draw(*warp, camera);
        if (!counts) return;
        const std::optional<DeviceTimings> timings = warp->deviceTimings();
        times.push_back(timings ? timings->drawMs : drawMs);
      });
      result.views.push_back({measuredOf(times)});
    }
    return result;
  }

 private:
  /// As a window would have it: left on the device if there is one.
  double draw(Warp& warp, const Camera& camera) {
    return milliseconds([&] {
      if (!warp.drawForScreen(camera, settings_.warp, scene_.background, 0, stop_)) warp.draw(camera, settings_.warp, image_, stop_);
    });
  }

  void check(const WarpDescriptor& technique, const WarpResources& resources, Warp& warp, const SampleFramePtr& frame) {
    const std::string name = std::string(technique.name) + " on " + std::string(nameOf(resources.backend));
    warp.draw(cameras_.front(), settings_.warp, image_, stop_);
    const double psnrDb = psnrSrgb(image_.color, reference_, scene_.background);
    if (psnrDb < kLeastPsnrDb)
      throw InputError(name + ": its picture is wrong (" + std::to_string(psnrDb) + " dB in the server's own view); nothing was timed");
    if (resources.backend != Backend::cuda) return;
    WarpResources onCpu = resources;
    onCpu.backend = Backend::cpu;
    WarpSettings cpuSettings = settings_.warp;
    cpuSettings.knobs.set(kSphereTracingKnob, SphereTracing::automatic);
    const std::unique_ptr<Warp> truth = makeWarp(technique, onCpu);
    truth->setFrame(frame, cpuSettings, stop_);
    WarpedImage expected;
    for (size_t view = 0; view < cameras_.size(); ++view) {
      truth->draw(cameras_[view], cpuSettings, expected, stop_);
      warp.draw(cameras_[view], settings_.warp, image_, stop_);
      size_t different = 0;
      for (size_t i = 0; i < image_.samples.size(); ++i) different += image_.samples[i] != expected.samples[i];
      if (static_cast<double>(different) > kMostDifferent * static_cast<double>(image_.samples.size()))
        throw InputError(name + ": its picture of view " + std::to_string(view) + " differs from the CPU's in " + std::to_string(different) +
                         " pixels; nothing was timed");
    }
  }

  const Scene& scene_;
  const BenchmarkSettings& settings_;
  const std::vector<Camera>& cameras_;
  const std::stop_token& stop_;
  const Repeated repeat_;
  Image<glm::vec4> reference_;
  WarpedImage image_;
};

}  // namespace

size_t benchmarkSteps(const BenchmarkSettings& settings) {
  return settings.backends.size() * (1 + settings.techniques.size());
}

std::vector<BackendBenchmark> runBenchmark(const Scene& scene, const BenchmarkSettings& settings,
                                           const std::function<WarpResources(Backend)>& resourcesOf,
                                           const std::function<void(const std::string&)>& onStep, const std::stop_token& stop) {
  std::vector<Camera> cameras;
  for (const View& view : scene.views) cameras.push_back(makeCamera(scene, view, settings.width, settings.height));
  const Repeated repeat(settings.runs, stop);
  TechniqueRun run(scene, settings, cameras, stop);
  std::vector<BackendBenchmark> results;
  for (const Backend backend : settings.backends) {
    const WarpResources resources = resourcesOf(backend);
    onStep(std::string(nameOf(backend)) + ", the server's frame");
    SampleFramePtr frame;
    results.push_back(measureServer(*resources.marcher, cameras.front(), settings, repeat, stop, frame));
    run.setReference(*resources.marcher);
    for (const WarpDescriptor* technique : settings.techniques) {
      onStep(std::string(nameOf(backend)) + ", " + std::string(technique->name));
      if (backend == Backend::cuda && !technique->runsOnCuda) continue;
      results.back().techniques.push_back(run.measure(*technique, resources, frame));
    }
  }
  return results;
}

}  // namespace warpscope

// Bytes a sample, and times of encoding and decoding, for each format, heuristic and colour coding, and for several
// samples a ray. Run by hand;
// `--benchmark_filter` chooses.
// Frames: the built-in volumes (in marschner-lobb nearly every pixel has a sample), and the engine where WARPSCOPE_DATA names its folder. What comes back is checked before
// anything is timed.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <utility>

#include "app/scene/scene.h"
#include "render/codec/codec.h"
#include "render/codec/jpeg.h"
#include "render/codec/tiled/tiled_coder_cuda.h"
#include "render/cuda/devices.h"
#include "render/cuda/pinned_memory.h"
#include "render/march/marcher_cpu.h"
#include "tests/bench/bench_main.h"
#include "tests/layered_frames.h"

namespace warpscope {
namespace {

constexpr uint32_t kSide = 1024;  // pixels
constexpr CodecSettings kTiled{PayloadFormat::tiled, ColorCoding::lossless, 90};

/// What a ray's samples are: one by each heuristic, or as many parts of equal opacity, one by the only heuristic in
/// each.
struct Rays {
  std::vector<Heuristic> heuristics;
  int parts = 1;
  int segments = 0;  ///< a pixel, beside them

  auto operator<=>(const Rays&) const = default;
};

SampleFrame marchFrame(const std::string& sceneName, const Rays& rays) {
  const Scene scene = openScene(sceneName);
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  View view = scene.views.front();
  view.distance = 0.72f;  // the volume fills the picture
  MarchSettings settings;
  settings.sample.samplesPerRay = rays.parts;
  settings.sample.segments = rays.segments;
  if (rays.segments > 0) return marcher->march(makeCamera(scene, view, kSide, kSide), settings);
  return marchLayers(*marcher, makeCamera(scene, view, kSide, kSide), settings, rays.heuristics);
}

const SampleFrame& frameOf(const std::string& scene, const Rays& rays) {
  static std::map<std::pair<std::string, Rays>, SampleFrame> frames;
  const auto key = std::pair(scene, rays);
  if (!frames.contains(key)) frames.emplace(key, marchFrame(scene, rays));
  return frames.at(key);
}

SampleFrame headOf(const SampleFrame& frame) {
  SampleFrame head = frame;
  head.samples.clear();
  head.colors.clear();
  return head;
}

/// Root mean square error of 8-bit red, green and blue, each weighted by its sample's opacity.
double colorError(const SampleFrame& frame, const SampleFrame& decoded) {
  double sum = 0.0;
  for (size_t i = 0; i < frame.size(); ++i)
    for (int shift = 0; shift < 24; shift += 8) {
      const double alpha = static_cast<double>(frame.colors[i] >> 24) / 255.0;
      const double difference = alpha * (static_cast<double>(frame.colors[i] >> shift & 255) -
                                         static_cast<double>(decoded.colors[i] >> shift & 255));
      sum += difference * difference;
    }
  return std::sqrt(sum / (3.0 * static_cast<double>(frame.size())));
}

/// Who makes tiles.
enum class Place { host, device };

/// In page-locked memory, as a device's marcher leaves a frame.
SampleFrame locked(const SampleFrame& frame) {
  SampleFrame copy = frame;
  const auto lock = [](auto& values, const auto& from) {
    using Values = std::remove_reference_t<decltype(values)>;
    values = Values(from.begin(), from.end(), typename Values::allocator_type(cuda::pinnedMemory()));
  };
  lock(copy.samples, frame.samples);
  lock(copy.colors, frame.colors);
  lock(copy.segments.rays, frame.segments.rays);
  lock(copy.segments.depths, frame.segments.depths);
  lock(copy.segments.colors, frame.segments.colors);
  lock(copy.segments.normals, frame.segments.normals);
  return copy;
}

void runCodec(benchmark::State& state, const std::string& scene, const Rays& rays, const CodecSettings& settings, Place place,
              bool decoding) {
  const SampleFrame& made = frameOf(scene, rays);
  const SampleFrame frame = place == Place::device ? locked(made) : made;
  FrameCodec codec(place == Place::device ? makeCudaTiledCoder() : makeHostTiledCoder());
  const ByteVector payload = codec.encode(frame, settings);
  SampleFrame decoded = headOf(frame);
  if (const DecodeError error = codec.decode(payload, frame.size(), decoded)) throw std::runtime_error(*error);
  if (decoded.samples != frame.samples || decoded.planes != frame.planes || decoded.segments.rays != frame.segments.rays || decoded.segments.depths != frame.segments.depths)
    throw std::runtime_error("other samples came back");
  if (decoded.segments.normals != frame.segments.normals) throw std::runtime_error("other normals came back");
  const double rms = colorError(frame, decoded);
  if (settings.color == ColorCoding::lossless && (decoded.colors != frame.colors || decoded.segments.colors != frame.segments.colors))
    throw std::runtime_error("other colours came back");
  for (auto _ : state) {
    if (decoding)
      benchmark::DoNotOptimize(codec.decode(payload, frame.size(), decoded));
    else
      benchmark::DoNotOptimize(codec.encode(frame, settings).data());
  }
  state.counters["samples"] = static_cast<double>(frame.size());
  state.counters["samplesPerS"] =
      benchmark::Counter(static_cast<double>(frame.size()), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["bytesPerSample"] = static_cast<double>(payload.size()) / static_cast<double>(frame.size());
  if (!frame.segments.empty())
    state.counters["bytesPerSegment"] = static_cast<double>(codec.bytes().segments) / static_cast<double>(frame.segments.size());
  state.counters["psnrDb"] = rms > 0.0 ? 20.0 * std::log10(255.0 / rms) : INFINITY;
}

void runPicture(benchmark::State& state, const std::string& scene, int quality) {
  const SampleFrame& frame = frameOf(scene, {{Heuristic::gradient}});
  ByteVector jpeg;
  for (auto _ : state) jpeg = encodeFramePicture(frame, glm::vec3(0.0f), quality);
  state.counters["bytes"] = static_cast<double>(jpeg.size());
}

void add(const std::string& scene, const std::string& path) {
  const auto addFrameAt = [&](Place place, const Rays& rays, const std::string& frame, const CodecSettings& settings,
                              const std::string& name) {
    for (const bool decoding : {false, true})
      benchmark::RegisterBenchmark(
          (std::string(decoding ? "decode/" : "encode/") + scene + "/" + frame + "/" + name).c_str(),
          [=](benchmark::State& state) { runCodec(state, path, rays, settings, place, decoding); })
          ->Unit(benchmark::kMillisecond)
          ->MeasureProcessCPUTime()
          ->UseRealTime();
  };
  const auto addFrame = [&](const Rays& rays, const std::string& frame, const CodecSettings& settings, const std::string& name) {
    addFrameAt(Place::host, rays, frame, settings, name);
    if (settings == kTiled && cuda::whyUnavailable().empty()) addFrameAt(Place::device, rays, frame, settings, name + "-on-device");
  };
  const auto addOne = [&](Heuristic heuristic, const CodecSettings& settings, const std::string& name) {
    addFrame({{heuristic}}, std::string(nameOf(heuristic)), settings, name);
  };
  addOne(Heuristic::gradient, {PayloadFormat::raw, ColorCoding::lossless, 90}, "raw");
  for (const auto& heuristic : kHeuristics) {
    addOne(heuristic.value, {PayloadFormat::packed, ColorCoding::lossless, 90}, "lossless");
    addOne(heuristic.value, {PayloadFormat::packed, ColorCoding::jpeg, 90}, "jpeg90");
    addOne(heuristic.value, kTiled, "tiled");
  }
  for (const int quality : {75, 85, 95})
    addOne(Heuristic::gradient, {PayloadFormat::packed, ColorCoding::jpeg, quality}, "jpeg" + std::to_string(quality));
  const std::vector<Heuristic> layers{Heuristic::gradient, Heuristic::entrance, Heuristic::exit, Heuristic::peak};
  for (const size_t count : {1, 2, 4}) {
    const Rays some{{layers.begin(), layers.begin() + static_cast<std::ptrdiff_t>(count)}};
    const std::string name = "layers" + std::to_string(count);
    addFrame(some, name, {PayloadFormat::packed, ColorCoding::lossless, 90}, "lossless");
    addFrame(some, name, {PayloadFormat::packed, ColorCoding::jpeg, 90}, "jpeg90");
    addFrame(some, name, kTiled, "tiled");
  }
  for (const int parts : {2, 4, 8}) {
    const Rays cut{{Heuristic::gradient}, parts};
    const std::string name = "parts" + std::to_string(parts);
    addFrame(cut, name, {PayloadFormat::packed, ColorCoding::lossless, 90}, "lossless");
    addFrame(cut, name, {PayloadFormat::packed, ColorCoding::jpeg, 95}, "jpeg95");
    addFrame(cut, name, kTiled, "tiled");
  }
  const Rays segments{{Heuristic::gradient}, 1, 4};
  addFrame(segments, "segments4", {PayloadFormat::packed, ColorCoding::lossless, 90}, "lossless");
  addFrame(segments, "segments4", {PayloadFormat::packed, ColorCoding::jpeg, 95}, "jpeg95");
  addFrame(segments, "segments4", kTiled, "tiled");
  benchmark::RegisterBenchmark(("picture/" + scene + "/jpeg90").c_str(),
                               [=](benchmark::State& state) { runPicture(state, path, 90); })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
}

}  // namespace
}  // namespace warpscope

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  return warpscope::benchMain("codec_bench", [] {
    for (const char* builtIn : {"shells", "marschner-lobb", "vessels", "block"}) warpscope::add(builtIn, builtIn);
    if (const char* folder = std::getenv("WARPSCOPE_DATA")) {
      const std::filesystem::path engine = std::filesystem::path(folder) / "engine_256x256x128_uint8.raw";
      if (std::filesystem::exists(engine)) warpscope::add("engine", engine.string());
    }
    benchmark::RunSpecifiedBenchmarks();
  });
}

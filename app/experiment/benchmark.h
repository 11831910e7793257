// What each stage takes on each backend: march, compaction, build, pictures. Every picture is checked before it is timed.
// The protocol of Zellmann 2020, table 1: one frame from the first view, drawn in five views.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "app/experiment/measuring.h"
#include "app/scene/scene.h"
#include "render/bricks/brick_frame.h"
#include "render/warp/warp.h"

namespace warpscope {

struct BenchmarkView {
  Measured draw;
  double framesPerSecond() const { return draw.medianMs > 0.0 ? 1000.0 / draw.medianMs : 0.0; }
};

/// A frame on its way: marched, coded and decoded.
struct FrameBenchmark {
  MeasuredMarch march;
  MeasuredCoding coding;  ///< of a frame in host memory
  Measured service;       ///< camera to bytes (measureService): less than the stages together where the frame stays on its device between them
  std::vector<RankWork> ranks{};  ///< what each process did for the last of the frames, where several share the volume

  double serverMs() const { return march.march.medianMs + march.compact.medianMs + march.copy.medianMs + coding.encode.medianMs; }
};

struct TechniqueBenchmark {
  const WarpDescriptor* technique = nullptr;
  std::optional<FrameBenchmark> frame;  ///< its own, where it draws more than samples
  MeasuredFirstPicture first;
  Measured arrival;  ///< bytes to the first picture (measureArrival)
  std::vector<BenchmarkView> views;
};

struct BackendBenchmark {
  Backend backend = Backend::cpu;
  FrameBenchmark frame;  ///< of samples alone
  size_t rawBytes = 0;   ///< of the samples, 12 each
  std::vector<TechniqueBenchmark> techniques;

  size_t samples() const { return frame.march.frame->size(); }
};

struct BenchmarkSettings {
  MarchSettings march;
  WarpSettings warp;
  CodecSettings coding;
  uint32_t width = 0;
  uint32_t height = 0;
  int runs = 50;
  std::vector<Backend> backends;                    ///< cpu, cuda
  std::vector<const WarpDescriptor*> techniques;    ///< that use frames
};

/// Steps that runBenchmark() tells `onStep` of.
size_t benchmarkSteps(const BenchmarkSettings& settings);

/// `resourcesOf` gives what techniques draw on for a backend. Throws InputError if a picture is wrong: a technique's colours in the
/// server's own view have little to do with the volume's, or a CUDA device's samples are not those of the CPU. Else as marching and warping.
std::vector<BackendBenchmark> runBenchmark(const Scene& scene, const BenchmarkSettings& settings,
                                           const std::function<WarpResources(Backend)>& resourcesOf,
                                           const std::function<void(const std::string&)>& onStep, const std::stop_token& stop);

}  // namespace warpscope

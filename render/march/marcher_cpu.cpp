// Rays in tiles on all cores; depth by the chosen heuristic's fold; packing.
// See marcher_cpu.h.
#include "render/march/marcher_cpu.h"

#include <chrono>
#include <functional>
#include <mutex>
#include <vector>

#include "render/base/stopwatch.h"
#include "render/core/parallel.h"
#include "render/march/compact.h"
#include "render/march/march.h"
#include "render/march/march_setup.h"
#include "render/march/volume_source.h"

namespace warpscope {

namespace {

constexpr uint32_t kTileSide = 32;

/// What becomes of a finished ray. Behind one pointer, so that the loop over rays is compiled once a voxel type, not once a use.
using OnRay = std::function<void(size_t pixel, const Ray&, const RayColor&, const std::vector<CountingSample>&)>;

using DepthFunction = DepthResult (*)(const std::vector<CountingSample>&, float threshold);

/// Depth of a finished ray. `counting` holds every sample that counted: a second pass folds over them again.
template <class Depth>
DepthResult depthOf(const std::vector<CountingSample>& counting, float threshold) {
  ProfileFold profile;
  if constexpr (Depth::kTwoPass)
    for (const CountingSample& sample : counting) profile.add(sample);
  auto fold = Depth::start(threshold, profile);
  for (const CountingSample& sample : counting) fold.add(sample);
  return Depth::result(fold);
}

DepthFunction depthFunctionOf(Heuristic heuristic) {
  return visitHeuristic(heuristic, [](auto depth) -> DepthFunction { return depthOf<decltype(depth)>; });
}

class CpuMarcher final : public Marcher {
 public:
  explicit CpuMarcher(MarchedVolumePtr marched) : marched_(std::move(marched)) {}

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    requireMarchable(*marched_->volume, camera, settings.render);
    const SampleRule rule = sampleRuleFor(*marched_->volume, camera, settings.sample);
    SampleFrame frame = emptyFrame(camera, settings, rule);

    const auto marchStart = std::chrono::steady_clock::now();
    const size_t pixels = size_t{camera.width} * camera.height;
    denseSamples_.resize(pixels);
    denseColors_.resize(pixels);
    const DepthFunction depthOfRay = depthFunctionOf(settings.sample.heuristic);
    forEachRay(camera, settings.render, stop,
               [&](size_t pixel, const Ray& ray, const RayColor& color, const std::vector<CountingSample>& counting) {
                 const DepthResult depth = depthOfRay(counting, settings.sample.threshold);
                 const glm::vec4 premultiplied = color.premultiplied();
                 denseSamples_[pixel] = packRaySample(rule, camera, ray, depth, premultiplied.a);
                 if (depth.hasDepth) denseColors_[pixel] = ColorTables::instance().encode(premultiplied);
               });
    frame.timings.marchMs = millisecondsSince(marchStart);

    const auto compactStart = std::chrono::steady_clock::now();
    compact(denseSamples_, denseColors_, frame);
    frame.timings.compactMs = millisecondsSince(compactStart);
    return frame;
  }

  void render(const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image,
              const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    requireMarchable(*marched_->volume, camera, settings);
    image.resize(camera.width, camera.height);
    forEachRay(camera, settings, stop,
               [&](size_t pixel, const Ray&, const RayColor& color, const std::vector<CountingSample>&) {
                 image[pixel] = color.premultiplied();
               });
  }

  const VolumePtr& volume() const override { return marched_->volume; }
  Backend backend() const override { return Backend::cpu; }
  MarcherCapabilities capabilities() const override { return {}; }
  MarcherPtr twin() const override { return std::make_shared<CpuMarcher>(marched_); }

 private:
  void forEachRay(const Camera& camera, const RenderSettings& settings, const std::stop_token& stop,
                  const OnRay& onRay) {
    if (!baked_.isFor(settings.step)) baked_ = bakeTransfer(*marched_, settings.step);
    const Volume& volume = *marched_->volume;
    visitVoxelType(volume.type(), [&](auto voxelTag) {
      using Voxel = decltype(voxelTag);
      VolumeView<Voxel> view = makeVolumeView<Voxel>(*marched_);
      view.voxels = volume.voxelsAs<Voxel>();
      view.table = baked_.table.entries.data();
      view.tableAlpha = baked_.alphas.data();
      view.cells.distances = settings.skipEmpty ? baked_.emptyDistances.data() : nullptr;
      visitLight(settings, [&](const auto& light) {
        if (std::is_floating_point_v<Voxel> && volume.statistics().nonFinite > 0)
          marchTiles<VolumeSource<Voxel, true>>(view, light, camera, settings, stop, onRay);
        else
          marchTiles<VolumeSource<Voxel, false>>(view, light, camera, settings, stop, onRay);
      });
    });
  }

  template <class Source, class View, class Light>
  void marchTiles(const View& view, const Light& light, const Camera& camera, const RenderSettings& settings, const std::stop_token& stop,
                  const OnRay& onRay) const {
    const RayLimits limits = limitsOf(settings);
    parallelForTiles(camera.width, camera.height, kTileSide, stop,
                     [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
      std::vector<CountingSample> counting;
      for (uint32_t y = y0; y < y1; ++y)
        for (uint32_t x = x0; x < x1; ++x) {
          const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
          const RayInterval inside = intersectBox(reciprocalOf(ray.origin, ray.direction), marched_->volume->bounds(), 0.0f,
                                                  std::numeric_limits<float>::infinity());
          const RayPath path{ray, makeLattice(inside, settings.step)};
          Source source(view, ray, path.lattice);
          RayColor color;
          counting.clear();
          marchRay(path, 0, path.lattice.count, source, light, limits, color, [&](const CountingSample& sample) {
            counting.push_back(sample);
            return true;
          });
          onRay(size_t{y} * camera.width + x, ray, color, counting);
        }
    });
  }

  const MarchedVolumePtr marched_;

  std::mutex mutex_;  // of everything below
  BakedTransfer baked_;
  std::vector<PackedSample> denseSamples_;
  std::vector<Rgba8> denseColors_;
};

}  // namespace

MarcherPtr makeCpuMarcher(VolumePtr volume, TransferFunction transferFunction) {
  return std::make_shared<CpuMarcher>(std::make_shared<MarchedVolume>(std::move(volume), std::move(transferFunction)));
}

}  // namespace warpscope

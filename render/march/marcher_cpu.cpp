// Rays in tiles on all cores; depth by the chosen heuristic's fold; packing.
// See marcher_cpu.h.
#include "render/march/marcher_cpu.h"

#include <chrono>
#include <functional>
#include <mutex>
#include <vector>

#include "render/core/error.h"
#include "render/core/parallel.h"
#include "render/core/stopwatch.h"
#include "render/march/compact.h"
#include "render/march/march.h"
#include "render/march/volume_source.h"
#include "render/volume/macrocells.h"

namespace warpscope {

float sampleRadius(const Volume& volume, const Camera& camera, const MarchSettings& settings, float t, float cosine,
                   float opacity) {
  const float voxel = 0.5f * glm::length(volume.geometry().voxelEdges());
  const float pixel = 0.5f * pixelEdge(camera) * t * cosine;
  float radius = voxel;
  if (settings.radiusPolicy == RadiusPolicy::constant) radius = 0.5f;
  if (settings.radiusPolicy == RadiusPolicy::pixel) radius = pixel;
  if (settings.radiusPolicy == RadiusPolicy::opacity) radius = glm::mix(glm::min(pixel, voxel), voxel, opacity);
  return radius * settings.radiusScale;
}

SampleQuantization quantizationFor(const Volume& volume, const Camera& camera, const MarchSettings& settings) {
  const Box& bounds = volume.bounds();
  const float farthest = glm::length(camera.eye - bounds.center()) + 0.5f * glm::length(bounds.extent());
  return {bounds, radiusUnitFor(sampleRadius(volume, camera, settings, farthest, 1.0f, 1.0f))};
}

namespace {

constexpr uint32_t kTileSide = 32;

/// What is derived from the transfer function for one step length.
struct Baked {
  TransferTable table;
  std::vector<float> alphas;
  std::vector<uint8_t> emptyDistances;
};

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
  CpuMarcher(VolumePtr volume, TransferFunction transferFunction)
      : volume_(std::move(volume)), transferFunction_(std::move(transferFunction)), macrocells_(*volume_) {}

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    check(camera, settings);
    SampleFrame frame;
    frame.camera = camera;
    frame.quantization = quantizationFor(*volume_, camera, settings);
    frame.heuristic = settings.heuristic;
    frame.radiusPolicy = settings.radiusPolicy;

    const auto marchStart = std::chrono::steady_clock::now();
    const size_t pixels = size_t{camera.width} * camera.height;
    denseSamples_.resize(pixels);
    denseColors_.resize(pixels);
    const DepthFunction depthOfRay = depthFunctionOf(settings.heuristic);
    forEachRay(camera, settings, stop,
               [&](size_t pixel, const Ray& ray, const RayColor& color, const std::vector<CountingSample>& counting) {
                 const DepthResult depth = depthOfRay(counting, settings.threshold);
                 denseSamples_[pixel] = 0;
                 if (!depth.hasDepth) return;
                 const glm::vec4 premultiplied = color.premultiplied();
                 const float radius = sampleRadius(*volume_, camera, settings, depth.depth,
                                                   glm::dot(ray.direction, camera.forward), premultiplied.a);
                 denseSamples_[pixel] = packSample(ray.at(depth.depth), radius, frame.quantization);
                 denseColors_[pixel] = ColorTables::instance().encode(premultiplied);
               });
    frame.timings.marchMs = millisecondsSince(marchStart);

    const auto compactStart = std::chrono::steady_clock::now();
    compact(denseSamples_, denseColors_, frame);
    frame.timings.compactMs = millisecondsSince(compactStart);
    return frame;
  }

  void render(const Camera& camera, const MarchSettings& settings, Image<glm::vec4>& image,
              const std::stop_token& stop) override {
    const std::scoped_lock lock(mutex_);
    check(camera, settings);
    image.resize(camera.width, camera.height);
    forEachRay(camera, settings, stop,
               [&](size_t pixel, const Ray&, const RayColor& color, const std::vector<CountingSample>&) {
                 image[pixel] = color.premultiplied();
               });
  }

  const VolumePtr& volume() const override { return volume_; }

 private:
  void check(const Camera& camera, const MarchSettings& settings) const {
    validate(settings);
    if (!isUsable(camera))
      throw InputError("the camera is not usable: it must be finite, with a field of view inside 0 to 180 degrees and an image of 1 to " +
                       std::to_string(kMaxImageSide) + " pixels a side");
    const double longest = glm::length(glm::dvec3(volume_->bounds().extent()));
    if (longest / settings.step > kMaxSamplesPerRay)
      throw UsageError("the step is too small for a volume of this size");
  }

  const Baked& bakedFor(float step) {
    if (baked_.table.entries.empty() || baked_.table.step != step) {
      const VoxelStatistics& statistics = volume_->statistics();
      baked_.table = bakeTransferTable(transferFunction_, statistics.rangeLower, statistics.rangeUpper, step);
      baked_.alphas.resize(TransferTable::kSize);
      for (int i = 0; i < TransferTable::kSize; ++i) baked_.alphas[i] = baked_.table.entries[i].a;
      baked_.emptyDistances = macrocells_.emptyDistances(baked_.table);
    }
    return baked_;
  }

  void forEachRay(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop,
                  const OnRay& onRay) {
    const Baked& baked = bakedFor(settings.step);
    visitVoxelType(volume_->type(), [&](auto voxelTag) {
      using Voxel = decltype(voxelTag);
      VolumeView<Voxel> view;
      view.voxels = volume_->voxelsAs<Voxel>();
      view.dims = glm::ivec3(volume_->dims());
      view.scale = valueScaleOf(volume_->statistics());
      view.lower = volume_->bounds().lower;
      view.voxelsPerUnit = 1.0f / volume_->geometry().voxelEdges();
      view.table = baked.table.entries.data();
      view.tableAlpha = baked.alphas.data();
      view.emptyDistances = settings.skipEmpty ? baked.emptyDistances.data() : nullptr;
      view.cellDims = macrocells_.dims();
      view.cellEdge = macrocells_.edge();
      if (std::is_floating_point_v<Voxel> && volume_->statistics().nonFinite > 0)
        marchTiles<VolumeSource<Voxel, true>>(view, camera, settings, stop, onRay);
      else
        marchTiles<VolumeSource<Voxel, false>>(view, camera, settings, stop, onRay);
    });
  }

  template <class Source, class View>
  void marchTiles(const View& view, const Camera& camera, const MarchSettings& settings, const std::stop_token& stop,
                  const OnRay& onRay) const {
    const float stopBelow = settings.terminateEarly ? settings.contribution : 0.0f;
    parallelForTiles(camera.width, camera.height, kTileSide, stop,
                     [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
      std::vector<CountingSample> counting;
      for (uint32_t y = y0; y < y1; ++y)
        for (uint32_t x = x0; x < x1; ++x) {
          const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
          const RayInterval inside = intersectBox(reciprocalOf(ray.origin, ray.direction), volume_->bounds(), 0.0f,
                                                  std::numeric_limits<float>::infinity());
          const RayLattice lattice = makeLattice(inside, settings.step);
          Source source(view, ray, lattice);
          RayColor color;
          counting.clear();
          marchRay(lattice, 0, lattice.count, source, settings.contribution, stopBelow, color,
                   [&](const CountingSample& sample) { counting.push_back(sample); });
          onRay(size_t{y} * camera.width + x, ray, color, counting);
        }
    });
  }

  const VolumePtr volume_;
  const TransferFunction transferFunction_;
  const Macrocells macrocells_;

  std::mutex mutex_;  // of everything below
  Baked baked_;
  std::vector<PackedSample> denseSamples_;
  std::vector<Rgba8> denseColors_;
};

}  // namespace

MarcherPtr makeCpuMarcher(VolumePtr volume, TransferFunction transferFunction) {
  return std::make_shared<CpuMarcher>(std::move(volume), std::move(transferFunction));
}

}  // namespace warpscope

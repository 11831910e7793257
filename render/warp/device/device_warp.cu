// From samples to colours and pictures.
// See device_warp.h.
#include "render/warp/device/device_warp.h"

#include "render/base/error.h"

namespace warpscope {
namespace {

constexpr unsigned kPixelThreads = 256;

/// As resolveColors of warp.h.
__device__ glm::vec4 colorOf(const DeviceFrameView& frame, const ColorTables& tables, uint32_t sample) {
  return sample < frame.count ? tables.decode(frame.colors[sample]) : glm::vec4(0.0f);
}

__global__ void resolve(DeviceFrameView frame, const ColorTables* tables, DevicePixels pixels, size_t count) {
  const size_t i = size_t{blockIdx.x} * kPixelThreads + threadIdx.x;
  if (i < count) pixels.color[i] = colorOf(frame, *tables, pixels.samples[i]);
}

template <bool kBlends>
__global__ void compose(DeviceFrameView frame, const ColorTables* tables, DevicePixels pixels, size_t count, glm::vec3 background,
                        PixelMarks marks, Rgba8* picture) {
  const size_t i = size_t{blockIdx.x} * kPixelThreads + threadIdx.x;
  if (i >= count) return;
  const uint32_t sample = pixels.samples[i];
  const Rgba8 mark = marks.of(sample);
  if (mark != 0)
    picture[i] = mark;
  else
    picture[i] = tables->encodeOver(kBlends ? pixels.color[i] : colorOf(frame, *tables, sample), background);
}

}  // namespace

DeviceWarp::DeviceWarp() {
  colorTables_.upload({&ColorTables::instance(), 1}, stream_);
  stream_.synchronize();
}

void DeviceWarp::setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token&) {
  frame_ = nullptr;
  if (!frame) return;
  begin_.record(stream_);
  upload(*frame, stream_);
  middle_.record(stream_);
  build(deviceFrame_.view(), settings, stream_);
  end_.record(stream_);
  stream_.synchronize();
  timings_.uploadMs = middle_.millisecondsSince(begin_);
  timings_.buildMs = end_.millisecondsSince(middle_);
  frame_ = std::move(frame);
}

void DeviceWarp::clearPixels(const Camera& camera, const DevicePixels& pixels, cudaStream_t stream) {
  const size_t count = size_t{camera.width} * camera.height;
  static_assert(kNoSample == 0xffffffffu);
  WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(pixels.samples, 0xff, count * sizeof(uint32_t), stream));
  WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(pixels.color, 0, count * sizeof(glm::vec4), stream));
}

void DeviceWarp::rebuild(const WarpSettings& settings) {
  begin_.record(stream_);
  build(deviceFrame_.view(), settings, stream_);
  end_.record(stream_);
  stream_.synchronize();
  timings_.buildMs += end_.millisecondsSince(begin_);
}

DevicePixels DeviceWarp::pixelsFor(const Camera& camera) {
  const size_t count = size_t{camera.width} * camera.height;
  samples_.reserve(count);
  if (blends()) color_.reserve(count);
  return {samples_.data(), blends() ? color_.data() : nullptr};
}

void DeviceWarp::traceInto(const DevicePixels& pixels, const Camera& camera, const WarpSettings& settings) {
  if (prepare(settings, camera)) rebuild(settings);
  begin_.record(stream_);
  trace(deviceFrame_.view(), camera, settings, pixels, stream_);
}

void DeviceWarp::draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop) {
  requireUsable(camera);
  image.samples.resize(camera.width, camera.height, kNoSample);
  image.color.resize(camera.width, camera.height);
  if (!frame_) return;
  if (stop.stop_requested()) throw OperationCancelled();
  DevicePixels pixels = pixelsFor(camera);
  traceInto(pixels, camera, settings);
  if (!blends()) {
    color_.reserve(image.color.size());
    pixels.color = color_.data();
    resolve<<<cuda::blocksFor(image.color.size(), kPixelThreads), kPixelThreads, 0, stream_>>>(deviceFrame_.view(), colorTables_.data(), pixels,
                                                                                               image.color.size());
    WARPSCOPE_CUDA_CHECK_LAUNCH();
  }
  end_.record(stream_);
  WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(image.samples.data(), pixels.samples, image.samples.size() * sizeof(uint32_t),
                                       cudaMemcpyDeviceToHost, stream_));
  WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(image.color.data(), pixels.color, image.color.size() * sizeof(glm::vec4), cudaMemcpyDeviceToHost,
                                       stream_));
  stream_.synchronize();
  checkTrace();
  timings_.drawMs = end_.millisecondsSince(begin_);
  if (stop.stop_requested()) throw OperationCancelled();
}

DevicePicturePtr DeviceWarp::drawForScreen(const Camera& camera, const WarpSettings& settings, const glm::vec3& background,
                                           const PixelMarks& marks, const std::stop_token& stop) {
  requireUsable(camera);
  if (!frame_) return nullptr;
  if (stop.stop_requested()) throw OperationCancelled();
  std::shared_ptr<cuda::CudaPicture> picture;
  for (const auto& old : pictures_)
    if (old.use_count() == 1) picture = old;
  if (!picture) picture = pictures_.emplace_back(std::make_shared<cuda::CudaPicture>());
  picture->resize(camera.width, camera.height);
  const size_t count = size_t{camera.width} * camera.height;
  const DevicePixels pixels = pixelsFor(camera);
  traceInto(pixels, camera, settings);
  const auto kernel = blends() ? compose<true> : compose<false>;
  kernel<<<cuda::blocksFor(count, kPixelThreads), kPixelThreads, 0, stream_>>>(deviceFrame_.view(), colorTables_.data(), pixels, count, background,
                                                                               marks, picture->data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  end_.record(stream_);
  stream_.synchronize();
  checkTrace();
  timings_.drawMs = end_.millisecondsSince(begin_);
  if (stop.stop_requested()) throw OperationCancelled();
  return picture;
}

}  // namespace warpscope

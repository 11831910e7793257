// Planes and PSNR in one kernel, SSIM in one, FLIP in two; sums of each by one more. One wait for the device a picture.
// See picture_judge_cuda.h; the kernels of FLIP and SSIM: flip_device.cuh, ssim_device.cuh.
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "render/core/color.h"
#include "render/cuda/cuda_picture.h"
#include "render/metrics/display_curve.h"
#include "render/metrics/displayed.h"
#include "render/metrics/flip_device.cuh"
#include "render/metrics/picture_judge_cuda.h"
#include "render/metrics/psnr.h"
#include "render/metrics/ssim_device.cuh"

namespace warpscope {
namespace {

constexpr unsigned kJudgeThreads = 256;
constexpr int kDisplayPlanes = 6;  // linear red, green, blue, then sRGB
enum Quantity : int { kCheck, kSrgbSquares, kLinearSquares, kSimilarity, kFlip, kQuantities };

struct DisplayedPixel {
  float linear[3], srgb[3];
  float check;  ///< 0 if the pixel is finite, else NaN
};

/// Linear and premultiplied, to be shown before a background.
struct LinearPixels {
  const glm::vec4* pixels;
  glm::vec3 background;

  __device__ DisplayedPixel operator()(size_t i) const {
    const glm::vec4 pixel = pixels[i];
    const float behind = 1.0f - pixel.a, sum = pixel.r + pixel.g + pixel.b + pixel.a;
    DisplayedPixel shown;
    for (int channel = 0; channel < 3; ++channel) {
      shown.linear[channel] = saturated(pixel[channel] + behind * background[channel]);
      shown.srgb[channel] = srgbOf(shown.linear[channel]);
    }
    shown.check = sum - sum;
    return shown;
  }
};

/// As a screen shows them.
struct ScreenPixels {
  const Rgba8* pixels;

  __device__ DisplayedPixel operator()(size_t i) const {
    DisplayedPixel shown;
    for (int channel = 0; channel < 3; ++channel) {
      shown.srgb[channel] = static_cast<float>(pixels[i] >> (8 * channel) & 255) / 255.0f;
      shown.linear[channel] = linearOf(shown.srgb[channel]);
    }
    shown.check = 0.0f;
    return shown;
  }
};

/// Fills kDisplayPlanes planes; sums checks and, where there is a reference, squared differences from its planes.
template <class Pixels>
__global__ void display(Pixels pixels, size_t count, float* planes, const float* reference, double* partials, unsigned stride) {
  const size_t i = size_t{blockIdx.x} * kJudgeThreads + threadIdx.x;
  double check = 0.0, srgb = 0.0, linear = 0.0;
  if (i < count) {
    const DisplayedPixel shown = pixels(i);
    check = shown.check;
    for (int channel = 0; channel < 3; ++channel) {
      const size_t at = static_cast<size_t>(channel) * count + i;
      planes[at] = shown.linear[channel];
      planes[3 * count + at] = shown.srgb[channel];
      if (!reference) continue;
      const double light = shown.linear[channel] - reference[at], code = shown.srgb[channel] - reference[3 * count + at];
      linear += light * light;
      srgb += code * code;
    }
  }
  const double sums[3] = {blockSum(check), blockSum(srgb), blockSum(linear)};
  if (threadIdx.x == 0)
    for (int quantity = 0; quantity < 3; ++quantity) partials[size_t{static_cast<unsigned>(quantity)} * stride + blockIdx.x] = sums[quantity];
}

class CudaPictureJudge final : public DevicePictureJudge {
 public:
  CudaPictureJudge(const glm::vec3& background, float pixelsPerDegree) : background_(background) {
    requireFlipResolution(pixelsPerDegree);
    uploadTaps(flipKernels(static_cast<double>(pixelsPerDegree)));
    const auto window = ssimWindow();
    for (size_t j = 0; j < window.size(); ++j) window_.taps[j] = window[j];
    totals_.reserve(kQuantities);
  }

  void setReference(const Image<glm::vec4>& reference) override {
    width_ = height_ = 0;
    keep(upload(reference), reference.width(), reference.height());
  }
  void setReference(const DevicePicture& reference) override {
    width_ = height_ = 0;
    keep(onDevice(reference), reference.width(), reference.height());
  }
  DeviceErrors errorsOf(const Image<glm::vec4>& picture, Image<float>* map) override {
    requireSize(picture.width(), picture.height());
    return compare(upload(picture), map);
  }
  DeviceErrors errorsOf(const DevicePicture& picture, Image<float>* map) override {
    requireSize(picture.width(), picture.height());
    return compare(onDevice(picture), map);
  }

 private:
  struct HostTotals {
    double of[kQuantities];
  };

  void uploadTaps(const FlipKernels& kernels) {
    const FilterTaps* const all[7] = {&kernels.achromatic.rows, &kernels.redGreen.rows, &kernels.blueYellow[0].rows, &kernels.blueYellow[1].rows,
                                      &kernels.smooth,          &kernels.edge,          &kernels.point};
    DeviceTaps* const filters[7] = {&filters_.achromatic, &filters_.redGreen, &filters_.blueYellow[0], &filters_.blueYellow[1],
                                    &filters_.smooth,     &filters_.edge,     &filters_.point};
    std::vector<float> taps;
    for (const FilterTaps* filter : all) taps.insert(taps.end(), filter->begin(), filter->end());
    taps_.upload(taps, stream_);
    const float* next = taps_.data();
    for (size_t k = 0; k < 7; ++k) {
      *filters[k] = {next, static_cast<int>(all[k]->size() / 2)};
      filters_.largestRadius = std::max(filters_.largestRadius, filters[k]->radius);
      next += all[k]->size();
    }
    stream_.synchronize();
  }

  void requireSize(uint32_t width, uint32_t height) const {
    if (width_ == 0) throw InputError("a picture's errors need a ground truth");
    if (width != width_ || height != height_) throw InputError("a picture's errors need two images of one size");
  }

  LinearPixels upload(const Image<glm::vec4>& image) {
    uploaded_.upload({image.data(), image.size()}, stream_);
    return {uploaded_.data(), background_};
  }
  ScreenPixels onDevice(const DevicePicture& picture) {
    if (const auto* there = dynamic_cast<const cuda::CudaPicture*>(&picture)) return {there->data()};
    std::vector<Rgba8> pixels(size_t{picture.width()} * picture.height());
    picture.download(pixels);
    screen_.upload(pixels, stream_);
    return {screen_.data()};
  }

  size_t count() const { return size_t{width_} * height_; }
  dim3 tiles() const { return {cuda::blocksFor(width_, kColumnTile), cuda::blocksFor(height_, kColumnTile), 1}; }

  template <class Pixels>
  void display(const Pixels& pixels, float* planes, const float* reference) {
    const unsigned blocks = cuda::blocksFor(count(), kJudgeThreads);
    warpscope::display<<<blocks, kJudgeThreads, 0, stream_>>>(pixels, count(), planes, reference, partials_.data(), stride_);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    sumUp(kCheck, 3, blocks);
  }

  /// Adds up the partial sums of quantities from `first` on.
  void sumUp(Quantity first, unsigned quantities, unsigned blocks) {
    sumPartials<<<quantities, kSumThreads, 0, stream_>>>(partials_.data() + size_t{static_cast<unsigned>(first)} * stride_, stride_, blocks,
                                                         totals_.data() + first);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
  }

  void filterRows(const float* planes) {
    const size_t shared = 3 * (kRowPixels + 2 * static_cast<size_t>(filters_.largestRadius)) * sizeof(float);
    filterFlipRows<<<dim3(cuda::blocksFor(width_, kRowPixels), height_), kRowThreads, shared, stream_>>>(
        planes, static_cast<int>(width_), static_cast<int>(height_), filters_, rows_.data());
    WARPSCOPE_CUDA_CHECK_LAUNCH();
  }
  size_t columnBytes() const { return (kColumnTile + 2 * static_cast<size_t>(filters_.largestRadius)) * kColumnTile * sizeof(float); }

  const HostTotals& downloadTotals() {
    WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(hostTotals_.data(), totals_.data(), sizeof(HostTotals), cudaMemcpyDeviceToHost, stream_));
    stream_.synchronize();
    if (!((*hostTotals_).of[kCheck] == 0.0)) refuseNonFinite("a picture's errors");
    return *hostTotals_;
  }

  template <class Pixels>
  void keep(const Pixels& pixels, uint32_t width, uint32_t height) {
    if (width == 0 || height == 0) throw InputError("a ground truth needs at least one pixel");
    width_ = width;
    height_ = height;
    try {
      keepSized(pixels);
    } catch (...) {
      width_ = height_ = 0;  // there is none
      throw;
    }
  }
  template <class Pixels>
  void keepSized(const Pixels& pixels) {
    const dim3 grid = tiles();
    stride_ = std::max(cuda::blocksFor(count(), kJudgeThreads), 3 * grid.x * grid.y);
    partials_.reserve(size_t{kQuantities} * stride_);
    reference_.reserve(kDisplayPlanes * count());
    planes_.reserve(kDisplayPlanes * count());
    rows_.reserve(kRowPlanes * count());
    seen_.reserve(kSeenPlanes * count());
    map_.reserve(count());
    WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(totals_.data(), 0, sizeof(HostTotals), stream_));  // not all of them are summed here, and all are fetched
    display(pixels, reference_.data(), nullptr);
    filterRows(reference_.data());
    keepSeen<<<grid, dim3(kColumnTile, kColumnThreadRows), columnBytes(), stream_>>>(rows_.data(), static_cast<int>(width_), static_cast<int>(height_),
                                                                                     filters_, seen_.data());
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    downloadTotals();
  }

  template <class Pixels>
  DeviceErrors compare(const Pixels& pixels, Image<float>* map) {
    const int width = static_cast<int>(width_), height = static_cast<int>(height_);
    const dim3 grid = tiles();
    events_[0].record(stream_);
    display(pixels, planes_.data(), reference_.data());
    events_[1].record(stream_);

    const int marginX = width > 2 * kSsimRadius ? kSsimRadius : 0, marginY = height > 2 * kSsimRadius ? kSsimRadius : 0;
    sumSimilarity<<<dim3(grid.x, grid.y, 3), dim3(kSsimTile, kSsimThreadRows), 0, stream_>>>(
        planes_.data() + 3 * count(), reference_.data() + 3 * count(), width, height, marginX, marginY, window_,
        partials_.data() + size_t{kSimilarity} * stride_);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    sumUp(kSimilarity, 1, 3 * grid.x * grid.y);
    events_[2].record(stream_);

    filterRows(planes_.data());
    compareSeen<<<grid, dim3(kColumnTile, kColumnThreadRows), columnBytes(), stream_>>>(
        rows_.data(), width, height, filters_, seen_.data(), range_, map_.data(), partials_.data() + size_t{kFlip} * stride_);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    sumUp(kFlip, 1, grid.x * grid.y);
    events_[3].record(stream_);

    const HostTotals& totals = downloadTotals();
    if (map) {
      map->reshape(width_, height_);
      WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(map->data(), map_.data(), count() * sizeof(float), cudaMemcpyDeviceToHost, stream_));
      stream_.synchronize();
    }
    DeviceErrors errors;
    errors.psnrDb = psnrOfSquares(totals.of[kSrgbSquares], count());
    errors.psnrLinearDb = psnrOfSquares(totals.of[kLinearSquares], count());
    errors.ssim = totals.of[kSimilarity] / (3.0 * static_cast<double>(width - 2 * marginX) * (height - 2 * marginY));
    errors.flip = totals.of[kFlip] / static_cast<double>(count());
    errors.planesAndPsnrMs = events_[1].millisecondsSince(events_[0]);
    errors.ssimMs = events_[2].millisecondsSince(events_[1]);
    errors.flipMs = events_[3].millisecondsSince(events_[2]);
    return errors;
  }

  const glm::vec3 background_;
  const ColorRange range_ = flipColorRange();
  SsimWindow window_;
  DeviceFlipTaps filters_;
  uint32_t width_ = 0, height_ = 0;  // of the reference; 0 without one
  unsigned stride_ = 0;              // of partial sums of one quantity

  cuda::Stream stream_;
  cuda::Event events_[4];
  cuda::DeviceBuffer<float> taps_;
  cuda::DeviceBuffer<glm::vec4> uploaded_;
  cuda::DeviceBuffer<Rgba8> screen_;
  cuda::DeviceBuffer<float> reference_, planes_;  // kDisplayPlanes planes each
  cuda::DeviceBuffer<float> rows_, seen_, map_;
  cuda::DeviceBuffer<double> partials_, totals_;
  cuda::PinnedValue<HostTotals> hostTotals_;
};

}  // namespace

std::unique_ptr<DevicePictureJudge> makeCudaPictureJudge(const glm::vec3& background, float pixelsPerDegree) {
  return std::make_unique<CudaPictureJudge>(background, pixelsPerDegree);
}

}  // namespace warpscope

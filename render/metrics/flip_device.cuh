// FLIP's filters on a device: along rows into planes, then along columns, where each pixel is finished at once.
// Andersson et al. 2020; see flip.h. For .cu files.
//
// At 67 pixels per degree a pixel takes 11 + 13 + 2 * 21 + 3 * 19 = 123 taps along its row and 142 along its column. Both kernels hold what they
// filter in shared memory, and a thread filters four pixels with each tap that it loads: 265 fused multiply-adds and 331 loads a pixel. Memory: 12
// bytes in and 28 out, 28 in again, 20 of the reference, 4 out for the map: 92 bytes, most of which the second-level cache of an H200 holds.
// 1024x1024 pixels: 0.56 GFlop (10 us at 60 TFlop/s), 1.4 GB from shared memory (48 us at 30 TB/s), 96 MB (23 us at 4.2 TB/s): shared memory is
// the bound. Blocks along columns hold (32 + 2 radius) x 32 values: 39 kB at 1000 pixels per degree, which fits without asking for more.
#pragma once

#include "render/cuda/memory.h"
#include "render/metrics/device_sums.cuh"
#include "render/metrics/flip_formulas.h"
#include "render/metrics/flip_kernels.h"

namespace warpscope {

/// A filter's taps in device memory.
struct DeviceTaps {
  const float* taps = nullptr;
  int radius = 0;
};

/// Along one axis; rows and columns of the Gaussians are alike.
struct DeviceFlipTaps {
  DeviceTaps achromatic, redGreen, blueYellow[2], smooth, edge, point;
  int largestRadius = 0;
};

/// Planes after the filters along rows.
enum RowPlane : int { kAchromatic, kRedGreen, kBlueYellow0, kBlueYellow1, kSmooth, kEdge, kPoint, kRowPlanes };
inline constexpr int kSeenPlanes = 5;  ///< CIELAB with the Hunt effect, strengths of edges and of points

constexpr int kRowThreads = 128, kPerThread = 4, kRowPixels = kRowThreads * kPerThread;
constexpr int kColumnTile = 32, kColumnThreadRows = kColumnTile / kPerThread;

/// out[k] = sum over j of taps[j] * values[k * step + j * tapStep]
__device__ inline void filterFour(const DeviceTaps& filter, const float* values, int step, int tapStep, float (&out)[kPerThread]) {
  for (float& sum : out) sum = 0.0f;
  for (int j = 0; j <= 2 * filter.radius; ++j) {
    const float tap = __ldg(filter.taps + j);
#pragma unroll
    for (int k = 0; k < kPerThread; ++k) out[k] = mulAdd(tap, values[k * step + j * tapStep], out[k]);
  }
}

/// linear: three planes; out: kRowPlanes planes. Blocks: (pieces of a row, rows). Shared: 3 * (kRowPixels + 2 * largestRadius) floats.
__global__ void __launch_bounds__(kRowThreads)
filterFlipRows(const float* linear, int width, int height, DeviceFlipTaps filters, float* out) {
  extern __shared__ float shared[];
  const int radius = filters.largestRadius, begin = static_cast<int>(blockIdx.x) * kRowPixels, count = kRowPixels + 2 * radius;
  const int y = static_cast<int>(blockIdx.y);
  const size_t plane = size_t{static_cast<unsigned>(width)} * static_cast<unsigned>(height), row = size_t{static_cast<unsigned>(y)} * static_cast<unsigned>(width);
  for (int i = static_cast<int>(threadIdx.x); i < count; i += kRowThreads) {
    const size_t at = row + static_cast<unsigned>(min(max(begin + i - radius, 0), width - 1));
    const Triple<float> color = opponentOf(Triple<float>{linear[at], linear[plane + at], linear[2 * plane + at]});
    shared[i] = color.x;
    shared[count + i] = color.y;
    shared[2 * count + i] = color.z;
  }
  __syncthreads();
  const auto filterTo = [&](int channel, const DeviceTaps& filter, int to) {
    float values[kPerThread];
    filterFour(filter, shared + channel * count + static_cast<int>(threadIdx.x) + radius - filter.radius, kRowThreads, 1, values);
#pragma unroll
    for (int k = 0; k < kPerThread; ++k) {
      const int x = begin + static_cast<int>(threadIdx.x) + k * kRowThreads;
      if (x < width) out[static_cast<size_t>(to) * plane + row + static_cast<unsigned>(x)] = values[k];
    }
  };
  filterTo(0, filters.achromatic, kAchromatic);
  filterTo(0, filters.smooth, kSmooth);
  filterTo(0, filters.edge, kEdge);
  filterTo(0, filters.point, kPoint);
  filterTo(1, filters.redGreen, kRedGreen);
  filterTo(2, filters.blueYellow[0], kBlueYellow0);
  filterTo(2, filters.blueYellow[1], kBlueYellow1);
}

/// What the eye makes of a pixel.
struct SeenPixel {
  Triple<float> lab;
  float edge, point;
};

/// rows: what filterFlipRows left. Calls finish(place in the plane, SeenPixel) for each pixel. Blocks: tiles of kColumnTile x kColumnTile pixels,
/// kColumnTile x kColumnThreadRows threads. Shared: (kColumnTile + 2 * largestRadius) * kColumnTile floats. All threads must call.
template <class Finish>
__device__ inline void filterFlipColumns(const float* rows, int width, int height, const DeviceFlipTaps& filters, const Finish& finish) {
  extern __shared__ float shared[];
  const int x0 = static_cast<int>(blockIdx.x) * kColumnTile, y0 = static_cast<int>(blockIdx.y) * kColumnTile, radius = filters.largestRadius;
  const int column = static_cast<int>(threadIdx.x), firstRow = static_cast<int>(threadIdx.y) * kPerThread;
  const unsigned x = static_cast<unsigned>(min(x0 + column, width - 1));
  const size_t plane = size_t{static_cast<unsigned>(width)} * static_cast<unsigned>(height);
  const auto load = [&](int from) {
    __syncthreads();  // the plane before this one is done with
    for (int i = static_cast<int>(threadIdx.y); i < kColumnTile + 2 * radius; i += kColumnThreadRows) {
      const auto y = static_cast<unsigned>(min(max(y0 + i - radius, 0), height - 1));
      shared[i * kColumnTile + column] = rows[static_cast<size_t>(from) * plane + size_t{y} * static_cast<unsigned>(width) + x];
    }
    __syncthreads();
  };
  const auto filter = [&](const DeviceTaps& taps, float (&out)[kPerThread]) {
    filterFour(taps, shared + (firstRow + radius - taps.radius) * kColumnTile + column, kColumnTile, kColumnTile, out);
  };
  float lightness[kPerThread], redGreen[kPerThread], blueYellow[kPerThread], along[kPerThread], across[kPerThread], edge[kPerThread], point[kPerThread];
  load(kAchromatic);
  filter(filters.achromatic, lightness);
  load(kRedGreen);
  filter(filters.redGreen, redGreen);
  load(kBlueYellow0);
  filter(filters.blueYellow[0], blueYellow);
  load(kBlueYellow1);
  filter(filters.blueYellow[1], along);
#pragma unroll
  for (int k = 0; k < kPerThread; ++k) blueYellow[k] += along[k];
  load(kSmooth);
  filter(filters.edge, edge);
  filter(filters.point, point);
  load(kEdge);
  filter(filters.smooth, along);
  load(kPoint);
  filter(filters.smooth, across);
#pragma unroll
  for (int k = 0; k < kPerThread; ++k) {
    const int y = y0 + firstRow + k;
    if (x0 + column >= width || y >= height) continue;
    finish(size_t{static_cast<unsigned>(y)} * static_cast<unsigned>(width) + x,
           SeenPixel{huntLabOf(Triple<float>{lightness[k], redGreen[k], blueYellow[k]}), sqrtOf(along[k] * along[k] + edge[k] * edge[k]),
                     sqrtOf(across[k] * across[k] + point[k] * point[k])});
  }
}

/// Leaves kSeenPlanes planes of the reference.
__global__ void keepSeen(const float* rows, int width, int height, DeviceFlipTaps filters, float* seen) {
  const size_t plane = size_t{static_cast<unsigned>(width)} * static_cast<unsigned>(height);
  filterFlipColumns(rows, width, height, filters, [&](size_t i, const SeenPixel& pixel) {
    seen[i] = pixel.lab.x;
    seen[plane + i] = pixel.lab.y;
    seen[2 * plane + i] = pixel.lab.z;
    seen[3 * plane + i] = pixel.edge;
    seen[4 * plane + i] = pixel.point;
  });
}

/// Compares with those planes: the map, and its sum a block.
__global__ void compareSeen(const float* rows, int width, int height, DeviceFlipTaps filters, const float* seen, ColorRange range, float* map,
                            double* partials) {
  const size_t plane = size_t{static_cast<unsigned>(width)} * static_cast<unsigned>(height);
  double sum = 0.0;
  filterFlipColumns(rows, width, height, filters, [&](size_t i, const SeenPixel& pixel) {
    const float value = flipOf(colorDifference(range, pixel.lab, Triple<float>{seen[i], seen[plane + i], seen[2 * plane + i]}),
                               featureDifference(pixel.edge, pixel.point, seen[3 * plane + i], seen[4 * plane + i]));
    map[i] = value;
    sum += value;
  });
  sum = blockSum(sum);
  if (threadIdx.x == 0 && threadIdx.y == 0) partials[blockIdx.y * gridDim.x + blockIdx.x] = sum;
}

}  // namespace warpscope

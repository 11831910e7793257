// Piece by piece: composited and spread to planes, then through the curve.
// See displayed.h.
#include "render/metrics/displayed.h"

#include <algorithm>
#include <atomic>
#include <string>

#include "render/base/error.h"
#include "render/core/parallel.h"
#include "render/metrics/batches.h"
#include "render/metrics/display_curve.h"

namespace warpscope {
namespace {

constexpr size_t kPixelsPerPiece = 1 << 14;

ChannelPointers pointersTo(ColorPlanes* planes, size_t offset) {
  if (!planes) return {};
  return {(*planes)[0].data() + offset, (*planes)[1].data() + offset, (*planes)[2].data() + offset};
}

/// Fills the planes that are not null.
void display(const Image<glm::vec4>& image, const glm::vec3& background, std::string_view metric, ColorPlanes* linear, ColorPlanes* srgb) {
  for (ColorPlanes* colors : {linear, srgb})
    if (colors)
      for (Image<float>& plane : *colors) plane.reshape(image.width(), image.height());
  std::atomic<bool> isFinite = true;
  parallelForRanges(image.size(), kPixelsPerPiece, [&](size_t begin, size_t end) {
    if (!displayPixels(image.data() + begin, end - begin, background, pointersTo(linear, begin), pointersTo(srgb, begin))) isFinite = false;
  });
  if (!isFinite) refuseNonFinite(metric);
}

/// Composites `count` pixels; `checks` gets one number for each that is 0 if the pixel is finite, else NaN.
void composite(const glm::vec4* __restrict pixels, size_t count, const glm::vec3& background, float* __restrict red, float* __restrict green,
               float* __restrict blue, float* __restrict checks) {
  const float r = background.r, g = background.g, b = background.b;
  for (size_t i = 0; i < count; ++i) {
    const glm::vec4 pixel = pixels[i];
    const float behind = 1.0f - pixel.a;
    red[i] = saturated(pixel.r + behind * r);
    green[i] = saturated(pixel.g + behind * g);
    blue[i] = saturated(pixel.b + behind * b);
    const float sum = pixel.r + pixel.g + pixel.b + pixel.a;  // one is enough: it is not finite if a part of it is not
    checks[i] = sum - sum;
  }
}

void encode(const float* linear, size_t count, float* srgb) {
  forBatches(count, [&]<class Real>(size_t i) { storeTo(srgb + i, srgbOf(loadAs<Real>(linear + i))); });
}

}  // namespace

bool displayPixels(const glm::vec4* pixels, size_t count, const glm::vec3& background, const ChannelPointers& linear,
                   const ChannelPointers& srgb) {
  constexpr size_t kAtOnce = 512;
  alignas(64) float own[3][kAtOnce], checks[kAtOnce];
  float check = 0.0f;
  for (size_t at = 0; at < count; at += kAtOnce) {
    const size_t some = std::min(kAtOnce, count - at);
    ChannelPointers light{own[0], own[1], own[2]};
    if (linear[0]) light = {linear[0] + at, linear[1] + at, linear[2] + at};
    composite(pixels + at, some, background, light[0], light[1], light[2], checks);
    FloatBatch sums(0.0f);
    forBatches(some, [&]<class Real>(size_t i) {
      if constexpr (std::is_same_v<Real, float>)
        check += checks[i];
      else
        sums += loadAs<Real>(checks + i);
    });
    check += sumOf(sums);
    if (!srgb[0]) continue;
    for (size_t channel = 0; channel < 3; ++channel) encode(light[channel], some, srgb[channel] + at);
  }
  return check == 0.0f;
}

DisplayedPlanes displayedPlanes(const Image<glm::vec4>& image, const glm::vec3& background, std::string_view metric) {
  DisplayedPlanes planes;
  display(image, background, metric, &planes.linear, &planes.srgb);
  return planes;
}

ColorPlanes linearPlanes(const Image<glm::vec4>& image, const glm::vec3& background, std::string_view metric) {
  ColorPlanes planes;
  display(image, background, metric, &planes, nullptr);
  return planes;
}

ColorPlanes srgbPlanes(const Image<glm::vec4>& image, const glm::vec3& background, std::string_view metric) {
  ColorPlanes planes;
  display(image, background, metric, nullptr, &planes);
  return planes;
}

void linearize(ColorPlanes& planes) {
  parallelForRanges(planes[0].size(), kPixelsPerPiece, [&](size_t begin, size_t end) {
    for (Image<float>& plane : planes) {
      float* const values = plane.data() + begin;
      forBatches(end - begin, [&]<class Real>(size_t i) { storeTo(values + i, linearOf(loadAs<Real>(values + i))); });
    }
  });
}

void refuseNonFinite(std::string_view metric) { throw InputError(std::string(metric) + ": a pixel is not finite"); }

void requireOneSize(const Image<glm::vec4>& a, const Image<glm::vec4>& b, std::string_view metric) {
  if (a.width() != b.width() || a.height() != b.height() || a.empty())
    throw InputError(std::string(metric) + " needs two images of one size");
}

}  // namespace warpscope

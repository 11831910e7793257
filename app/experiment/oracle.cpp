// Lines through the frame's picture, and marches of what it knows.
// See oracle.h.
#include "app/experiment/oracle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "render/base/error.h"
#include "render/core/color.h"
#include "render/core/floating_point.h"
#include "render/core/parallel.h"
#include "render/march/own_picture.h"
#include "render/warp/segments/segment_walk.h"

namespace warpscope {
namespace {

/// Of a line through the frame's picture, in each pixel.
constexpr float kLooksPerPixel = 2.0f;

/// Sum of three channels' squares, of codes as displayed.
int differenceOf(Rgba8 a, Rgba8 b) {
  int sum = 0;
  for (int shift = 0; shift < 24; shift += 8) {
    const int difference = static_cast<int>(a >> shift & 255) - static_cast<int>(b >> shift & 255);
    sum += difference * difference;
  }
  return sum;
}

/// Calls f(x, y, ray) for each pixel of `camera`, in parallel.
template <class F>
void forEachRay(const Camera& camera, const Box& bounds, const std::stop_token& stop, const F& f) {
  const PixelGrid pixels = makePixelGrid(camera, depthRangeOf(camera, bounds).nearDepth);
  parallelForRanges(camera.height, 1, stop, [&](size_t beginRow, size_t endRow) {
    for (auto y = static_cast<uint32_t>(beginRow); y < endRow; ++y)
      for (uint32_t x = 0; x < camera.width; ++x) exceptionsExpected([&] { f(x, y, pixels.ray(x, y).ray); });
  });
  if (stop.stop_requested()) throw OperationCancelled();
}

}  // namespace

ProxyPtr wholeCopyOf(const Volume& volume, const TransferFunction& function, const std::stop_token& stop) {
  // Voxels as short as the shortest along all axes; no axis has more than the volume.
  const VolumeGeometry& geometry = volume.geometry();
  const glm::dvec3 sides = glm::dvec3(geometry.dims) * geometry.spacing / geometry.unit();
  return std::make_shared<const Proxy>(makeProxy(volume, function, static_cast<int>(std::ceil(std::max({sides.x, sides.y, sides.z}))), CopyFilter::leastSquares, stop));
}

Oracle::Oracle(SampleFramePtr frame, ProxyPtr whole, const glm::vec3& background)
    : frame_(std::move(frame)), whole_(std::move(whole)), background_(background), own_(ownPicture(*frame_)), shown_(own_.width(), own_.height()) {
  built_.build(*frame_);
  const ColorTables& tables = ColorTables::instance();
  for (size_t i = 0; i < own_.size(); ++i)
    if (own_[i] != kNoSample) shown_[i] = tables.encodeOver(tables.decode(frame_->colors[own_[i]]), background_);
}

WarpedImage Oracle::bestDots(const Camera& camera, const Image<glm::vec4>& truth, const std::stop_token& stop) const {
  const SegmentField field = built_.field();
  const ColorTables& tables = ColorTables::instance();
  const Rgba8 nothing = tables.encodeOver(glm::vec4(0.0f), background_);
  WarpedImage image;
  image.samples.resize(camera.width, camera.height, kNoSample);
  const Box& bounds = frame_->quantization.bounds;
  forEachRay(camera, bounds, stop, [&](uint32_t x, uint32_t y, const Ray& ray) {
    const RayInterval inside = partInside(bounds, ray);
    if (inside.isMiss()) return;
    const FieldLine line = makeFieldLine(field, ray, inside.tNear, inside.tFar, 0.0f);
    if (!(line.t0 < line.t1)) return;
    const Rgba8 wanted = tables.encodeOver(truth(x, y), background_);
    int least = differenceOf(nothing, wanted);
    const auto looks = static_cast<int>(kLooksPerPixel * std::max(std::abs(line.dx), std::abs(line.dy))) + 1;
    float depth = line.depthAt(line.begin);
    for (int k = 0; k < looks && least > 0; ++k) {
      const float middle = line.begin + (static_cast<float>(k) + 0.5f) / static_cast<float>(looks);
      const float next = line.depthAt(line.begin + static_cast<float>(k + 1) / static_cast<float>(looks));
      const float nearest = std::min(depth, next), farthest = std::max(depth, next);
      depth = next;
      const auto column = static_cast<uint32_t>(std::clamp(static_cast<int>(line.x0 + middle * line.dx), 0, field.width - 1));
      const auto row = static_cast<uint32_t>(std::clamp(static_cast<int>(line.y0 + middle * line.dy), 0, field.height - 1));
      const size_t pixel = size_t{row} * own_.width() + column;
      const uint32_t begin = field.first[pixel] & ~SegmentField::kEndedBit, end = field.first[pixel + 1] & ~SegmentField::kEndedBit;
      if (own_[pixel] == kNoSample || begin == end || farthest < field.spans[begin].begin || nearest > field.spans[end - 1].end) continue;
      const int difference = differenceOf(shown_[pixel], wanted);
      if (difference >= least) continue;
      least = difference;
      image.samples(x, y) = own_[pixel];
    }
  });
  resolveColors(*frame_, image.samples, image.color);
  return image;
}

WarpedImage Oracle::perfectlyWarped(const Camera& camera, const std::stop_token& stop) {
  const SegmentField field = built_.field();
  WarpedImage image;
  image.samples.resize(camera.width, camera.height, kNoSample);
  image.color.resize(camera.width, camera.height);
  fill_.visit(whole_, frame_->settings.render, camera, [&](const auto& march, const auto& /*baked*/) {
    forEachRay(camera, march.clip.bounds, stop, [&](uint32_t x, uint32_t y, const Ray& ray) {
      const RayInterval inside = partInside(march.clip.bounds, ray);
      if (inside.isMiss()) return;
      WalkedRay seen;
      float known = inside.tNear;  // from here on
      const auto marchTo = [&](float t) {
        const RayLight light = march(ray, known, t, seen.through);
        seen.pass(glm::vec3(light.color), 1.0f, static_cast<float>(1.0 - light.transmittance));
      };
      walkSegments<Between::nearest>(field, ray, inside.tNear, inside.tFar, 0.0f, [&](WalkedRay&, float from, float to, FillReason) {
        if (from > known) marchTo(from);
        known = to;
      });
      if (inside.tFar > known) marchTo(inside.tFar);
      image.color(x, y) = seen.seen();
      if (seen.through < 1.0f) image.samples(x, y) = kNotASample;
    });
  });
  return image;
}

}  // namespace warpscope

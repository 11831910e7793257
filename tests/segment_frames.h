// Frames of segments that no march made, and what rays meet in them: by brute force in double, from the frame alone.
// For tests of render/warp/segments/ and of the technique. Every step of a ray asks the pixels that it is between.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "render/core/color.h"
#include "render/march/sample_frame.h"
#include "render/warp/segments/segment_walk.h"
#include "tests/marcher_cases.h"

namespace warpscope {

/// Of the frames that are made here.
inline const Box kFrameBounds{glm::vec3(-10.0f), glm::vec3(10.0f)};
/// Where most of them are seen from.
inline const Camera kServer = lookingFrom({3.0f, 4.0f, 30.0f}, {0.5f, 0.2f, 0.0f}, 13, 9, 0.4f);

/// A frame of segments in random places, without samples.
inline SampleFrame randomFrame(const Camera& camera, uint32_t seed, int most = 4) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  SampleFrame frame;
  frame.camera = camera;
  frame.quantization = quantizationFor(camera, kFrameBounds, 1.0f);
  frame.settings.sample.segments = most;
  const DepthRange range = depthRangeOf(camera, kFrameBounds);
  const float depth = range.farDepth - range.nearDepth;
  for (size_t i = 0; i < size_t{camera.width} * camera.height; ++i) {
    const int count = static_cast<int>(unit(random) * static_cast<float>(most + 1));
    frame.segments.rays.push_back({count, unit(random) < 0.5f});
    std::vector<float> ends;
    for (int k = 0; k < 2 * count; ++k) ends.push_back(unit(random) * depth);
    std::ranges::sort(ends);
    for (int k = 0; k < count; ++k) {
      frame.segments.depths.push_back(
          {encodeDepth(ends[static_cast<size_t>(2 * k)], frame.quantization.depthStep),
           encodeDepth(ends[static_cast<size_t>(2 * k + 1)], frame.quantization.depthStep)});
      frame.segments.colors.push_back(static_cast<Rgba8>(random()));
    }
  }
  return frame;
}

/// What a ray meets.
struct MetByRay {
  glm::dvec3 color{0.0};
  double through = 1.0;
  double unknown = 0.0;  // length
};

/// What a pixel has at a forward depth: in double, from the frame alone.
struct PixelContent {
  double extinction = 0.0;
  glm::dvec3 color{0.0};
  bool isKnown = true;
};
class FrameContent {
 public:
  explicit FrameContent(const SampleFrame& frame) : frame_(frame) {
    size_t at = 0;
    for (const RaySegmentCount ray : frame.segments.rays) {
      first_.push_back(at);
      at += static_cast<size_t>(ray.count());
    }
  }
  bool isEnded(int x, int y) const { return frame_.segments.rays[pixelOf(x, y)].isEnded(); }
  /// Calls f(begin, end, extinction, straight colour) for each of the pixel's segments, by depth; extinction is along
  /// any ray.
  template <class F>
  void forEachOf(int x, int y, const F& f) const {
    const Camera& camera = frame_.camera;
    const double step = static_cast<double>(frame_.quantization.depthStep),
                 edge = static_cast<double>(pixelEdge(camera));
    const double u = (x + 0.5 - 0.5 * camera.width) * edge, v = (0.5 * camera.height - (y + 0.5)) * edge;
    const double cosine = 1.0 / std::sqrt(1.0 + u * u + v * v);
    const size_t first = first_[pixelOf(x, y)];
    for (size_t i = first; i < first + static_cast<size_t>(frame_.segments.rays[pixelOf(x, y)].count()); ++i) {
      const SegmentDepths& depths = frame_.segments.depths[i];
      const double begin = depths.begin * step, end = std::max(depths.end, depths.begin + 1) * step;
      const glm::dvec4 color(segmentColor(ColorTables::instance(), frame_.segments.colors[i]));
      const double opacity = std::min(color.a, static_cast<double>(kMostSegmentOpacity));
      f(begin, end, -std::log1p(-opacity) * cosine / (end - begin),
        color.a > 0.0 ? glm::dvec3(color) / color.a : glm::dvec3(0.0));
    }
  }
  PixelContent at(int x, int y, double depth) const {
    PixelContent content;
    double last = 0.0;
    forEachOf(x, y, [&](double begin, double end, double extinction, const glm::dvec3& color) {
      last = end;
      if (depth < begin || depth >= end) return;
      content.extinction = extinction;
      content.color = color;
    });
    content.isKnown = !isEnded(x, y) || depth < last;
    return content;
  }

 private:
  size_t pixelOf(int x, int y) const { return static_cast<size_t>(y) * frame_.camera.width + static_cast<size_t>(x); }

  const SampleFrame& frame_;
  std::vector<size_t> first_;
};

/// By many small steps along the ray, each of which asks the pixels that it is between: it is as if it were one of theirs, likely by how near that is, and, since it came between them, by
/// what of it that one would have let through.
inline MetByRay bruteForce(const SampleFrame& frame, const Ray& ray, double tNear, double tFar, bool isLinear,
                           int steps) {
  const FrameContent content(frame);
  const Camera& camera = frame.camera;
  const glm::dvec3 eye(camera.eye), right(camera.right), up(camera.up), forward(camera.forward);
  const double edge = static_cast<double>(pixelEdge(camera)), width = camera.width, height = camera.height;
  MetByRay expected;
  struct Between {
    double weight = 0.0, left = 1.0;
    PixelContent content;
  };
  std::array<Between, 4> pixels;
  glm::ivec2 cell(-1000);
  const double dt = (tFar - tNear) / steps;
  for (int i = 0; i < steps; ++i) {
    const double t = tNear + (i + 0.5) * dt;
    const glm::dvec3 p = glm::dvec3(ray.origin) + t * glm::dvec3(ray.direction) - eye;
    const double z = glm::dot(p, forward);
    const double x = 0.5 * width + glm::dot(p, right) / (z * edge), y = 0.5 * height - glm::dot(p, up) / (z * edge);
    if (!(z > 0.0) || x < 0.0 || y < 0.0 || x >= width || y >= height) {
      expected.unknown += dt;
      continue;
    }
    const double depth = z - static_cast<double>(frame.quantization.nearDepth);
    const auto set = [&](size_t k, int column, int row, double weight) {
      pixels[k].content = content.at(std::clamp(column, 0, static_cast<int>(width) - 1),
                                     std::clamp(row, 0, static_cast<int>(height) - 1), depth);
      pixels[k].weight = pixels[k].content.isKnown ? weight : 0.0;
    };
    const double shift = isLinear ? 0.5 : 0.0;
    const glm::ivec2 now(std::floor(x - shift), std::floor(y - shift));
    if (now != cell)
      for (Between& pixel : pixels) pixel = {};
    cell = now;
    const double a = isLinear ? x - shift - now.x : 0.0, b = isLinear ? y - shift - now.y : 0.0;
    for (size_t k = 0; k < 4; ++k) {
      const bool isRight = k % 2 == 1, isBelow = k >= 2;
      set(k, now.x + isRight, now.y + isBelow, (isRight ? a : 1 - a) * (isBelow ? b : 1 - b));
    }
    double known = 0.0, likely = 0.0, stopped = 0.0;
    glm::dvec3 light(0.0);
    for (Between& pixel : pixels) {
      known += pixel.weight;
      const double opacity = -std::expm1(-pixel.content.extinction * dt);
      likely += pixel.weight * pixel.left;
      stopped += pixel.weight * pixel.left * opacity;
      light += pixel.weight * pixel.left * opacity * pixel.content.color;
    }
    if (known < static_cast<double>(kLeastKnown)) {
      expected.unknown += dt;
      for (Between& pixel : pixels) pixel.left = 1.0;
      continue;
    }
    for (Between& pixel : pixels) pixel.left *= std::exp(-pixel.content.extinction * dt);
    if (!(likely > 0.0)) continue;
    expected.color += expected.through / likely * light;
    expected.through *= 1.0 - stopped / likely;
  }
  return expected;
}

/// The same without steps, where each pixel's are the same all over its frustum: every frustum is cut with the ray, and
/// its segments with what that leaves.
inline MetByRay cutByFrusta(const SampleFrame& frame, const Ray& ray, double tNear, double tFar) {
  const FrameContent content(frame);
  const Camera& camera = frame.camera;
  const glm::dvec3 offset = glm::dvec3(ray.origin) - glm::dvec3(camera.eye), direction(ray.direction);
  const auto inCamera = [&](const glm::dvec3& v) {
    return glm::dvec3(glm::dot(v, glm::dvec3(camera.right)), glm::dot(v, glm::dvec3(camera.up)),
                      glm::dot(v, glm::dvec3(camera.forward)));
  };
  const glm::dvec3 o = inCamera(offset), d = inCamera(direction);
  const double edge = static_cast<double>(pixelEdge(camera)),
               nearDepth = static_cast<double>(frame.quantization.nearDepth);
  struct Interval {
    double from, to;
    /// Leaves what has at0 + t * growth >= 0.
    void keep(double at0, double growth) {
      if (growth > 0.0)
        from = std::max(from, -at0 / growth);
      else if (growth < 0.0)
        to = std::min(to, -at0 / growth);
      else if (at0 < 0.0)
        to = from;
    }
  };
  struct Piece {
    double from, length, extinction;
    glm::dvec3 color;
  };
  std::vector<Piece> pieces;
  MetByRay met;
  met.unknown = tFar - tNear;
  for (int y = 0; y < static_cast<int>(camera.height); ++y)
    for (int x = 0; x < static_cast<int>(camera.width); ++x) {
      const double left = (x - 0.5 * camera.width) * edge, top = (0.5 * camera.height - y) * edge;
      Interval inside{tNear, tFar};
      inside.keep(o.z, d.z);
      inside.keep(o.x - left * o.z, d.x - left * d.z);
      inside.keep((left + edge) * o.z - o.x, (left + edge) * d.z - d.x);
      inside.keep(top * o.z - o.y, top * d.z - d.y);
      inside.keep(o.y - (top - edge) * o.z, d.y - (top - edge) * d.z);
      if (!(inside.from < inside.to)) continue;
      double last = 0.0;
      content.forEachOf(x, y, [&](double begin, double end, double extinction, const glm::dvec3& color) {
        last = end;
        Interval part = inside;
        part.keep(o.z - nearDepth - begin, d.z);
        part.keep(end - (o.z - nearDepth), -d.z);
        if (part.from < part.to) pieces.push_back({part.from, part.to - part.from, extinction, color});
      });
      if (content.isEnded(x, y)) inside.keep(last - (o.z - nearDepth), -d.z);
      if (inside.from < inside.to) met.unknown -= inside.to - inside.from;
    }
  std::ranges::sort(pieces, {}, &Piece::from);
  for (const Piece& piece : pieces) {
    const double opacity = -std::expm1(-piece.extinction * piece.length);
    met.color += met.through * opacity * piece.color;
    met.through *= 1.0 - opacity;
  }
  return met;
}

}  // namespace warpscope

// What becomes of rays that have ended, on the CPU: their colours, their samples, their segments, before a frame is compacted.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "render/core/pixel_grid.h"
#include "render/march/compact.h"
#include "render/march/ray_samples.h"
#include "render/march/ray_segments.h"
#include "render/march/sample_radius.h"

namespace warpscope {

/// Pixels of a picture.
struct PixelArea {
  uint32_t x = 0, y = 0, width = 0, height = 0;

  size_t count() const { return size_t{width} * height; }
};

struct RelayedTile;

/// A ray's segments as they are sent, near to far.
struct EncodedSegments {
  int found = 0;  ///< before those were left out that show nothing in 8 bits
  int count = 0;
  SegmentDepths depths[kMostMergerRoom];
  Rgba8 colors[kMostMergerRoom];
  NormalCode normals[kMostMergerRoom];
};

/// A finished ray: its colour, and its samples and segments where some are wanted.
struct FinishedRay {
  uint32_t x = 0, y = 0;
  float cosine = 1.0f;
  glm::vec4 premultiplied{0.0f};
  const RaySamples* samples = nullptr;
  const EncodedSegments* encoded = nullptr;  ///< its segments, where they have been encoded with those of rays beside it
  const SegmentList* segments = nullptr;     ///< else; null where none are wanted
  const NormalCode* normals = nullptr;       ///< of these, near to far; null where there are none
  bool isEnded = false;                     ///< hardly any light was left
  const std::vector<CountingSample>* counting = nullptr;  ///< its samples that count, where it is not said how segments are sent and a ray has one sample at most; null where nothing is visible
  RelayedTile* tile = nullptr;              ///< that it was handed on with; null where rays are marched whole

  bool hasSegments() const { return encoded != nullptr ? encoded->found > 0 : segments != nullptr && segments->size() > 0; }
};
/// What FinishedRay points at, of a ray whose segments a merger holds.
struct FinishedSegments {
  SegmentList list;
  NormalCode normals[kMostMergerRoom];

  /// `normalsByPlace`: null where none are wanted.
  template <class Merger>
  void take(const Merger& merger, const NormalCode* normalsByPlace, FinishedRay& ray) {
    list.take(merger);
    ray.segments = &list;
    if (normalsByPlace == nullptr) return;
    int count = 0;
    for (int i = merger.first(); i != Merger::kNone; i = merger.behind(i)) normals[count++] = normalsByPlace[i];
    ray.normals = normals;
  }
};
/// Behind one pointer, so that the loop over rays is compiled once a voxel type, not once a use.
using OnRay = std::function<void(const FinishedRay&)>;

/// Places for what rays of some pixels leave: for each as many as its ray may have samples, of which the first are filled (the others are 0), and segments.
struct DenseRays {
  size_t slots = 0;  ///< for each pixel
  std::vector<PackedSample> samples;
  std::vector<Rgba8> colors;
  std::vector<float> spreads;  ///< empty where nobody wants any
  DenseSegments segments;      ///< likewise

  void resize(size_t pixels, const SampleSettings& sample, bool hasNormals) {
    slots = static_cast<size_t>(sample.samplesPerRay);
    samples.resize(pixels * slots);
    colors.resize(pixels * slots);
    spreads.resize(sample.sendsSpread ? pixels * slots : 0);
    segments.resize(pixels, sample.segments, hasNormals);
  }
  /// All that the pixel has. `pixel`: its place here; `pixels` and the ray's x and y are the picture's.
  void put(size_t pixel, const FinishedRay& ray, const SampleRule& rule, const PixelGrid& pixels);
  /// What `other`, which has as many places a pixel, has of its pixel `from`.
  void take(size_t pixel, const DenseRays& other, size_t from);
};

}  // namespace warpscope

// Frames for tests of the codec, marched and made up, and what has to come back of them.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "render/codec/bytes.h"
#include "render/codec/codec.h"
#include "render/codec/payload_hash.h"
#include "render/volume/procedural.h"
#include "tests/frame_samples.h"
#include "tests/layered_frames.h"
#include "tests/marcher_cases.h"

namespace warpscope {

inline constexpr CodecSettings kRaw{PayloadFormat::raw, ColorCoding::lossless, 90};
inline constexpr CodecSettings kLossless{PayloadFormat::packed, ColorCoding::lossless, 90};
inline constexpr CodecSettings kJpeg{PayloadFormat::packed, ColorCoding::jpeg, 90};
inline constexpr CodecSettings kTiled{PayloadFormat::tiled, ColorCoding::lossless, 90};
inline constexpr CodecSettings kEveryCoding[] = {kRaw, kLossless, kJpeg, kTiled};

/// The frame without its samples: what travels beside a payload.
inline SampleFrame headOf(const SampleFrame& frame) {
  SampleFrame head;
  head.camera = frame.camera;
  head.quantization = frame.quantization;
  head.settings = frame.settings;
  head.voxelRadius = frame.voxelRadius;
  for (const SamplePlane& plane : frame.planes) head.planes.push_back({plane.name, plane.element, {}});
  return head;
}

/// Whether all is the same that a frame's vectors hold.
inline bool areSame(const SampleFrame& a, const SampleFrame& b) {
  return a.samples == b.samples && a.colors == b.colors && a.planes == b.planes && a.segments.rays == b.segments.rays && a.segments.depths == b.segments.depths &&
         a.segments.colors == b.segments.colors && a.segments.normals == b.segments.normals;
}

/// Empty if what comes back is what went in: samples, planes and alpha always, colours where the settings promise it.
inline std::string roundTrip(const SampleFrame& frame, const CodecSettings& settings) {
  FrameCodec codec;
  const ByteVector payload = codec.encode(frame, settings);
  SampleFrame decoded = headOf(frame);
  if (const DecodeError error = FrameCodec().decode(payload, frame.size(), decoded)) return *error;
  if (decoded.samples != frame.samples) return "other samples";
  if (decoded.planes != frame.planes) return "other planes";
  if (settings.format == PayloadFormat::raw || settings.color == ColorCoding::lossless)
    return decoded.colors == frame.colors ? "" : "other colours";
  if (decoded.colors.size() != frame.colors.size()) return "another number of colours";
  for (size_t i = 0; i < frame.size(); ++i)
    if (decoded.colors[i] >> 24 != frame.colors[i] >> 24) return "other opacities";
  return "";
}

inline void expectRoundTrips(const SampleFrame& frame, const std::string& what) {
  for (const CodecSettings& settings : kEveryCoding) EXPECT_EQ(roundTrip(frame, settings), "") << what;
}

inline double bytesPerSample(const SampleFrame& frame, const CodecSettings& settings) {
  return static_cast<double>(FrameCodec().encode(frame, settings).size()) / static_cast<double>(frame.size());
}

/// Values above a tenth of the range, coloured, half transparent.
inline TransferFunction translucent(const Volume& volume) {
  const double low = volume.statistics().rangeLower, high = volume.statistics().rangeUpper, span = high - low;
  return {{{low + 0.1 * span, {0.1f, 0.2f, 0.9f}, 0.0f},
           {low + 0.3 * span, {0.2f, 0.9f, 0.1f}, 0.05f},
           {high, {0.9f, 0.3f, 0.1f}, 0.6f}}};
}

/// From a corner, the volume filling most of the picture.
inline Camera cornerCamera(const Volume& volume, uint32_t width, uint32_t height) {
  const Box& bounds = volume.bounds();
  return lookingFrom(bounds.center() + 0.6f * glm::length(bounds.extent()) * glm::vec3(1.0f, 0.7f, 1.4f),
                     bounds.center(), width, height);
}

inline SampleFrame marchedLayers(const VolumePtr& volume, std::span<const Heuristic> heuristics,
                                 const MarchSettings& settings = {}, uint32_t width = 160, uint32_t height = 120) {
  return marchLayers(*makeCpuMarcher(volume, translucent(*volume)), cornerCamera(*volume, width, height), settings,
                     heuristics);
}

inline SampleFrame marched(const VolumePtr& volume, const MarchSettings& settings, uint32_t width = 160,
                           uint32_t height = 120) {
  return makeCpuMarcher(volume, translucent(*volume))->march(cornerCamera(*volume, width, height), settings);
}

inline const VolumePtr& shells() {
  static const VolumePtr volume = makeProceduralVolume("shells", {48, 48, 48});
  return volume;
}

/// A frame without samples, of a picture of something 80 around the origin.
inline SampleFrame emptyPicture(uint32_t width, uint32_t height) {
  SampleFrame frame;
  frame.camera = lookingFrom({30.0f, 20.0f, 40.0f}, {}, width, height);
  frame.quantization = {{glm::vec3(-80.0f), glm::vec3(80.0f)}, 1.0f, 0.0f, 0x1p-11f};
  return frame;
}

/// A frame of made-up samples, `count` or as many as there are pixels: `random` in every bit but those of the pixels.
inline SampleFrame garbageFrame(uint32_t width, uint32_t height, size_t count, uint32_t seed) {
  std::mt19937_64 random(seed);
  SampleFrame frame = emptyPicture(width, height);
  size_t left = size_t{width} * height;
  for (uint32_t row = 0; row < height && count > 0; ++row)
    for (uint32_t column = 0; column < width; ++column, --left) {
      if (random() % left >= count) continue;
      --count;
      frame.samples.push_back((random() & ~PackedSample{kPixelKeyMask}) | pixelKey(column, row));
      frame.colors.push_back(static_cast<Rgba8>(random()));
    }
  return frame;
}

/// Samples in the given pixels, in order.
inline SampleFrame framedPixels(uint32_t width, uint32_t height, const std::vector<uint32_t>& pixels,
                                uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> distance(43.0f, 65.0f);
  SampleFrame frame = emptyPicture(width, height);
  for (const uint32_t pixel : pixels) {
    frame.samples.push_back(sampleOnRay(frame, pixel, distance(random), 0.8f));
    frame.colors.push_back(0xff000000u | random());
  }
  return frame;
}

/// Says of a frame of framedPixels() that the samples of a pixel are those of one ray.
inline SampleFrame withLayers(SampleFrame frame, const std::vector<uint32_t>& pixels) {
  std::vector<uint8_t> layers;
  for (size_t i = 0; i < pixels.size(); ++i)
    layers.push_back(i > 0 && pixels[i] == pixels[i - 1] ? static_cast<uint8_t>(layers.back() + 1) : uint8_t{0});
  frame.planes.push_back(layerPlane(layers));
  frame.settings.sample.samplesPerRay = static_cast<int>(kSamplesPerRayRange.highest);
  return frame;
}

/// Adds a plane that is known, of made-up values.
inline SampleFrame withExtents(SampleFrame frame) {
  std::vector<float> extents;
  for (size_t i = 0; i < frame.size(); ++i) extents.push_back(0.25f * static_cast<float>(i * 7919 % 13));
  frame.planes.push_back(planeOf(kExtentPlane, PlaneElement::float32, std::span<const float>(extents)));
  return frame;
}

/// Several samples a ray and a plane besides.
inline SampleFrame smallLayeredFrame() {
  constexpr Heuristic kHeuristicsOfIt[] = {Heuristic::entrance, Heuristic::gradient, Heuristic::exit};
  return withExtents(marchedLayers(shells(), kHeuristicsOfIt, {}, 20, 16));
}

/// Decoding without a crash: an error, or `count` samples.
inline bool survives(std::span<const std::byte> payload, const SampleFrame& frame) {
  SampleFrame decoded = headOf(frame);
  const DecodeError error = FrameCodec().decode(payload, frame.size(), decoded);
  return error ? !error->empty() && decoded.samples.empty() && decoded.colors.empty()
               : decoded.samples.size() == frame.size() && decoded.colors.size() == frame.size();
}

inline ByteVector sealed(ByteVector payload) {
  sealPayload(payload);
  return payload;
}

}  // namespace warpscope

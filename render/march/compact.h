// Leaves out the places that found nothing, in parallel and in order.
// Count, scan, copy (cf. Blelloch 1990, section 1.3).
#pragma once

#include <span>

#include "render/march/sample_frame.h"

namespace warpscope {

/// Copies the samples with a radius code other than 0, and their colours, to `frame`, keeping order. Both inputs have
/// the same length: `slots` places for each ray, of which the first hold its samples near to far. The frame gets the
/// plane kLayerPlane if a ray has several.
void compact(std::span<const PackedSample> samples, std::span<const Rgba8> colors, size_t slots, SampleFrame& frame);
/// As that; the frame gets the plane kSpreadPlane of `spreads` as well, as long as the others.
void compact(std::span<const PackedSample> samples, std::span<const Rgba8> colors, std::span<const float> spreads, size_t slots, SampleFrame& frame);

/// Segments of a picture's rays as a march leaves them: places of their own for each pixel, of which the first are filled.
struct DenseSegments {
  int slots = 0;  ///< for each pixel; 0: nobody wants any
  TransferVector<RaySegmentCount> rays;
  TransferVector<SegmentDepths> depths;
  TransferVector<Rgba8> colors;
  TransferVector<NormalCode> normals;  ///< none where nobody wants any

  void resize(size_t pixels, int slotsOfPixel, bool hasNormals) {
    slots = slotsOfPixel;
    rays.resize(slots > 0 ? pixels : 0);
    depths.resize(pixels * static_cast<size_t>(slots));
    colors.resize(pixels * static_cast<size_t>(slots));
    normals.resize(hasNormals ? pixels * static_cast<size_t>(slots) : 0);
  }
};

/// Makes `segments` those that are there, pixel by pixel.
void compact(const DenseSegments& dense, FrameSegments& segments);

/// Gives `frame` the plane kLayerPlane with `layers`, one for each sample, or none if all are 0.
void setLayers(TransferVector<std::byte> layers, SampleFrame& frame);

/// Gives `frame` the plane kSpreadPlane with `spreads`, a float for each sample, rounded to 8 significant bits (within 2^-8 of each): what is less than a
/// 256th of an uncertainty is noise, and would take more bytes on the wire than all else of a sample.
void setSpreads(TransferVector<std::byte> spreads, SampleFrame& frame);

}  // namespace warpscope

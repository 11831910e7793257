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

/// Gives `frame` the plane kLayerPlane with `layers`, one for each sample, or none if all are 0.
void setLayers(TransferVector<std::byte> layers, SampleFrame& frame);

/// Gives `frame` the plane kSpreadPlane with `spreads`, a float for each sample, rounded to 8 significant bits (within 2^-8 of each): what is less than a
/// 256th of an uncertainty is noise, and would take more bytes on the wire than all else of a sample.
void setSpreads(TransferVector<std::byte> spreads, SampleFrame& frame);

}  // namespace warpscope

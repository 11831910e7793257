// Where samples lie along the rays of their pixels, as one integer each: what encoder and decoder compute alike from the frame's camera.
// Both compute it with the functions that the marcher itself uses (PixelGrid::ray, intersectBox, makeLattice, encodeDepth), so that a
// marched sample is reproduced exactly, and any other nearly; what differs is sent beside.
//
// Relied on: additions, multiplications, divisions, square roots and fused multiply-adds of float and double round as IEEE 754 says, and
// the compiler neither fuses nor reorders them (-ffp-contract=off; no -ffast-math). Then every machine computes the same bits. A decoder
// for which that does not hold reproduces other samples, and finds out by their hash.
#pragma once

#include <cstdint>
#include <span>

#include "render/march/frame_places.h"
#include "render/core/sample.h"
#include "render/core/transfer_vector.h"

namespace warpscope {

/// Neighbouring samples are predicted from one another in fine units that do not depend on where a ray enters the volume.
struct FineScale {
  const int32_t* origins;  ///< of places, in fine units
  int bits;

  int32_t fineOf(size_t k, int32_t place) const { return fineOfPlace(place, origins[k], bits); }
  int32_t placeOf(size_t k, int32_t fine) const { return placeOfFine(fine, origins[k], bits); }
};

/// What samples in pixels share, and the samples' rays; as arrays, for the compiler to work on several at once.
class PixelPaths {
 public:
  /// Rays of the pixels (columns[k], rows[k]). Any camera and quantisation will do; unusable ones give useless places.
  void aim(const SampleFrame& frame, Placement placement, std::span<const uint32_t> columns, std::span<const uint32_t> rows);

  /// Goes on with some of the rays: `kept` are their numbers, which rise.
  void narrow(std::span<const uint32_t> kept);

  /// The integers whose places are nearest to the samples.
  void locate(std::span<const PackedSample> samples, std::span<int32_t> places) const;
  /// The same of borders, from their depth codes.
  void locateBorders(std::span<const uint32_t> depthCodes, std::span<int32_t> places) const;

  /// The depth codes of the places. Any integer will do.
  void place(std::span<const int32_t> places, std::span<uint32_t> depthCodes) const;

  size_t size() const { return origin_.size(); }
  FineScale fineScale() const { return {origin_.data(), fineBits_}; }

 private:
  Placement placement_ = Placement::depth;
  float step_ = 1.0f, depthStep_ = 1.0f;
  int fineBits_ = 0;
  TransferVector<float> cosine_;
  TransferVector<float> t0_, length_;  // the ray's lattice
  TransferVector<int32_t> count_;
  TransferVector<int32_t> origin_;  // of places, in fine units
};

}  // namespace warpscope

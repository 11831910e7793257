// Codes of all rays' first segments, then of all rays' second ones.
// See segment_batch_encoder.h.
#include "render/march/segment_batch_encoder.h"

#include <algorithm>
#include <bit>

#include "render/core/color_lanes.h"
#include "render/march/segment_encoder.h"

namespace warpscope {

template <>
struct SegmentCoding<FloatBatch> {
  using Whole = IntBatch;

  static Whole encodeChannel(const ColorTables& tables, const FloatBatch& linear) { return ColorLanes::encodeChannel(tables, linear); }
  static FloatBatch decodeChannel(const ColorTables& tables, const Whole& code) { return ColorLanes::decodeChannel(tables, code); }
};

void encodeSegments(const SegmentBatchMerger& merger, int rays, const float* cosines, const SampleQuantization& quantization, const NormalCode* const* normals,
                    EncodedSegments* const* encoded) {
  alignas(64) float cosineOf[kBatchLanes] = {};
  int most = 0;
  for (int lane = 0; lane < rays; ++lane) {
    cosineOf[lane] = cosines[lane];
    most = std::max(most, merger.size(lane));
    encoded[lane]->found = merger.size(lane);
    encoded[lane]->count = 0;
  }
  BasicSegmentEncoder<FloatBatch> encoder(ColorTables::instance(), quantization, FloatBatch::load_aligned(cosineOf), normals != nullptr);
  const FloatBatch sizes = merger.sizes();
  for (int i = 0; i < most; ++i) {
    const FloatBatch number(static_cast<float>(i));
    BasicSegmentEncoder<FloatBatch>::Codes codes;
    const auto isSent = encoder.encode(merger.lanes(i), number + 1.0f >= sizes, codes) && number < sizes;
    alignas(64) int32_t begins[kBatchLanes], ends[kBatchLanes], colors[kBatchLanes];
    codes.begin.store_aligned(begins);
    codes.end.store_aligned(ends);
    codes.color.store_aligned(colors);
    for (uint32_t lanes = bitsOf(isSent); lanes != 0; lanes &= lanes - 1) {
      const int lane = std::countr_zero(lanes);
      EncodedSegments& own = *encoded[lane];
      own.depths[own.count] = {static_cast<uint32_t>(begins[lane]), static_cast<uint32_t>(ends[lane])};
      own.colors[own.count] = static_cast<Rgba8>(colors[lane]);
      if (normals != nullptr) own.normals[own.count] = normals[lane][i];
      ++own.count;
    }
  }
}

}  // namespace warpscope

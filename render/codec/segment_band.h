// The segments of some rows of a frame's picture as bytes: the unit that is packed and unpacked at once.
// Layers: the first segment of every pixel, then the second ... The layout is described in segment_coding.h.
#pragma once

#include <span>
#include <vector>

#include "render/codec/band_layers.h"
#include "render/codec/band_layout.h"
#include "render/codec/codec.h"
#include "render/codec/color_plane_coder.h"
#include "render/codec/pixel_path.h"
#include "render/codec/tokens.h"

namespace warpscope {

/// One band at a time; keeps its buffers.
class SegmentBand {
 public:
  /// Of a segment, beside its tokens.
  static constexpr size_t kMostBits = 4 * kMostTokenBits;

  /// Segments [begin, ...) of the frame are the band's, ray after ray.
  void pack(const SampleFrame& frame, Placement placement, const MaskShape& shape, size_t begin, const CodecSettings& settings, ByteVector& out);

  /// Fills what the band's rays have of segments: a value for each of its pixels.
  bool takeRays(ByteReader& reader, const MaskShape& shape, std::span<RaySegmentCount> rays);
  /// Fills the band's part of the frame's segments, for which there is room. Rays are known.
  DecodeError unpack(ByteReader& reader, Placement placement, const MaskShape& shape, ColorCoding coding, size_t begin, SampleFrame& frame);

 private:
  int startRays(std::span<const RaySegmentCount> rays);
  void lay(const MaskShape& shape, std::span<const RaySegmentCount> rays, int layer);
  void putDepths(size_t size, int layer, BitWriter& bits);
  void takeDepths(size_t size, int layer, BitReader& bits);
  template <class F>
  void forEachPlace(size_t size, int layer, const F& f);
  void appendNormals(size_t size, ByteVector& out);
  CodecSettings lossyColors(const CodecSettings& settings, int layers);
  bool takeNormals(ByteReader& reader, size_t size);

  BandLayout layout_;
  PixelPaths paths_;
  ColorPlaneCoder colorCoder_;
  TransferVector<uint8_t> bytes_, mask_, beginTokens_, endTokens_, beginRests_, endRests_, bitBytes_;
  TransferVector<uint32_t> starts_;   // of each pixel's segments among the band's
  TransferVector<uint32_t> pixelOf_;  // of the band, for each segment of the layer
  TransferVector<uint32_t> codes_, endCodes_, likely_;
  TransferVector<int32_t> places_, endPlaces_, fine_;
  std::vector<int32_t> ends_;    // of the pixel's segment of the layer in front
  std::vector<float> through_;  // of each pixel, what the layers in front let pass
  TransferVector<Rgba8> colors_;
  TransferVector<NormalCode> normals_;
};

}  // namespace warpscope

// What the format says of a frame before its tiles.
// See tiled_codec.h.
#include "render/codec/tiled/tiled_codec.h"

#include "render/codec/packed_codec.h"
#include "render/codec/plane_coding.h"
#include "render/codec/tiled/tiled_coder.h"
#include "render/codec/tiled/tiled_samples.h"

namespace warpscope {
namespace {

class TiledCodec final : public Codec {
 public:
  explicit TiledCodec(TiledCoderPtr coder) : coder_(std::move(coder)) {}

  void beginToEncode(const SampleFrame& frame) override {
    placement_ = placementOf(frame);
    coder_->beginToAppendSamples(frame, placement_);
  }
  void encode(const SampleFrame& frame, const CodecSettings&, ByteVector& payload) override {
    appendLittle(payload, static_cast<uint8_t>(placement_));
    coder_->appendSamples(payload, frame, placement_);
  }

  void beginToDecode(std::span<const std::byte> bytes, size_t count, const SampleFrame& frame) override {
    ByteReader reader(bytes);
    Placement placement;
    if (!takePlacement(reader, frame, placement)) coder_->beginToTakeSamples(reader, placement, count, frame);
  }
  DecodeError decode(std::span<const std::byte> bytes, size_t count, SampleFrame& frame) override {
    ByteReader reader(bytes);
    Placement placement;
    if (DecodeError error = takePlacement(reader, frame, placement)) return error;
    return coder_->takeSamples(reader, placement, count, frame);
  }

  void encodePlane(const SampleFrame& frame, const SamplePlane& plane, ByteVector& payload) override {
    if (!isImplied(plane)) appendPlane(payload, plane, frame.layers());
  }

  DecodeError decodePlane(std::span<const std::byte> bytes, const SampleFrame& frame, SamplePlane& plane) override {
    if (!isImplied(plane)) return takePlane(bytes, frame.size(), frame.layers(), plane);
    if (!bytes.empty()) return "the plane \"" + plane.name + "\" of a tiled payload has bytes";
    return std::nullopt;
  }

 private:
  static DecodeError takePlacement(ByteReader& reader, const SampleFrame& frame, Placement& placement) {
    placement = static_cast<Placement>(reader.take<uint8_t>());
    if (static_cast<uint32_t>(placement) >= kPlacements) return "the tiled payload places samples in an unknown way";
    if (placement != Placement::depth && !hasLattice(frame)) return "the tiled payload needs a usable camera and step";
    return std::nullopt;
  }

  const TiledCoderPtr coder_;
  Placement placement_ = Placement::depth;  // of the frame that was begun
};

}  // namespace

uint64_t mostTiledBytes(const SampleFrame& frame, uint64_t count, const CodecSettings&) { return sizeof(Placement) + mostTiledSampleBytes(frame, count); }

uint64_t mostTiledPlaneBytes(const SamplePlane& plane, uint64_t count) { return mostPackedPlaneBytes(plane, count); }

std::unique_ptr<Codec> makeTiledCodec(const TiledCoderPtr& coder) { return std::make_unique<TiledCodec>(coder); }

}  // namespace warpscope

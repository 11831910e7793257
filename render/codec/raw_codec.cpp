// 12 bytes a sample, and what its planes take.
// See raw_codec.h.
#include "render/codec/raw_codec.h"

#include "render/codec/bytes.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

constexpr size_t kSampleBytes = 12;
constexpr size_t kGrain = 1 << 15;  // samples

class RawCodec final : public Codec {
 public:
  void encode(const SampleFrame& frame, const CodecSettings&, ByteVector& payload) override {
    const size_t start = payload.size();
    payload.resize(start + frame.size() * kSampleBytes);
    parallelForRanges(frame.size(), kGrain, [&](size_t begin, size_t end) {
      std::byte* place = payload.data() + start + begin * kSampleBytes;
      for (size_t i = begin; i < end; ++i, place += kSampleBytes) {
        storeLittle(place, frame.samples[i]);
        storeLittle(place + 8, frame.colors[i]);
      }
    });
  }

  DecodeError decode(std::span<const std::byte> bytes, size_t count, SampleFrame& frame) override {
    if (bytes.size() != count * kSampleBytes)
      return "a raw payload of " + std::to_string(count) + " samples must have " + std::to_string(count * kSampleBytes) +
             " bytes behind its head, not " + std::to_string(bytes.size());
    frame.samples.resize(count);
    frame.colors.resize(count);
    parallelForRanges(count, kGrain, [&](size_t begin, size_t end) {
      const std::byte* place = bytes.data() + begin * kSampleBytes;
      for (size_t i = begin; i < end; ++i, place += kSampleBytes) {
        frame.samples[i] = loadLittle<PackedSample>(place);
        frame.colors[i] = loadLittle<Rgba8>(place + 8);
      }
    });
    return std::nullopt;
  }

  void encodePlane(const SampleFrame&, const SamplePlane& plane, ByteVector& payload) override {
    payload.insert(payload.end(), plane.values.begin(), plane.values.end());
  }

  DecodeError decodePlane(std::span<const std::byte> bytes, const SampleFrame& frame, SamplePlane& plane) override {
    const size_t wanted = frame.size() * bytesOf(plane.element);
    if (bytes.size() != wanted)
      return "the plane \"" + plane.name + "\" of " + std::to_string(frame.size()) + " samples must have " + std::to_string(wanted) +
             " bytes in a raw payload, not " + std::to_string(bytes.size());
    plane.values.assign(bytes.begin(), bytes.end());
    return std::nullopt;
  }
};

}  // namespace

uint64_t mostRawBytes(const SampleFrame&, uint64_t count, const CodecSettings&) { return count * kSampleBytes; }

uint64_t mostRawPlaneBytes(const SamplePlane& plane, uint64_t count) {
  const uint64_t known = bytesOf(plane.element);
  return count * (known > 0 ? known : kMostElementBytes);
}

std::unique_ptr<Codec> makeRawCodec(const TiledCoderPtr&) { return std::make_unique<RawCodec>(); }

}  // namespace warpscope

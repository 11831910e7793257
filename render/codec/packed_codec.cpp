// Bands.
// See packed_codec.h.
#include "render/codec/packed_codec.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "render/base/shared_pool.h"
#include "render/codec/bytes.h"
#include "render/codec/packed_band.h"
#include "render/codec/picture_bands.h"
#include "render/codec/plane_coding.h"
#include "render/codec/zstd_section.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

/// How a frame is cut. One without samples has no bands.
class Bands {
 public:
  Bands(const Camera& camera, Placement placement, size_t samples) : placement_(placement) {
    if (samples > 0) bands_ = PictureBands(camera);
  }

  size_t count() const { return bands_.count(); }
  BandRows rows(size_t band) const { return {placement_, bands_.firstRow(band), bands_.rowCount(band)}; }

 private:
  Placement placement_;
  PictureBands bands_;
};

class PackedCodec final : public Codec {
 public:
  /// What others have of the workspaces comes back; what nobody uses may have grown for this one.
  ~PackedCodec() override { packers_->forget(); }

  void encode(const SampleFrame& frame, const CodecSettings& settings, ByteVector& payload) override {
    const Placement placement = placementOf(frame);
    const Bands bands(frame.camera, placement, frame.size());
    cut(frame, bands);

    packed_.resize(bands.count());
    parallelForRanges(bands.count(), 1, [&](size_t begin, size_t end) {
      const auto packer = packers_->take();
      for (size_t band = begin; band < end; ++band) {
        packed_[band].clear();
        packer->pack(frame, bands.rows(band), band > 0 ? ends_[band - 1] : 0, ends_[band], settings, packed_[band]);
      }
    });

    appendLittle(payload, static_cast<uint8_t>(placement));
    appendLittle(payload, static_cast<uint8_t>(settings.color));
    size_t total = 0;
    for (size_t band = 0; band < bands.count(); ++band) {
      appendLittle(payload, static_cast<uint32_t>(packed_[band].size()));
      appendLittle(payload, static_cast<uint32_t>(ends_[band] - (band > 0 ? ends_[band - 1] : 0)));
      total += packed_[band].size();
    }
    payload.reserve(payload.size() + total);
    for (const ByteVector& band : packed_) payload.insert(payload.end(), band.begin(), band.end());
  }

  DecodeError decode(std::span<const std::byte> bytes, size_t count, SampleFrame& frame) override {
    ByteReader reader(bytes);
    const auto placement = static_cast<Placement>(reader.take<uint8_t>());
    const auto coding = static_cast<ColorCoding>(reader.take<uint8_t>());
    if (reader.ranOut()) return "the packed payload ends before its head does";
    if (static_cast<uint32_t>(placement) >= kPlacements) return "the packed payload places samples in an unknown way";
    if (nameOf(coding) == "?") return "the packed payload has colours in an unknown way";
    if (placement != Placement::depth && !hasLattice(frame)) return "the packed payload needs a usable camera and step";
    const Bands bands(frame.camera, placement, count);
    if (reader.left() < 8 * bands.count()) return "the packed payload ends within its list of bands";
    ByteReader list(reader.take(8 * bands.count()));
    starts_.assign(1, 0);
    ends_.clear();
    for (size_t band = 0; band < bands.count(); ++band) {
      const size_t length = list.take<uint32_t>(), samples = list.take<uint32_t>();
      if (samples > mostSamples(frame.camera, bands.rows(band))) return "a band of the packed payload has too many samples";
      if (length < kLeastBandBytes) return "a band of the packed payload is shorter than its head";
      starts_.push_back(starts_.back() + length);
      ends_.push_back((ends_.empty() ? 0 : ends_.back()) + samples);
    }
    if (starts_.back() != reader.left()) return "the bands of the packed payload have other lengths than its list says";
    if ((ends_.empty() ? 0 : ends_.back()) != count) return "the bands of the packed payload have other numbers of samples than the frame";

    frame.samples.resize(count);
    frame.colors.resize(count);
    std::span<uint8_t> layers;
    for (SamplePlane& plane : frame.planes) {
      if (!isImplied(plane)) continue;
      plane.values.resize(count);
      layers = {reinterpret_cast<uint8_t*>(plane.values.data()), count};
    }
    const std::span<const std::byte> all = reader.take(reader.left());
    std::mutex mutex;
    DecodeError firstError;
    size_t firstErrorBand = bands.count();
    parallelForRanges(bands.count(), 1, [&](size_t begin, size_t end) {
      const auto packer = packers_->take();
      for (size_t band = begin; band < end; ++band) {
        const size_t from = band > 0 ? ends_[band - 1] : 0, samples = ends_[band] - from;
        DecodeError error = packer->unpack(all.subspan(starts_[band], starts_[band + 1] - starts_[band]), frame, bands.rows(band), coding,
                                                    {frame.samples.data() + from, samples}, {frame.colors.data() + from, samples},
                                                    layers.empty() ? layers : layers.subspan(from, samples));
        if (!error) continue;
        const std::scoped_lock lock(mutex);
        if (band >= firstErrorBand) continue;
        firstErrorBand = band;
        firstError = std::move(error);
      }
    });
    return firstError;
  }

  void encodePlane(const SampleFrame& frame, const SamplePlane& plane, ByteVector& payload) override {
    if (!isImplied(plane)) appendPlane(payload, plane, frame.layers());
  }

  DecodeError decodePlane(std::span<const std::byte> bytes, const SampleFrame& frame, SamplePlane& plane) override {
    if (!isImplied(plane)) return takePlane(bytes, frame.size(), frame.layers(), plane);
    if (!bytes.empty()) return "the plane \"" + plane.name + "\" of a packed payload has bytes";
    return std::nullopt;
  }

 private:
  static size_t mostSamples(const Camera& camera, const BandRows& rows) {
    return kMaxLayers * size_t{rows.count} * camera.width;
  }

  /// Sets ends_ to the end of each band's samples.
  void cut(const SampleFrame& frame, const Bands& bands) {
    ends_.clear();
    auto at = frame.samples.begin();
    for (size_t band = 0; band < bands.count(); ++band) {
      const BandRows rows = bands.rows(band);
      at = std::partition_point(at, frame.samples.end(), [&](PackedSample sample) { return rowOf(sample) < rows.first + rows.count; });
      ends_.push_back(static_cast<size_t>(at - frame.samples.begin()));
    }
  }

  std::vector<size_t> starts_, ends_;  // of bands: first byte; sample after the last
  std::vector<ByteVector> packed_;
  const std::shared_ptr<SharedPool<BandPacker>> packers_ = SharedPool<BandPacker>::ofProcess();
};

}  // namespace

uint64_t mostPackedBytes(const SampleFrame& frame, uint64_t count, const CodecSettings& settings) {
  const Bands bands(frame.camera, Placement::depth, count);
  constexpr uint64_t kHead = 2, kListed = 8;
  const uint64_t layers = std::min<uint64_t>(mostLayers(frame), count);
  // All samples count for the first band, of whose fellows there is left what they take without any.
  uint64_t bytes = kHead;
  for (size_t band = 0; band < bands.count(); ++band)
    bytes += kListed + BandPacker::mostBytes(frame.camera.width, bands.rows(band).count, band == 0 ? count : 0, layers,
                                             settings.color);
  return bytes;
}

uint64_t mostPackedPlaneBytes(const SamplePlane& plane, uint64_t count) {
  if (isImplied(plane)) return 0;
  const uint64_t known = bytesOf(plane.element), valueBytes = known > 0 ? known : kMostElementBytes;
  const uint64_t pieces = (count + kPlanePiece - 1) / kPlanePiece;
  return pieces * (sizeof(uint32_t) + valueBytes * kSectionHeadBytes) + count * valueBytes;
}

std::unique_ptr<Codec> makePackedCodec(const TiledCoderPtr&) { return std::make_unique<PackedCodec>(); }

}  // namespace warpscope

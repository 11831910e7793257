// Which pixel each sample belongs to, what integers along rays are best, bands.
// See packed_codec.h.
#include "render/codec/packed_codec.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>

#include "render/codec/bytes.h"
#include "render/codec/packed_band.h"
#include "render/codec/plane_coding.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

constexpr uint32_t kBandPixels = 1 << 17;
constexpr size_t kLooseBandSamples = 1 << 16;
constexpr size_t kGrain = 1 << 14;  // samples
constexpr size_t kProbes = 256;

/// How a frame is cut: whole rows, a multiple of a JPEG block's; or, where placement is loose, any samples.
class Bands {
 public:
  Bands(const Camera& camera, Placement placement, size_t samples) : placement_(placement) {
    if (placement == Placement::loose) {
      count_ = (samples + kLooseBandSamples - 1) / kLooseBandSamples;
      return;
    }
    height_ = camera.height;
    rows_ = std::max(kBandPixels / camera.width / 16, 1u) * 16;
    count_ = (height_ + rows_ - 1) / rows_;
  }

  size_t count() const { return count_; }
  bool isLoose() const { return placement_ == Placement::loose; }
  BandRows rows(size_t band) const {
    if (isLoose()) return {};
    const auto first = static_cast<uint32_t>(band) * rows_;
    return {placement_, first, std::min(rows_, height_ - first)};
  }

 private:
  Placement placement_;
  uint32_t height_ = 0, rows_ = 0;
  size_t count_ = 0;
};

bool canPlace(const SampleFrame& frame) { return isUsable(frame.camera) && frame.settings.render.step > 0.0f && std::isfinite(frame.settings.render.step); }

/// The pixel of each sample's centre, kNoSample where that is not in the picture.
void findPixels(const SampleFrame& frame, TransferVector<uint32_t>& pixels) {
  pixels.resize(frame.size());
  parallelForRanges(frame.size(), kGrain, [&](size_t begin, size_t end) {
    const Camera camera = frame.camera;
    const Box bounds = frame.quantization.bounds;
    const auto width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
    const auto columns = static_cast<int32_t>(camera.width);
    const PackedSample* samples = frame.samples.data();
    uint32_t* out = pixels.data();
    for (size_t i = begin; i < end; ++i) {
      const Projection seen = project(camera, unpackPosition(samples[i], bounds));
      const bool isInside = (seen.forwardDepth > 0.0f) & (seen.pixel.x >= 0.0f) & (seen.pixel.y >= 0.0f) & (seen.pixel.x < width) &
                            (seen.pixel.y < height);
      const auto x = static_cast<int32_t>(isInside ? seen.pixel.x : 0.0f), y = static_cast<int32_t>(isInside ? seen.pixel.y : 0.0f);
      out[i] = isInside ? static_cast<uint32_t>(y * columns + x) : kNoSample;
    }
  });
}

/// As isAscending(), in parallel; `pixels` is not empty.
bool areAllAscending(std::span<const uint32_t> pixels) {
  std::atomic<bool> areAll = isAscending(pixels.last(1));
  parallelForRanges(pixels.size() - 1, kGrain, [&](size_t begin, size_t end) {
    if (!isAscending(pixels.subspan(begin, end + 1 - begin))) areAll = false;
  });
  return areAll;
}

/// Gives all samples of a ray the pixel of its farthest, whose direction quantisation changes least. `layers` is of all samples.
void shareAlongRays(std::span<const uint8_t> layers, TransferVector<uint32_t>& pixels) {
  parallelForRanges(pixels.size(), kGrain, [&](size_t begin, size_t end) {
    const uint8_t* const layer = layers.data();
    uint32_t* const pixel = pixels.data();
    const size_t count = pixels.size();
    // Rays belong to the range that they begin in.
    while (begin < end && layer[begin] != 0) ++begin;
    for (size_t first = begin; first < end;) {
      size_t past = first + 1;
      while (past < count && layer[past] != 0) ++past;
      const uint32_t farthest = pixel[past - 1];
      for (size_t i = first; i < past; ++i) pixel[i] = farthest;
      first = past;
    }
  });
}

/// Whether every ray has a pixel, of its own and after the one before; in parallel. Without layers every sample is a ray.
bool areRaysAscending(std::span<const uint32_t> pixels, std::span<const uint8_t> layers) {
  if (layers.empty()) return areAllAscending(pixels);
  std::atomic<bool> areAll = pixels.front() != kNoSample;
  parallelForRanges(pixels.size() - 1, kGrain, [&](size_t begin, size_t end) {
    // Words alone, in locals: many at once.
    const uint32_t* const pixel = pixels.data();
    const uint8_t* const layer = layers.data();
    uint32_t faults = 0;
    for (size_t i = begin; i < end; ++i) {
      const uint32_t begins = layer[i + 1] == 0 ? 1u : 0u, falls = pixel[i] >= pixel[i + 1] ? 1u : 0u;
      faults |= (pixel[i + 1] == kNoSample ? 1u : 0u) | (begins & falls);
    }
    if (faults != 0) areAll = false;
  });
  return areAll;
}

/// Takes rays that are not in the order of pixels out of their pixels. Without layers every sample is a ray, and several may share a pixel.
/// Returns how many samples are left.
size_t keepOrdered(TransferVector<uint32_t>& pixels, std::span<const uint8_t> layers) {
  size_t kept = 0, inPixel = 0;
  uint32_t last = 0;
  for (size_t first = 0, past = 0; first < pixels.size(); first = past) {
    past = endOfRay(layers, first);
    const uint32_t pixel = pixels[first];
    if (pixel == kNoSample) continue;
    // One that lies far ahead would put all that follow out of order: then it is the one that does not belong.
    const bool isAhead = past < pixels.size() && pixels[past] < pixel && pixels[past] >= last;
    const bool isFull = pixel == last && inPixel > 0 && (!layers.empty() || inPixel == kMaxLayers);
    if (pixel < last || isAhead || isFull) {
      std::fill(pixels.begin() + static_cast<ptrdiff_t>(first), pixels.begin() + static_cast<ptrdiff_t>(past), kNoSample);
      continue;
    }
    inPixel = (pixel == last ? inPixel : 0) + (past - first);
    last = pixel;
    kept += past - first;
  }
  return kept;
}

class PackedCodec final : public Codec {
 public:
  void encode(const SampleFrame& frame, const CodecSettings& settings, std::vector<std::byte>& payload) override {
    Placement placement = Placement::loose;
    if (canPlace(frame) && frame.size() > 0) {
      const std::span<const uint8_t> layers = frame.layers();
      findPixels(frame, pixels_);
      if (!layers.empty()) shareAlongRays(layers, pixels_);
      isInOrder_ = areRaysAscending(pixels_, layers);  // as marchers give them
      if (isInOrder_ || 2 * keepOrdered(pixels_, layers) > frame.size()) placement = bestPlacement(frame);
    }
    Bands bands(frame.camera, placement, frame.size());
    if (!cut(frame, bands)) {
      placement = Placement::loose;
      bands = Bands(frame.camera, placement, frame.size());
      cut(frame, bands);
    }

    packed_.resize(bands.count());
    parallelForRanges(bands.count(), 1, [&](size_t begin, size_t end) {
      for (size_t band = begin; band < end; ++band) {
        packed_[band].clear();
        packers_.local().pack(frame, bands.rows(band), band > 0 ? ends_[band - 1] : 0, ends_[band], pixels_, settings, packed_[band]);
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
    for (const std::vector<std::byte>& band : packed_) payload.insert(payload.end(), band.begin(), band.end());
  }

  DecodeError decode(std::span<const std::byte> bytes, size_t count, SampleFrame& frame) override {
    ByteReader reader(bytes);
    const auto placement = static_cast<Placement>(reader.take<uint8_t>());
    const auto coding = static_cast<ColorCoding>(reader.take<uint8_t>());
    if (reader.ranOut()) return "the packed payload ends before its head does";
    if (static_cast<uint32_t>(placement) >= kPlacements) return "the packed payload places samples in an unknown way";
    if (nameOf(coding) == "?") return "the packed payload has colours in an unknown way";
    if (placement != Placement::loose && !canPlace(frame)) return "the packed payload needs a usable camera and step";
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
      for (size_t band = begin; band < end; ++band) {
        const size_t from = band > 0 ? ends_[band - 1] : 0, samples = ends_[band] - from;
        DecodeError error = packers_.local().unpack(all.subspan(starts_[band], starts_[band + 1] - starts_[band]), frame, bands.rows(band), coding,
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

  void encodePlane(const SampleFrame& frame, const SamplePlane& plane, std::vector<std::byte>& payload) override {
    if (!isImplied(plane)) appendPlane(payload, plane, frame.layers());
  }

  DecodeError decodePlane(std::span<const std::byte> bytes, const SampleFrame& frame, SamplePlane& plane) override {
    if (!isImplied(plane)) return takePlane(bytes, frame.size(), frame.layers(), plane);
    if (!bytes.empty()) return "the plane \"" + plane.name + "\" of a packed payload has bytes";
    return std::nullopt;
  }

 private:
  /// What the bands say already.
  static bool isImplied(const SamplePlane& plane) { return plane.name == kLayerPlane && plane.element == PlaneElement::uint8; }

  static size_t mostSamples(const Camera& camera, const BandRows& rows) {
    return kMaxBandStrays + kMaxLayers * size_t{rows.count} * (rows.count > 0 ? camera.width : 0);
  }

  /// Steps, if a look at some samples says that they lie on them.
  Placement bestPlacement(const SampleFrame& frame) const {
    TransferVector<uint32_t> columns, rows;
    TransferVector<PackedSample> samples;
    const size_t stride = std::max(frame.size() / kProbes, size_t{1});
    for (size_t i = 0; i < frame.size(); i += stride) {
      if (pixels_[i] == kNoSample) continue;
      columns.push_back(pixels_[i] % frame.camera.width);
      rows.push_back(pixels_[i] / frame.camera.width);
      samples.push_back(frame.samples[i] & kPositionMask);
    }
    TransferVector<int32_t> places(samples.size());
    TransferVector<PackedSample> positions(samples.size());
    TransferVector<float> depths(samples.size());
    for (const Placement placement : {Placement::steps, Placement::halfSteps}) {
      PixelPaths paths;
      paths.aim(frame, placement, columns, rows);
      paths.locate(samples, places);
      paths.place(places, positions, depths);
      size_t exact = 0;
      for (size_t k = 0; k < samples.size(); ++k) exact += positions[k] == samples[k];
      if (exact * 8 >= samples.size() * 7) return placement;
    }
    return Placement::axis;
  }

  /// Sets ends_ to the end of each band's samples. False if a band would have too many strays.
  bool cut(const SampleFrame& frame, const Bands& bands) {
    ends_.assign(bands.count(), frame.size());
    const size_t whole = bands.count();
    for (size_t band = 0; band + 1 < whole; ++band) {
      if (bands.rows(band).count == 0) {
        ends_[band] = (band + 1) * kLooseBandSamples;
        continue;
      }
      const BandRows rows = bands.rows(band);
      const uint32_t endPixel = (rows.first + rows.count) * frame.camera.width;
      size_t at = band > 0 ? ends_[band - 1] : 0;
      if (isInOrder_) {
        ends_[band] = static_cast<size_t>(std::lower_bound(pixels_.begin() + static_cast<ptrdiff_t>(at), pixels_.end(), endPixel) - pixels_.begin());
        continue;
      }
      // Strays stay with the sample before them.
      while (at < frame.size() && (pixels_[at] == kNoSample || pixels_[at] < endPixel)) ++at;
      ends_[band] = at;
    }
    if (isInOrder_ || bands.isLoose()) return true;
    for (size_t band = 0; band < whole; ++band) {
      const auto begin = pixels_.begin() + static_cast<ptrdiff_t>(band > 0 ? ends_[band - 1] : 0);
      if (static_cast<size_t>(std::count(begin, pixels_.begin() + static_cast<ptrdiff_t>(ends_[band]), kNoSample)) > kMaxBandStrays) return false;
    }
    return true;
  }

  TransferVector<uint32_t> pixels_;           // of each sample
  bool isInOrder_ = false;                    // pixels_: areRaysAscending()
  std::vector<size_t> starts_, ends_;         // of bands: first byte; sample after the last
  std::vector<std::vector<std::byte>> packed_;
  tbb::enumerable_thread_specific<BandPacker> packers_;
};

}  // namespace

std::unique_ptr<Codec> makePackedCodec() { return std::make_unique<PackedCodec>(); }

}  // namespace warpscope

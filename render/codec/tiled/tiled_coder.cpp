// On the host, and on a device as long as it works.
// See tiled_coder.h.
#include "render/codec/tiled/tiled_coder.h"

#include <utility>

#include "render/base/error.h"
#include "render/codec/tiled/tiled_samples.h"
#include "render/codec/tiled/tiled_segments.h"

namespace warpscope {
namespace {

class HostTiledCoder final : public TiledCoder {
 public:
  void appendSamples(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) override { samples_->append(out, frame, placement); }
  DecodeError takeSamples(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) override { return samples_->take(reader, placement, count, frame); }
  void appendSegments(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) override { segments_->append(out, frame, placement); }
  DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) override {
    return segments_->take(reader, placement, hasNormals, most, frame);
  }
  void forget() override {
    samples_ = std::make_unique<TiledSamples>();
    segments_ = std::make_unique<TiledSegments>();
  }

 private:
  std::unique_ptr<TiledSamples> samples_ = std::make_unique<TiledSamples>();
  std::unique_ptr<TiledSegments> segments_ = std::make_unique<TiledSegments>();
};

class FallbackTiledCoder final : public TiledCoder {
 public:
  FallbackTiledCoder(const std::function<TiledCoderPtr()>& makeFirst, std::function<void(const std::string& reason)> onFallback) : onFallback_(std::move(onFallback)) {
    try {
      coder_ = makeFirst();
    } catch (const DeviceError& error) {
      leave(error);
    }
  }

  void appendSamples(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) override {
    append(out, [&] { coder_->appendSamples(out, frame, placement); });
  }
  DecodeError takeSamples(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) override {
    return take(reader, [&] { return coder_->takeSamples(reader, placement, count, frame); });
  }
  void appendSegments(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) override {
    append(out, [&] { coder_->appendSegments(out, frame, placement); });
  }
  DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) override {
    return take(reader, [&] { return coder_->takeSegments(reader, placement, hasNormals, most, frame); });
  }
  void forget() override { coder_->forget(); }

 private:
  template <class Call>
  void append(std::vector<std::byte>& out, const Call& call) {
    const size_t size = out.size();
    try {
      call();
    } catch (const DeviceError& error) {
      leave(error);
      out.resize(size);
      call();
    }
  }
  template <class Call>
  DecodeError take(ByteReader& reader, const Call& call) {
    const ByteReader before = reader;
    try {
      return call();
    } catch (const DeviceError& error) {
      leave(error);
      reader = before;
      return call();
    }
  }

  void leave(const DeviceError& error) {
    coder_ = makeHostTiledCoder();  // which throws none of these
    if (onFallback_) std::exchange(onFallback_, nullptr)(error.what());
  }

  TiledCoderPtr coder_;
  std::function<void(const std::string& reason)> onFallback_;
};

}  // namespace

TiledCoderPtr makeHostTiledCoder() { return std::make_shared<HostTiledCoder>(); }

TiledCoderPtr makeFallbackTiledCoder(const std::function<TiledCoderPtr()>& makeFirst, std::function<void(const std::string& reason)> onFallback) {
  return std::make_shared<FallbackTiledCoder>(makeFirst, std::move(onFallback));
}

}  // namespace warpscope

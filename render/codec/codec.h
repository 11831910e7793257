// A frame's samples and colours as bytes and back. What describes the frame (its camera, quantisation, settings, number of samples) travels
// beside them and is known to whoever decodes: it may be relied on, so that it need not be said twice.
// The layout is ours. A payload is: format (1 byte), a hash of all that follows (8 bytes), for each plane of the frame, in order, its length
// (4 bytes) and the format's bytes of it, likewise the segments and the copy of the volume where the settings ask for them, then the format's bytes of samples and colours. Numbers are
// little-endian.
//
// Decoding takes nothing on trust. It never throws on bad input, refuses sizes before it allocates for them, and answers with the same
// samples that were encoded, bit for bit, or with a sentence. The hash finds accidents; it does not keep out who means harm, whom every
// further check is for.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/base/range.h"
#include "render/base/recent_need.h"
#include "render/codec/bytes.h"
#include "render/march/sample_frame.h"

namespace warpscope {

enum class PayloadFormat : uint8_t {
  raw,     ///< 12 bytes a sample
  packed,  ///< what the camera implies left out, the rest predicted and compressed: packed_codec.h
  tiled,   ///< the same in tiles that a GPU codes as well, lossless: tiled_codec.h
};

enum class ColorCoding : uint8_t {
  lossless,
  jpeg,  ///< red, green and blue in their pixels' places; alpha without loss
};

inline constexpr std::array<NamedValue<PayloadFormat>, 3> kPayloadFormats{{
    {PayloadFormat::raw, "raw", "12 bytes a sample"},
    {PayloadFormat::packed, "packed", "depths predicted along the camera's rays, compressed"},
    {PayloadFormat::tiled, "tiled", "the same in tiles, without loss, which a GPU codes in a millisecond"},
}};

inline constexpr std::array<NamedValue<ColorCoding>, 2> kColorCodings{{
    {ColorCoding::lossless, "lossless", "colours as they are"},
    {ColorCoding::jpeg, "jpeg", "colours as a JPEG image, opacity as it is"},
}};

inline std::string_view nameOf(PayloadFormat format) { return nameOf(kPayloadFormats, format); }
inline std::string_view nameOf(ColorCoding coding) { return nameOf(kColorCodings, coding); }

struct CodecSettings {
  PayloadFormat format = PayloadFormat::packed;
  ColorCoding color = ColorCoding::jpeg;  ///< for `packed`
  int jpegQuality = 95;                   ///< kJpegQualityRange; 95 keeps FLIP below 0.01 on real volumes

  bool operator==(const CodecSettings&) const = default;
};

inline constexpr Range kJpegQualityRange{1, 100};

/// Throws UsageError naming the setting that is out of range.
void validate(const CodecSettings& settings);

/// Where a frame is once it is decoded.
enum class DecodedPlace {
  host,    ///< in host memory, whatever else
  device,  ///< on the device that decodes, alone (SampleFrame::isAway), where one does, and nothing of the frame is the host's to decode
};

/// What whoever decodes accepts. Besides the frame it holds some tens of megabytes a thread, whatever a payload says.
struct DecodeLimits {
  size_t maxSamples = size_t{1} << 26;  ///< of 12 bytes each in memory, and what planes that are known take
  size_t maxBytes = size_t{1} << 30;    ///< of a payload
  size_t maxSegments = kMostFrameSegments;  ///< of 14 bytes each in memory
  DecodedPlace place = DecodedPlace::host;
};

/// Nothing if all went well; else a sentence that says what was wrong.
using DecodeError = std::optional<std::string>;

/// The most bytes that a payload has: for `count` samples of the picture, the settings and the planes of `frame`, whatever the samples
/// are. Planes of elements that are not known count as kMostElementBytes a value. FrameCodec makes none that is longer; noise takes all of it
/// raw, more than half packed without loss, and more than 0.4 as JPEG or tiled.
uint64_t mostPayloadBytes(const SampleFrame& frame, uint64_t count, const CodecSettings& settings);
inline constexpr uint64_t kMostElementBytes = 8;

/// One format. Keeps its buffers; used from one thread at a time, and works on all cores itself. The bytes do not depend on their number.
class Codec {
 public:
  virtual ~Codec() = default;

  /// Come before encode() and decode() of the same, and what else there is of the frame between them: who can begins meanwhile. What is given must stay until then, or
  /// until TiledCoder::endBegun(), which whoever calls these calls in the end.
  virtual void beginToEncode(const SampleFrame&) {}
  virtual void beginToDecode(std::span<const std::byte>, size_t /*count*/, const SampleFrame&) {}

  /// Appends the frame's samples and colours to `payload`.
  virtual void encode(const SampleFrame& frame, const CodecSettings& settings, ByteVector& payload) = 0;
  /// Appends one of the frame's planes.
  virtual void encodePlane(const SampleFrame& frame, const SamplePlane& plane, ByteVector& payload) = 0;

  /// Fills samples and colours of `frame`, whose other members are set, with `count` of them, and planes that follow from those. `count` is
  /// within the limits.
  virtual DecodeError decode(std::span<const std::byte> bytes, size_t count, SampleFrame& frame) = 0;
  /// Fills the values of one of the frame's planes, which is known (isKnown), after its samples; kLayerPlane before the others.
  virtual DecodeError decodePlane(std::span<const std::byte> bytes, const SampleFrame& frame, SamplePlane& plane) = 0;
};

class TiledCoder;
using TiledCoderPtr = std::shared_ptr<TiledCoder>;

struct CodecDescriptor {
  PayloadFormat format;
  std::unique_ptr<Codec> (*make)(const TiledCoderPtr& coder);
  /// The most bytes that encode(), and encodePlane() of one of its planes, append for `count` samples of such a frame.
  uint64_t (*mostBytes)(const SampleFrame& frame, uint64_t count, const CodecSettings& settings);
  uint64_t (*mostPlaneBytes)(const SamplePlane& plane, uint64_t count);
  bool ordersSamples = false;  ///< decodes none that are not in pixels of the picture and in their order
  bool isForDevices = false;  ///< takes frames that are away (SampleFrame::isAway) as they are, and may leave them so
};

/// Every format.
std::span<const CodecDescriptor> codecRegistry();

/// What of a payload is for whom.
struct FrameBytes {
  size_t samples = 0;   ///< of samples, their colours and planes, and the payload's head
  size_t segments = 0;  ///< of what lies along the rays (frame_segments.h)
  size_t proxy = 0;     ///< of the copy of the volume, which comes with one frame for all

  /// Without that copy.
  size_t ofFrame() const { return samples + segments; }
  size_t all() const { return ofFrame() + proxy; }
  bool operator==(const FrameBytes&) const = default;
};

class SegmentCoder;
/// Frames to payloads and back, in every format. Keeps buffers from frame to frame, as many as the largest of the last frames needed
/// (recent_need.h); one thread at a time.
class FrameCodec {
 public:
  /// Makes tiles of frames on the host.
  FrameCodec();
  /// Makes them with another coder (tiled_coder.h), which nobody else uses at the same time.
  explicit FrameCodec(TiledCoderPtr coder);
  ~FrameCodec();
  FrameCodec(FrameCodec&&) noexcept;
  FrameCodec& operator=(FrameCodec&&) noexcept;

  /// Throws UsageError for settings out of range, InputError for a frame whose samples, colours and planes differ in number, whose planes
  /// are not what sample_planes.h says, or whose rays are not in pixels of the camera's picture, each in one of its own, in their order. What is away
  /// is its marcher's, and taken as it is. Throws DeviceError where that is lost with its device.
  ByteVector encode(const SampleFrame& frame, const CodecSettings& settings);

  /// Fills samples, colours and planes of `frame`, whose other members, the names and elements of its planes among them, say what they were
  /// encoded with; there must be `count` of each. What comes back is in order as encode() wants it. Planes that are not known (isKnown) are
  /// left out. After an error the frame has no samples.
  DecodeError decode(std::span<const std::byte> payload, size_t count, SampleFrame& frame, const DecodeLimits& limits = {});

  /// Whether frames gain by being left on their device (Marcher::marchToCode): encode() takes them all the same where they do not.
  static bool codesOnDevices(const CodecSettings& settings);

  /// Of the payload that was encoded last, or decoded without an error.
  const FrameBytes& bytes() const { return bytes_; }

 private:
  Codec& codecFor(PayloadFormat format);
  /// What was worked at: gives buffers back that recent frames do not need.
  void noteNeed(const SampleFrame& frame, size_t count);
  /// What a payload has behind its head, but for planes, which are in planeBytes_.
  struct Parts {
    std::span<const std::byte> segments, proxy, samples;
    FrameBytes bytes;  ///< but for samples
  };
  /// Leaves planes out that are not known.
  DecodeError takeParts(ByteReader& reader, SampleFrame& frame, Parts& parts);
  /// May leave the frame half filled.
  DecodeError decodeParts(PayloadFormat format, std::span<const std::byte> payload, size_t count, SampleFrame& frame, const DecodeLimits& limits);

  TiledCoderPtr coder_;
  std::vector<std::unique_ptr<Codec>> codecs_;  // in the registry's order, made when first asked for
  std::unique_ptr<SegmentCoder> segments_;
  std::vector<std::span<const std::byte>> planeBytes_;  // of the frame at work
  FrameBytes bytes_;                            // of the last payload: the next will be about as long
  RecentNeed need_;                             // of pixels and samples
};

}  // namespace warpscope

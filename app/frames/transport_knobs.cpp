// Rows of the transport's knobs.
// See transport_knobs.h.
#include "app/frames/transport_knobs.h"

namespace warpscope {
namespace {

constexpr auto kFormatChoices = choicesOf(kPayloadFormats);
constexpr auto kColorChoices = choicesOf(kColorCodings);
constexpr CodecSettings kCodec;

bool always(const TransportSettings&) { return true; }
bool isPacked(const TransportSettings& s) { return s.codec.format == PayloadFormat::packed; }
bool isJpeg(const TransportSettings& s) { return isPacked(s) && s.codec.color == ColorCoding::jpeg; }

}  // namespace

constinit const Knob kFormatKnob{
    .key = "codec",
    .option = "--codec",
    .label = "Format",
    .noun = "codec",
    .help = "How samples travel",
    .type = KnobType::choice,
    .owner = KnobOwner::transport,
    .stale = KnobStage::encode,
    .defaultValue = static_cast<double>(kCodec.format),
    .choices = kFormatChoices,
};

constinit const Knob kColorKnob{
    .key = "color",
    .option = "--color",
    .label = "Colours",
    .noun = "colour coding",
    .help = "How their colours travel, packed",
    .type = KnobType::choice,
    .owner = KnobOwner::transport,
    .stale = KnobStage::encode,
    .defaultValue = static_cast<double>(kCodec.color),
    .choices = kColorChoices,
};

constinit const Knob kQualityKnob{
    .key = "quality",
    .option = "--quality",
    .label = "Quality",
    .noun = "quality of JPEG",
    .help = "Of JPEG: 95 can hardly be told from the original (FLIP below 0.01)",
    .type = KnobType::whole,
    .owner = KnobOwner::transport,
    .stale = KnobStage::encode,
    .range = kJpegQualityRange,
    .track = kJpegQualityRange,
    .defaultValue = kCodec.jpegQuality,
};

constinit const Knob kDepthKnob{
    .key = "depth",
    .option = "--depth",
    .label = "In flight",
    .noun = "number of requests under way",
    .help = "Requests under way at a time: one is best against delay on narrow links, more fill long and wide ones",
    .type = KnobType::whole,
    .owner = KnobOwner::transport,
    .stale = KnobStage::nothing,
    .range = kDepthRange,
    .track = kDepthRange,
    .defaultValue = kDefaultDepth,
};

constinit const Knob kFrameKibKnob{
    .key = "frameKib",
    .option = "--frame-kib",
    .label = "Frame limit",
    .noun = "KiB of a frame",
    .help = "KiB that a frame may take while the camera moves, such as what the link carries in a second by the frames wanted: its image has fewer pixels then, and grows to all at rest; "
            "without a window it stays; 0: whatever it takes",
    .unit = " KiB",
    .type = KnobType::whole,
    .owner = KnobOwner::transport,
    .stale = KnobStage::march,
    .range = kFrameKibRange,
    .track = {0.0, 8192.0},
    .scale = KnobScale::logarithmic,
    .defaultValue = 0.0,
};

constinit const Knob kServerMsKnob{
    .key = "serverMs",
    .option = "--server-ms",
    .label = "While moving",
    .noun = "milliseconds of a frame while the camera moves",
    .help = "Milliseconds that a frame may take the server while the camera moves: it marches coarser then, and without shadows and light if need be, and refines at rest; 0: always in full",
    .unit = " ms",
    .type = KnobType::whole,
    .owner = KnobOwner::transport,
    .stale = KnobStage::march,
    .range = kServerMsRange,
    .track = {0.0, 500.0},
    .defaultValue = 0.0,
};

constinit const Knob kServerLoadKnob{
    .key = "serverLoad",
    .option = "--server-load",
    .label = "Others' load",
    .noun = "load of the server's processor",
    .help = "Share of the server's processor that others take, simulated: all that it does for a frame takes so much longer; 0: it is this client's alone",
    .unit = " %",
    .type = KnobType::whole,
    .owner = KnobOwner::transport,
    .stale = KnobStage::nothing,
    .range = kServerLoadRange,
    .track = kServerLoadRange,
    .defaultValue = 0.0,
};

std::span<const KnobRow<ServerWishes>> serverKnobs() {
  static const KnobRow<ServerWishes> kRows[] = {
      {&kServerMsKnob, [](const ServerWishes& s) { return static_cast<double>(s.movingMs); },
       [](ServerWishes& s, double value) { s.movingMs = static_cast<int>(value); }},
      {&kServerLoadKnob, [](const ServerWishes& s) { return static_cast<double>(s.loadPercent); },
       [](ServerWishes& s, double value) { s.loadPercent = static_cast<int>(value); }},
  };
  return kRows;
}

std::span<const TransportKnob> transportKnobs() {
  static const TransportKnob kRows[] = {
      {{&kFormatKnob, [](const TransportSettings& s) { return static_cast<double>(s.codec.format); },
        [](TransportSettings& s, double value) { s.codec.format = static_cast<PayloadFormat>(value); }},
       always},
      {{&kColorKnob, [](const TransportSettings& s) { return static_cast<double>(s.codec.color); },
        [](TransportSettings& s, double value) { s.codec.color = static_cast<ColorCoding>(value); }},
       isPacked},
      {{&kQualityKnob, [](const TransportSettings& s) { return double(s.codec.jpegQuality); },
        [](TransportSettings& s, double value) { s.codec.jpegQuality = static_cast<int>(value); }},
       isJpeg},
      {{&kDepthKnob, [](const TransportSettings& s) { return double(s.depth); },
        [](TransportSettings& s, double value) { s.depth = static_cast<int>(value); }},
       always},
      {{&kFrameKibKnob, [](const TransportSettings& s) { return double(s.frameKib); },
        [](TransportSettings& s, double value) { s.frameKib = static_cast<int>(value); }},
       always},
      {{&kServerMsKnob, [](const TransportSettings& s) { return static_cast<double>(s.server.movingMs); },
        [](TransportSettings& s, double value) { s.server.movingMs = static_cast<int>(value); }},
       always,
       true},
      {{&kServerLoadKnob, [](const TransportSettings& s) { return static_cast<double>(s.server.loadPercent); },
        [](TransportSettings& s, double value) { s.server.loadPercent = static_cast<int>(value); }},
       always,
       true},
  };
  return kRows;
}

}  // namespace warpscope

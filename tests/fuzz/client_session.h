// What client_session_fuzz asks a server for, by the first byte of its input, and what its seeds answer.
// Small, so that what a client takes beyond it shows.
#pragma once

#include "app/frames/wire_fields.h"

namespace warpscope {

struct AskedInFuzzing {
  net::Wanted wanted = net::Wanted::samples;
  Camera camera;
  MarchSettings settings;
  CodecSettings codec;

  /// Bit 0: the payload's hash is put right before it is decoded. The other bits are what is asked for.
  explicit AskedInFuzzing(uint8_t choices) {
    camera.eye = {3.0f, 2.0f, 40.0f};
    camera.width = 64;
    camera.height = 48;
    settings.sample.samplesPerRay = choices & 2 ? 3 : 1;
    if (choices & 4) wanted = net::Wanted::picture;
    codec.format = choices & 8 ? PayloadFormat::raw : choices & 32 ? PayloadFormat::tiled : PayloadFormat::packed;
    codec.color = choices & 16 ? ColorCoding::jpeg : ColorCoding::lossless;
  }

  net::FrameRequest request(uint64_t id) const {
    net::FrameRequest asked;
    asked.id = id;
    asked.wanted = wanted;
    asked.camera = toFields(camera);
    asked.settings = toFields(settings);
    asked.codec = toFields(codec);
    return asked;
  }
};

}  // namespace warpscope

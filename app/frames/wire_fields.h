// Between what the program computes with and what the network carries: cameras, settings, scenes, frames.
// What comes from the network is checked here: every function that reads throws InputError for what could not be used.
#pragma once

#include <cstddef>
#include <vector>

#include "app/scene/scene.h"
#include "net/messages.h"
#include "render/codec/codec.h"
#include "render/core/image.h"
#include "render/march/sample_frame.h"

namespace warpscope {

net::CameraFields toFields(const Camera& camera);
/// Every setting of a march, by the names that JSON has for them.
net::SettingFields toFields(const MarchSettings& settings);
net::CodecFields toFields(const CodecSettings& settings);
net::SceneFields toFields(const Scene& scene);

Camera cameraFrom(const net::CameraFields& fields);
/// What is not among the fields keeps its default; names and values that this program does not know are refused.
MarchSettings marchFrom(const net::SettingFields& fields);
CodecSettings codecFrom(const net::CodecFields& fields);
/// A scene without a volume: its voxels stay with the server.
Scene sceneFrom(const net::SceneFields& fields);

/// What describes a frame, without its request's identity and the server's times of queueing and sending.
net::FrameHead headOf(const SampleFrame& frame, const CodecSettings& codec);
/// A frame whose samples, and the values of its planes, are still to be decoded.
SampleFrame frameFrom(const net::FrameHead& head);
/// What a decoder may accept for a frame of this camera and these settings.
DecodeLimits decodeLimitsFor(const SampleFrame& frame);

/// Colours at full precision as bytes, without loss: floats byte by byte of their planes, compressed.
std::vector<std::byte> encodeColors(const Image<glm::vec4>& image);
/// Back, for an image of that size.
Image<glm::vec4> decodeColors(net::ByteView bytes, uint32_t width, uint32_t height);

}  // namespace warpscope

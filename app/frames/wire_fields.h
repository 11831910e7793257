// Between what the program computes with and what the network carries: cameras, settings, scenes, frames.
// What comes from the network is checked here: every function that reads throws InputError for what could not be used.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "app/frames/frame_source.h"
#include "app/scene/scene.h"
#include "net/messages.h"
#include "render/bricks/brick_frame.h"
#include "render/codec/codec.h"
#include "render/core/image.h"
#include "render/march/sample_frame.h"

namespace warpscope {

net::CameraFields toFields(const Camera& camera);
/// Every setting of a march, by the names that JSON has for them.
net::SettingFields toFields(const MarchSettings& settings);
/// The same, and by their knobs' names what else is asked of the server. What is 0 is left out: servers that do not know it refuse what names it.
net::SettingFields toFields(const MarchSettings& settings, const ServerWishes& wishes);
net::CodecFields toFields(const CodecSettings& settings);
net::SceneFields toFields(const Scene& scene);
std::vector<net::ProcessFields> toFields(std::span<const RankWork> processes);

Camera cameraFrom(const net::CameraFields& fields);
/// What is not among the fields keeps its default; names and values that this program does not know are refused.
MarchSettings marchFrom(const net::SettingFields& fields);
/// Of a request's settings; 0 where there are none.
ServerWishes wishesFrom(const net::SettingFields& fields);
CodecSettings codecFrom(const net::CodecFields& fields);
/// Where the scene's volume is in the world. Throws InputError for what is no place.
VolumeGeometry geometryFrom(const net::SceneFields& fields);
/// A scene without a volume: its voxels stay with the server.
Scene sceneFrom(const net::SceneFields& fields);

/// What describes a frame, without its request's identity and the server's times of queueing and sending. `wishes`: those of the request.
net::FrameHead headOf(const SampleFrame& frame, const CodecSettings& codec, const ServerWishes& wishes = {});
/// Whether a frame marched as `answered` is an answer to `asked`, although they differ: see isCoarsened(), and only where the request allowed it.
bool admits(const net::SettingFields& asked, const net::SettingFields& answered);
/// A frame whose samples, and the values of its planes, are still to be decoded. Where its volume is, the scene knows.
SampleFrame frameFrom(const net::FrameHead& head);
/// What is wrong with a frame of that head and a payload of so many bytes; empty if nothing is. More samples than the camera's rays may have,
/// numbers that nothing can be drawn from, or more bytes than any payload for them has. Whoever receives frames asks before a payload comes.
std::string faultOf(const net::FrameHead& head, uint64_t payloadBytes);
/// The whole frame.
SampleFrame decodedFrom(const net::FrameHead& head, net::ByteView payload, FrameCodec& codec, DecodedPlace place = DecodedPlace::host);
/// What a decoder may accept for a frame of this camera and these settings.
DecodeLimits decodeLimitsFor(const SampleFrame& frame);

}  // namespace warpscope

// Field by field, and nothing taken on trust.
// See proxy_coding.h.
#include "render/codec/proxy_coding.h"

#include <bit>
#include <cmath>

#include "render/base/error.h"
#include "render/codec/zstd_section.h"

namespace warpscope {
namespace {

constexpr uint64_t kProxyHeadBytes = 3 * 4 + (3 + 3 + 9 + 1 + 2) * 8 + 1 + 4, kPointBytes = 8 + 4 * 4;

/// What is true of a copy, in a byte: one of them, or nothing.
constexpr uint8_t kHasMissing = 1, kIsExact = 2;

void appendDouble(ByteVector& out, double value) { appendLittle(out, std::bit_cast<uint64_t>(value)); }
void appendFloat(ByteVector& out, float value) { appendLittle(out, std::bit_cast<uint32_t>(value)); }
double takeDouble(ByteReader& reader) { return std::bit_cast<double>(reader.take<uint64_t>()); }
float takeFloat(ByteReader& reader) { return std::bit_cast<float>(reader.take<uint32_t>()); }

bool isShare(float value) { return value >= 0.0f && value <= 1.0f; }

}  // namespace

uint64_t mostProxyBytes(int longest) {
  if (longest <= 0) return 0;
  const auto edge = static_cast<uint64_t>(longest);
  return kProxyHeadBytes + kMostFunctionPoints * kPointBytes + kSectionHeadBytes + edge * edge * edge;
}

void appendProxy(ByteVector& out, const Proxy& proxy) {
  const Volume& volume = *proxy.volume;
  const VolumeGeometry& geometry = volume.geometry();
  const ProxyScale& scale = proxy.scale;
  const TransferFunction& function = proxy.function;
  if (function.points.size() > kMostFunctionPoints)
    throw InputError("a transfer function that is sent may have at most " + std::to_string(kMostFunctionPoints) + " points, not " +
                     std::to_string(function.points.size()));
  for (int axis = 0; axis < 3; ++axis) appendLittle(out, static_cast<uint32_t>(geometry.dims[axis]));
  for (int axis = 0; axis < 3; ++axis) appendDouble(out, geometry.spacing[axis]);
  for (int axis = 0; axis < 3; ++axis) appendDouble(out, geometry.origin[axis]);
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) appendDouble(out, geometry.direction[column][row]);
  appendDouble(out, geometry.unit());
  appendDouble(out, scale.lowest);
  appendDouble(out, scale.perCode);
  appendLittle(out, static_cast<uint8_t>((scale.hasMissing ? kHasMissing : 0) | (proxy.isExact ? kIsExact : 0)));
  appendLittle(out, static_cast<uint32_t>(function.points.size()));
  for (const TransferPoint& point : function.points) {
    appendDouble(out, point.value);
    for (int channel = 0; channel < 3; ++channel) appendFloat(out, point.color[channel]);
    appendFloat(out, point.alpha);
  }
  const uint8_t* const voxels = volume.voxelsAs<uint8_t>();
  std::vector<uint8_t> differences(volume.voxelCount());
  uint8_t last = 0;
  for (size_t i = 0; i < differences.size(); ++i) {
    differences[i] = static_cast<uint8_t>(voxels[i] - last);
    last = voxels[i];
  }
  appendSection(out, differences);
}

DecodeError takeProxy(std::span<const std::byte> bytes, int longest, ProxyPtr& out) {
  ByteReader reader(bytes);
  VolumeGeometry geometry;
  for (int axis = 0; axis < 3; ++axis) geometry.dims[axis] = reader.take<uint32_t>();
  for (int axis = 0; axis < 3; ++axis) geometry.spacing[axis] = takeDouble(reader);
  for (int axis = 0; axis < 3; ++axis) geometry.origin[axis] = takeDouble(reader);
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) geometry.direction[column][row] = takeDouble(reader);
  geometry.unitEdge = takeDouble(reader);
  Proxy proxy;
  proxy.scale.lowest = takeDouble(reader);
  proxy.scale.perCode = takeDouble(reader);
  const auto facts = reader.take<uint8_t>();
  proxy.scale.hasMissing = facts == kHasMissing;
  proxy.isExact = facts == kIsExact;
  const auto pointCount = reader.take<uint32_t>();
  if (reader.ranOut()) return "the volume's copy ends within its head";
  for (int axis = 0; axis < 3; ++axis)
    if (geometry.dims[axis] > static_cast<uint32_t>(longest)) return "the volume's copy is larger than was asked for";
  if (!(geometry.unitEdge > 0.0) || !std::isfinite(geometry.unitEdge) || !(proxy.scale.perCode > 0.0) || !std::isfinite(proxy.scale.perCode) ||
      !std::isfinite(proxy.scale.lowest))
    return "the volume's copy has numbers that are none";
  if (facts > kIsExact || (proxy.isExact && proxy.scale.perCode != 1.0)) return "the volume's copy is said to be what it cannot be";
  if (pointCount == 0 || pointCount > kMostFunctionPoints || reader.left() < pointCount * kPointBytes) return "the transfer function of the volume's copy is damaged";
  TransferFunction& function = proxy.function;
  for (uint32_t i = 0; i < pointCount; ++i) {
    TransferPoint& point = function.points.emplace_back();
    point.value = takeDouble(reader);
    for (int channel = 0; channel < 3; ++channel) point.color[channel] = takeFloat(reader);
    point.alpha = takeFloat(reader);
    const bool isInOrder = i == 0 || point.value >= function.points[i - 1].value;
    if (!std::isfinite(point.value) || !isInOrder || !isShare(point.color.r) || !isShare(point.color.g) || !isShare(point.color.b) || !isShare(point.alpha))
      return "the transfer function of the volume's copy is damaged";
  }
  try {
    const size_t count = validate(geometry, VoxelType::uint8, "the volume's copy");
    const float extent = glm::length(geometry.bounds().extent());
    if (!(extent > 0.0f) || !std::isfinite(extent)) return "the volume's copy has a size that is none";
    auto voxels = std::make_shared<std::vector<uint8_t>>(count);
    if (!takeSection(reader, *voxels) || reader.left() > 0) return "the volume's copy is damaged";
    uint8_t last = 0;
    for (uint8_t& voxel : *voxels) last = voxel = static_cast<uint8_t>(voxel + last);
    const void* const data = voxels->data();
    proxy.volume = std::make_shared<const Volume>("copy", VoxelType::uint8, geometry, std::move(voxels), data);
  } catch (const InputError& error) {
    return error.what();
  }
  out = std::make_shared<const Proxy>(std::move(proxy));
  return std::nullopt;
}

size_t proxyBytesOf(const Proxy& proxy) {
  ByteVector bytes;
  appendProxy(bytes, proxy);
  return sizeof(uint32_t) + bytes.size();
}

}  // namespace warpscope

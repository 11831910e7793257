// Tiles against what blocks cover of the picture, by the rectangles that visible blocks are found by.
// See frame_order.h.
#include "render/bricks/frame_order.h"

#include <algorithm>

#include "render/bricks/rank_bytes.h"
#include "render/march/march_setup.h"

namespace warpscope {

int FrameOrder::nextOf(uint32_t tile, int rank) const {
  const size_t bytesOfTile = (nearToFar.size() + 7) / 8;
  const uint8_t* const bits = routes.data() + bytesOfTile * tile;
  bool isBehind = rank < 0;
  for (size_t i = 0; i < nearToFar.size(); ++i) {
    if (isBehind && (bits[i / 8] >> (i % 8) & 1) != 0) return nearToFar[i];
    if (nearToFar[i] == rank) isBehind = true;
  }
  return -1;
}

std::vector<std::byte> FrameOrder::bytes() const {
  RankWriter writer;
  writer.put(frame).put(function).put(camera).put(render).put(sample.has_value()).put(sample.value_or(SampleSettings{}));
  return writer.putAll(blocks).putAll(nearToFar).take();
}

FrameOrder FrameOrder::ofBytes(std::span<const std::byte> bytes) {
  RankReader reader(bytes);
  FrameOrder order;
  order.frame = reader.get<uint64_t>();
  order.function = reader.get<uint32_t>();
  order.camera = reader.get<Camera>();
  order.render = reader.get<RenderSettings>();
  const auto hasSample = reader.get<bool>();
  const auto sample = reader.get<SampleSettings>();
  if (hasSample) order.sample = sample;
  reader.getAll(order.blocks);
  reader.getAll(order.nearToFar);
  return order;
}

void findRoutes(FrameOrder& order, const Volume& volume) {
  const Camera& camera = order.camera;
  const PixelGrid pixels = order.sample ? makePixelGrid(camera, sampleRuleFor(volume, camera, *order.sample).quantization.nearDepth) : pixelsFor(volume, camera, order.render);
  const glm::vec3 voxelEdges = volume.geometry().voxelEdges(), lower = volume.bounds().lower;
  const size_t bytesOfTile = (order.nearToFar.size() + 7) / 8;
  order.routes.assign(bytesOfTile * order.tileCount(), 0);
  for (size_t i = 0; i < order.nearToFar.size(); ++i) {
    Box box = boxOf(order.blocks[static_cast<size_t>(order.nearToFar[i])], volume.dims());
    // Samples that are moved along their rays may come to lie beyond the volume, beside a block that the ray does not meet inside.
    box.lower -= order.render.step / voxelEdges;
    box.upper += order.render.step / voxelEdges;
    const VisibleBlocks covered(pixels, order.camera.width, order.camera.height, std::span(&box, 1), lower, voxelEdges);
    for (uint32_t tile = 0; tile < order.tileCount(); ++tile) {
      const PixelArea area = order.areaOf(tile);
      bool isMet = false;
      for (uint32_t y = 0; y < area.height && !isMet; y += VisibleBlocks::kSide)
        for (uint32_t x = 0; x < area.width && !isMet; x += VisibleBlocks::kSide) isMet = !covered.at(area.x + x, area.y + y).isEmpty();
      if (isMet) order.routes[bytesOfTile * tile + i / 8] |= static_cast<uint8_t>(1u << (i % 8));
    }
  }
}

}  // namespace warpscope

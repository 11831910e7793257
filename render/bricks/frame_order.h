// What ranks are told of a picture that they march together, and the way that each of its tiles goes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "render/bricks/brick_tree.h"
#include "render/core/camera.h"
#include "render/march/finished_ray.h"
#include "render/march/march_settings.h"
#include "render/march/ray_relay.h"
#include "render/march/visible_blocks.h"

namespace warpscope {

struct FrameOrder {
  uint64_t frame = 0;    ///< counts from 1
  uint32_t function = 0;  ///< which of the transfer functions, from 0
  Camera camera;
  RenderSettings render;
  std::optional<SampleSettings> sample;  ///< nothing: colours alone are wanted
  std::vector<CellBlock> blocks;         ///< one a rank
  std::vector<int> nearToFar;            ///< of the blocks
  /// For each tile, row by row, and each block in the order of nearToFar, whether any of its rays may have samples there: a bit each, ceil(blocks / 8) bytes a tile.
  std::vector<uint8_t> routes;

  uint32_t tileCount() const { return tilesOf(camera); }
  PixelArea areaOf(uint32_t tile) const { return areaOfTile(camera, tile); }

  /// The next rank that a tile goes to behind `rank`, or the first if that is -1; -1 if there is none.
  int nextOf(uint32_t tile, int rank) const;

  /// But for routes, which each rank finds: they are as many as there are ranks, for each of them.
  std::vector<std::byte> bytes() const;
  static FrameOrder ofBytes(std::span<const std::byte> bytes);
};

/// Finds the routes of an order that has all else. All ranks find the same.
void findRoutes(FrameOrder& order, const Volume& volume);

}  // namespace warpscope

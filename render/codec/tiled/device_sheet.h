// The tiles of a picture on a device, between values and bytes: the same bytes as tiled_sheet.h. For .cu files and what they include.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>
#include <vector>

#include "render/codec/payload_hash.h"
#include "render/codec/tiled/ans.h"
#include "render/codec/tiled/device_sum.h"
#include "render/codec/tiled/tile_grid.h"
#include "render/codec/tiled/tiled_sheet.h"
#include "render/core/transfer_vector.h"
#include "render/cuda/memory.h"

namespace warpscope {

inline constexpr uint32_t kCodedTilePixels = kCodedTileWidth * kCodedTileHeight;

/// Where things are in device memory. Plain data. Streams: layer l of tile t is stream t * layers + l.
struct SheetView {
  TileGrid grid;
  SheetForm form;
  uint32_t layers = 1;  ///< that there is room for
  bool hasMasks = false;  ///< the first shape has a bit a pixel, else a byte
  uint32_t values = 0;    ///< of each plane, in all
  uint8_t* counts = nullptr;        ///< layers of each pixel of the picture
  uint32_t* begins = nullptr;       ///< of each stream among all values, and the end
  uint32_t* rowBegins = nullptr;    ///< of each row of each tile among the frame's values, row by row of the picture, and the end
  uint32_t* rowRanks = nullptr;     ///< of each of the kCodedTileHeight rows of each stream, how many of its values are in rows above
  uint8_t* streams = nullptr;       ///< of each tile
  uint8_t* shapes[2] = {};          ///< kCodedTilePixels for each tile
  uint32_t* numbers = nullptr;      ///< planes of `values`
  uint8_t* bytes = nullptr;         ///< likewise
  uint32_t* flags = nullptr;        ///< SheetFlag
  uint32_t* histograms = nullptr;   ///< of what is written: how often each model has each symbol

  WARPSCOPE_HD uint32_t tiles() const { return grid.count(); }
  WARPSCOPE_HD uint32_t sizeOf(uint32_t stream) const { return begins[stream + 1] - begins[stream]; }
  /// Whether there are as many values as there is room for.
  WARPSCOPE_HD bool isFull() const { return begins[tiles() * layers] == values; }
  WARPSCOPE_HD uint8_t* shape(uint32_t plane, uint32_t tile) const { return shapes[plane] + size_t{tile} * kCodedTilePixels; }
  WARPSCOPE_HD uint32_t shapeSize(uint32_t plane, uint32_t tile) const {
    const TileRect rect = grid.at(tile);
    if (plane > 0) return sizeOf(tile * layers);
    return hasMasks ? rect.maskRowBytes() * rect.height : rect.pixels();
  }
  WARPSCOPE_HD uint32_t modelOf(uint32_t layer, uint32_t plane) const { return form.shapes + layer * form.planes() + plane; }
  WARPSCOPE_HD uint32_t models() const { return form.shapes + layers * form.planes(); }
  WARPSCOPE_HD uint32_t* number(uint32_t plane, uint32_t stream) const { return numbers + size_t{plane} * values + begins[stream]; }
  WARPSCOPE_HD uint8_t* byte(uint32_t plane, uint32_t stream) const { return bytes + size_t{plane} * values + begins[stream]; }
  WARPSCOPE_HD size_t pixel(const TileRect& rect, uint32_t x, uint32_t y) const { return size_t{rect.y0 + y} * grid.width + rect.x0 + x; }
  WARPSCOPE_HD uint32_t rowBegin(const TileRect& rect, uint32_t y) const { return rowBegins[size_t{rect.y0 + y} * grid.columns() + rect.x0 / kCodedTileWidth]; }
};

/// Where a stream's bytes are among all.
struct StreamRead {
  uint32_t offset = 0, length = 0;
};

/// What a lane knows of a stream while it is read: kept between kernels.
struct LaneState {
  uint32_t state = kAnsLow;
  uint32_t next = 0;  ///< word; the same of all lanes
};

/// What is wrong with bytes that were read.
enum SheetFlag : uint32_t {
  kDamagedShapes = 1,
  kDamagedStreams = 2,
  kDisordered = 4,  ///< the segments of a ray are
  kWithoutRadius = 8,  ///< a sample is: no damage
};

struct SheetReport {
  uint32_t values = 0;  ///< that there are
  uint32_t flags = 0;   ///< SheetFlag
};

/// One picture at a time; keeps its buffers. All work is put into the stream that it was made with, but for what may be done `beside` it.
class DeviceSheet {
 public:
  DeviceSheet(cudaStream_t stream, cudaStream_t beside);

  /// Makes room. Counts are zeros where there are masks, else to be filled; nothing is known of streams.
  const SheetView& begin(const TileGrid& grid, const SheetForm& form, uint32_t layers, bool hasMasks);
  /// Makes room for values, which count() has not found yet or says.
  const SheetView& reserveValues(uint32_t values);
  const SheetView& view() const { return view_; }

  /// Finds where streams and rows begin, from counts.
  void count();

  /// Begins to write: nothing is counted of symbols.
  const SheetView& clearHistograms();
  /// From masks as counts are (and how many further layers there are, where there are two shapes). For rays their bytes are the shapes' already, as are `streams`.
  void makeMasks();
  /// Makes bytes of the sheet, whose planes and shapes are there. `counted`: planes, a bit each, numbers before bytes, whose symbols whoever made them has counted.
  void write(uint32_t counted);
  /// Appends them to a payload. Waits.
  SummedWords append(ByteVector& out);

  /// Begins to read. False if the streams are none that can be.
  bool upload(const SheetHead& head);
  /// Counts of each pixel; `rays`: where their bytes go, if shapes are those of rays. `most`: layers of a pixel.
  void takeShapes(uint32_t most, uint8_t* rays);
  /// Planes, after count(). Nothing where there is another number of values than there is room for.
  void takePlanes();
  /// Asks what became of what is read, after count(), for report().
  void askForReport();
  /// What was asked for last. Waits.
  SheetReport report();

 private:
  cudaStream_t stream_, beside_;
  SheetView view_;
  cuda::DeviceBuffer<uint8_t> counts_, streams_, shapes_[2], bytes_;
  cuda::DeviceBuffer<uint32_t> begins_, rowBegins_, rowRanks_, numbers_, flags_, histograms_, slots_, lengths_, offsets_, states_, wordCounts_, bad_;
  cuda::DeviceBuffer<uint16_t> frequencies_, words_, packed_;
  cuda::DeviceBuffer<int> kinds_;  ///< of models that are read
  uint32_t models_ = 0;            ///< that there are of those
  cuda::DeviceBuffer<AnsWriterShare> shares_;
  cuda::DeviceBuffer<StreamRead> reads_;
  cuda::DeviceBuffer<LaneState> laneStates_;
  cuda::PinnedValue<SheetReport> report_;
  DeviceSum sum_;  ///< of words that are appended
  cuda::Event told_;  ///< heads of what is written are in host_
  cuda::Event gathered_;  ///< its streams are one behind the other
  TransferVector<std::byte> host_;  // page-locked
};

}  // namespace warpscope

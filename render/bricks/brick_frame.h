// One rank's part of a picture: tiles that have come to it, and what is to be sent of those that have been marched.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>

#include "render/base/ranks.h"
#include "render/bricks/frame_order.h"
#include "render/bricks/work_timeline.h"
#include "render/march/ray_relay.h"

namespace warpscope {

/// What messages between ranks are about.
enum BrickMessage {
  kFunctionMessage,  ///< from the first: a transfer function; all make what marching by it takes
  kForgetMessage,    ///< from the first: nobody will ask for one of them any more
  kLightMessage,     ///< from the first: the copy in which light is found, by one of them
  kProxyMessage,     ///< from the first: the coarse copy by one of them
  kOrderMessage,     ///< from the first: a FrameOrder
  kTileMessage,      ///< to the next on its way: a tile (BrickFrame)
  kResultMessage,    ///< to the first: what rays of a tile have left
  kTroubleMessage,   ///< to the first: why a frame cannot be marched
  kAliveMessage,     ///< to the first, now and then while a frame is under way: nothing is wrong
  kWorkMessage,      ///< to the first: what a rank has done for a frame, when that has ended (RankWork)
  kEndMessage,       ///< from the first: the frame is done, or nobody wants it any more
  kQuitMessage,      ///< from the first: there will be no more
};

/// What rays of a tile have left, somewhere along its way.
struct TileResult {
  uint64_t frame = 0;
  uint32_t tile = 0;
  uint32_t results = 0;            ///< of the tile in all, if this is the last that is sent: others may arrive behind it; else 0
  std::vector<uint32_t> finished;  ///< pixels of the tile, by their places in it
  DenseRays found;                 ///< of each of these; where samples are wanted
  std::vector<glm::vec4> colors;   ///< likewise; where they are not

  static TileResult ofBytes(std::span<const std::byte> bytes);
};

/// What a rank has done for a frame.
struct RankWork {
  uint64_t frame = 0;
  CellBlock block;             ///< that it marched
  uint32_t tiles = 0;          ///< that came to it, each as often as it came
  uint32_t deviceTiles = 0;    ///< of these, marched by a device
  double marchMs = 0.0;        ///< of all its threads together
  double waitMs = 0.0;         ///< likewise: for tiles
  uint64_t sentBytes = 0;      ///< to other ranks
  WorkTimeline timeline;       ///< when it marched and waited
};

class BrickFrame final : public RayRelay {
 public:
  struct Outgoing {
    int to = 0;
    int kind = 0;
    std::vector<std::byte> bytes;
  };

  /// `onOutgoing` is called, on any thread, when there is something to send. `isNear`: as Ranks'; what goes to others is packed.
  BrickFrame(FrameOrder order, int rank, std::function<void()> onOutgoing, std::function<bool(int)> isNear);

  const FrameOrder& order() const { return order_; }
  /// A kTileMessage of this frame.
  void arrive(std::vector<std::byte> bytes);
  /// Nothing if there is none.
  std::optional<Outgoing> takeOutgoing();
  /// The frame cannot be marched here.
  void fail(const std::string& reason);

  const CellBlock& block() const override { return order_.blocks[static_cast<size_t>(rank_)]; }
  std::unique_ptr<RelayedTile> take() override;
  std::unique_ptr<RelayedTile> takeReady() override;
  void handOn(std::unique_ptr<RelayedTile> tile) override;
  void close() noexcept override;

  /// So far.
  RankWork work() const;

  /// Which frame a message of these kinds is of: the first of its bytes.
  static uint64_t frameOf(const RankMessage& message);

 private:
  std::unique_ptr<RelayedTile> tileOf(const std::vector<std::byte>& bytes) const;
  std::vector<std::byte> bytesOf(const RelayedTile& tile, bool isPacked) const;
  std::vector<std::byte> resultOf(const RelayedTile& tile, bool isComplete) const;
  void put(Outgoing outgoing);
  /// Null if there will be no more or, unless `waits`, none is there.
  std::unique_ptr<RelayedTile> nextTile(bool waits);
  double msSinceBegin(std::chrono::steady_clock::time_point time) const { return std::chrono::duration<double, std::milli>(time - begin_).count(); }
  std::unique_ptr<RelayedTile> begun(std::unique_ptr<RelayedTile> tile);

  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  const FrameOrder order_;
  const int rank_;
  const std::function<void()> onOutgoing_;
  const std::function<bool(int)> isNear_;

  mutable std::mutex mutex_;  // of everything below
  std::condition_variable changed_;
  std::deque<std::vector<std::byte>> arrived_;
  uint32_t nextOwn_ = 0;  // of tiles that come to this rank first, those before are taken
  bool isClosed_ = false;
  std::deque<Outgoing> outgoing_;
  RankWork work_;
};

}  // namespace warpscope

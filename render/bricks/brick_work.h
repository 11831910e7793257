// What every rank has and does: what marching by each transfer function takes, and its part of the picture that is marched.
#pragma once

#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "render/base/ranks.h"
#include "render/bricks/brick_frame.h"
#include "render/core/transfer_function.h"
#include "render/march/march_setup.h"
#include "render/march/ray_relay.h"

namespace warpscope {

class BrickWork {
 public:
  BrickWork(VolumePtr volume, PieceMaker makePieces) : volume_(std::move(volume)), makePieces_(std::move(makePieces)) {}
  ~BrickWork() { end(); }

  const VolumePtr& volume() const { return volume_; }
  Ranks& ranks() const { return *volume_->ranks(); }

  /// All ranks at the same time. Functions are counted from 0; returns which it is.
  uint32_t addFunction(TransferFunction function);
  const MarchedVolumePtr& function(uint32_t index) const { return functions_.at(index).marched; }
  /// Nobody will ask for it again.
  void forgetFunction(uint32_t index) { functions_.at(index) = {}; }
  /// All ranks at the same time: the coarse copy by that function. Waits for nobody if it has been made.
  ProxyPtr proxyFor(uint32_t index, int longest);
  /// All ranks at the same time: what shadows and occlusion by that function are found in.
  void makeLightCopy(uint32_t index);
  bool hasLightCopy(uint32_t index) const { return functions_.at(index).hasLightCopy; }
  /// Which one it is, if it is known.
  std::optional<uint32_t> find(const TransferFunction& function) const;

  /// Begins to march; another frame that is under way is ended.
  void begin(FrameOrder order);
  /// Null if none is under way.
  BrickFrame* frame() { return frame_.get(); }
  /// Whatever is left of the frame is not marched. What has been done for it; nothing if none was under way.
  std::optional<RankWork> end();

 private:
  struct Function {
    MarchedVolumePtr marched;
    std::shared_ptr<PieceMarcher> pieces;
    bool hasLightCopy = false;
  };

  /// Voxels have been read for something else than the block.
  void releaseShare();

  const VolumePtr volume_;
  const PieceMaker makePieces_;
  std::vector<Function> functions_;
  ProxyPtr lastProxy_;   // that was asked for
  CellBlock block_;      // whose voxels are read
  int64_t strayCells_ = 0;  // of other blocks, whose voxels have been read and are not needed any more
  std::unique_ptr<BrickFrame> frame_;
  std::jthread marching_;  // of it
};

}  // namespace warpscope

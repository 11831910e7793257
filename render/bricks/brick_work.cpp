// The thread that marches.
// See brick_work.h.
#include "render/bricks/brick_work.h"

#include <algorithm>
#include <string>
#include <utility>

#include "render/base/error.h"
#include "render/volume/proxy.h"

namespace warpscope {
namespace {

int64_t cellsOf(const CellBlock& block) {
  const glm::ivec3 extent = glm::max(block.upper - block.lower, 0);
  return int64_t{extent.x} * extent.y * extent.z;
}

int64_t sharedCells(const CellBlock& a, const CellBlock& b) { return cellsOf({glm::max(a.lower, b.lower), glm::min(a.upper, b.upper)}); }

}  // namespace

uint32_t BrickWork::addFunction(TransferFunction function) {
  const auto known = std::ranges::find_if(functions_, [](const Function& one) { return one.marched != nullptr; });
  auto marched = known != functions_.end() ? std::make_shared<const MarchedVolume>(*known->marched, std::move(function))
                                           : std::make_shared<const MarchedVolume>(volume_, std::move(function));
  // The place of one that is forgotten.
  auto place = std::ranges::find_if(functions_, [](const Function& one) { return one.marched == nullptr; });
  if (place == functions_.end()) place = functions_.insert(place, Function{});
  *place = {marched, makePieces_.make(marched), false};
  releaseShare();
  return static_cast<uint32_t>(place - functions_.begin());
}

void BrickWork::makeLightCopy(uint32_t index) {
  end();  // of voxels others are needed now
  Function& function = functions_.at(index);
  function.pieces->setLightCopy(std::make_shared<const Proxy>(makeProxy(*volume_, function.marched->transferFunction, kLightCopyEdge, CopyFilter::means, ranks().stop())));
  function.hasLightCopy = true;
  releaseShare();
}

ProxyPtr BrickWork::proxyFor(uint32_t index, int longest) {
  ProxyPtr proxy = functions_.at(index).marched->proxyFor(longest, ranks().stop());
  if (std::exchange(lastProxy_, proxy) != proxy) releaseShare();
  return proxy;
}

void BrickWork::releaseShare() {
  volume_->releaseVoxels();  // of a share of the volume, which is not the block
  block_ = {};
  strayCells_ = 0;
}

std::optional<uint32_t> BrickWork::find(const TransferFunction& function) const {
  for (uint32_t i = 0; i < functions_.size(); ++i)
    if (functions_[i].marched && functions_[i].marched->transferFunction == function) return i;
  return {};
}

void BrickWork::begin(FrameOrder order) {
  end();
  frame_ = std::make_unique<BrickFrame>(std::move(order), ranks().rank(), [ranks = volume_->ranks()] { ranks->wake(); },
                                        [ranks = volume_->ranks()](int other) { return ranks->isNear(other); });
  strayCells_ += cellsOf(block_) - sharedCells(block_, frame_->block());
  block_ = frame_->block();
  if (4 * strayCells_ > cellsOf(block_)) {
    volume_->releaseVoxels();
    strayCells_ = 0;
  }
  // Reading a brick takes as long as the disk does: messages come and go meanwhile.
  const std::string self = "process " + std::to_string(ranks().rank()) + " of " + std::to_string(ranks().size());
  marching_ = std::jthread([self, volume = volume_, frame = frame_.get(), pieces = functions_.at(frame_->order().function).pieces](const std::stop_token& stop) {
    const FrameOrder& asked = frame->order();
    try {
      volume->provide(rowsOf(frame->block(), asked.render, volume->geometry()), stop);
    } catch (const OperationCancelled&) {
      return;
    } catch (const std::exception& error) {
      return frame->fail(self + ": " + error.what());
    }
    try {
      pieces->marchPieces(asked.camera, asked.render, asked.sample ? &*asked.sample : nullptr, *frame, stop);
    } catch (const OperationCancelled&) {
    } catch (const std::exception& error) {
      frame->fail(error.what());
    }
  });
}

std::optional<RankWork> BrickWork::end() {
  if (!frame_) return {};
  marching_.request_stop();
  frame_->close();
  marching_ = {};  // joins
  const RankWork work = frame_->work();
  frame_.reset();
  return work;
}

}  // namespace warpscope

// The thread that marches.
// See brick_work.h.
#include "render/bricks/brick_work.h"

#include "render/base/error.h"

namespace warpscope {

void BrickWork::addFunction(TransferFunction function) {
  auto marched = functions_.empty() || !functions_.front().marched ? std::make_shared<const MarchedVolume>(volume_, std::move(function))
                                                                   : std::make_shared<const MarchedVolume>(*functions_.front().marched, std::move(function));
  functions_.push_back({marched, makePieceMarcher(marched)});
}

void BrickWork::begin(FrameOrder order) {
  frame_ = std::make_unique<BrickFrame>(std::move(order), ranks().rank(), [ranks = volume_->ranks()] { ranks->wake(); });
  marching_ = std::jthread([frame = frame_.get(), pieces = functions_.at(frame_->order().function).pieces](const std::stop_token& stop) {
    const FrameOrder& asked = frame->order();
    try {
      pieces->marchPieces(asked.camera, asked.render, asked.sample ? &*asked.sample : nullptr, *frame, stop);
    } catch (const OperationCancelled&) {
    } catch (const std::exception& error) {
      frame->fail(error.what());
    }
  });
}

void BrickWork::end() {
  if (!frame_) return;
  marching_.request_stop();
  frame_->close();
  marching_ = {};  // joins
  frame_.reset();
}

}  // namespace warpscope

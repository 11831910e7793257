// A volume that is spread over ranks, which are threads here.
#pragma once

#include <chrono>
#include <functional>
#include <thread>
#include <vector>

#include "render/bricks/brick_ranks.h"
#include "render/volume/volume.h"

namespace warpscope {

/// The same voxels, as one of these ranks has them.
inline VolumePtr sharedBy(const VolumePtr& whole, RanksPtr ranks) {
  return std::make_shared<Volume>(whole->name(), whole->type(), whole->geometry(), whole, whole->voxels(), std::stop_token{}, std::move(ranks));
}

/// A marcher of a volume that so many ranks have, and the others of them.
class Spread {
 public:
  /// What a rank marches its brick by.
  using MakePieces = std::function<PieceMaker(int rank)>;
  static PieceMaker onHost(int /*rank*/) { return {}; }

  Spread(const VolumePtr& whole, const TransferFunction& function, int count, const MakePieces& makePieces = onHost)
      : Spread([whole](RanksPtr own) { return sharedBy(whole, std::move(own)); }, function, count, makePieces) {}
  /// `open`: as one of these ranks has it.
  Spread(const std::function<VolumePtr(RanksPtr)>& open, const TransferFunction& function, int count, const MakePieces& makePieces = onHost,
         std::chrono::milliseconds patience = kRankPatience, bool areNear = true) {
    std::vector<RanksPtr> ranks = makeLocalRanks(count, areNear);
    for (int rank = 1; rank < count; ++rank)
      others_.emplace_back([open, makePieces, rank, own = ranks[static_cast<size_t>(rank)]] { followRanks(open(own), {}, makePieces(rank)); });
    leader_ = leadRanks(open(ranks[0]), patience, makePieces(0));
    marcher_ = makeRanksMarcher(leader_, function);
  }
  ~Spread() {
    marcher_.reset();
    leader_.reset();
    for (std::thread& other : others_) other.join();
  }
  Spread(const Spread&) = delete;
  Spread& operator=(const Spread&) = delete;

  Marcher& operator*() const { return *marcher_; }
  Marcher* operator->() const { return marcher_.get(); }
  /// What the ranks did for the last frame.
  std::vector<RankWork> lastWork() const { return warpscope::lastWork(leader_); }

 private:
  std::vector<std::thread> others_;
  BrickLeaderPtr leader_;
  MarcherPtr marcher_;
};

/// Runs `work(ranks)` on as many threads as there are ranks.
template <class Work>
void onAll(int count, const Work& work) {
  std::vector<RanksPtr> ranks = makeLocalRanks(count);
  std::vector<std::jthread> threads;
  for (const RanksPtr& own : ranks) threads.emplace_back([&work, own] { work(own); });
}

}  // namespace warpscope

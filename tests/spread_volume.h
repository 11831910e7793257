// A volume that is spread over ranks, which are threads here.
#pragma once

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
  Spread(const VolumePtr& whole, const TransferFunction& function, int count) : Spread([whole](RanksPtr own) { return sharedBy(whole, std::move(own)); }, function, count) {}
  /// `open`: as one of these ranks has it.
  Spread(const std::function<VolumePtr(RanksPtr)>& open, const TransferFunction& function, int count) {
    std::vector<RanksPtr> ranks = makeLocalRanks(count);
    for (int rank = 1; rank < count; ++rank) others_.emplace_back([open, own = ranks[static_cast<size_t>(rank)]] { followRanks(open(own)); });
    marcher_ = makeRanksMarcher(leadRanks(open(ranks[0])), function);
  }
  ~Spread() {
    marcher_.reset();
    for (std::thread& other : others_) other.join();
  }
  Spread(const Spread&) = delete;
  Spread& operator=(const Spread&) = delete;

  Marcher& operator*() const { return *marcher_; }
  Marcher* operator->() const { return marcher_.get(); }

 private:
  std::vector<std::thread> others_;
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

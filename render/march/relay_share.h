// The part of a relay's tiles that a second marcher works at, beside one that gives it what it cannot march itself.
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>

#include "render/march/ray_relay.h"

namespace warpscope {

class RelayShare final : public RayRelay {
 public:
  explicit RelayShare(RayRelay& whole) : whole_(whole) {}

  void give(std::unique_ptr<RelayedTile> tile) {
    const std::scoped_lock lock(mutex_);
    given_.push_back(std::move(tile));
    changed_.notify_one();
  }
  /// Nothing more is given; what has been is still taken.
  void end() noexcept {
    const std::scoped_lock lock(mutex_);
    isEnded_ = true;
    changed_.notify_all();
  }

  const CellBlock& block() const override { return whole_.block(); }
  std::unique_ptr<RelayedTile> take() override {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !given_.empty() || isEnded_; });
    return next();
  }
  std::unique_ptr<RelayedTile> takeReady() override {
    const std::scoped_lock lock(mutex_);
    return next();
  }
  void handOn(std::unique_ptr<RelayedTile> tile) override { whole_.handOn(std::move(tile)); }
  /// Nor does the whole relay give any: who works at this share cannot go on.
  void close() noexcept override {
    whole_.close();
    const std::scoped_lock lock(mutex_);
    given_.clear();
    isEnded_ = true;
    changed_.notify_all();
  }

 private:
  std::unique_ptr<RelayedTile> next() {
    if (given_.empty()) return nullptr;
    std::unique_ptr<RelayedTile> tile = std::move(given_.front());
    given_.pop_front();
    tile->taken = std::chrono::steady_clock::now();  // until now it has waited
    return tile;
  }

  RayRelay& whole_;
  std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  std::deque<std::unique_ptr<RelayedTile>> given_;
  bool isEnded_ = false;
};

}  // namespace warpscope

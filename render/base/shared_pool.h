// Workspaces that are dear to make, for all who work at the same time: as many are made as are in use at once, not one for each user and thread.
// What came back last is handed out first, while caches still have it.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace warpscope {

/// `T` can be made of nothing. Safe on any thread.
template <class T>
class SharedPool : public std::enable_shared_from_this<SharedPool<T>> {
 public:
  /// Gives back what it holds when it goes.
  class Lease {
   public:
    Lease(std::shared_ptr<SharedPool> pool, std::unique_ptr<T> held) : pool_(std::move(pool)), held_(std::move(held)) {}
    ~Lease() { pool_->putBack(std::move(held_)); }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;

    T& operator*() const { return *held_; }
    T* operator->() const { return held_.get(); }

   private:
    const std::shared_ptr<SharedPool> pool_;
    std::unique_ptr<T> held_;
  };

  /// The process has one of a type, as long as anybody holds it.
  static std::shared_ptr<SharedPool> ofProcess() {
    static std::mutex mutex;
    static std::weak_ptr<SharedPool> shared;
    const std::scoped_lock lock(mutex);
    std::shared_ptr<SharedPool> pool = shared.lock();
    if (!pool) shared = pool = std::make_shared<SharedPool>();
    return pool;
  }

  Lease take() {
    std::unique_ptr<T> held;
    {
      const std::scoped_lock lock(mutex_);
      if (!free_.empty()) {
        held = std::move(free_.back());
        free_.pop_back();
      }
    }
    if (!held) held = std::make_unique<T>();
    return Lease(this->shared_from_this(), std::move(held));
  }

  /// Lets go of what nobody uses at the moment.
  void forget() {
    std::vector<std::unique_ptr<T>> unused;
    const std::scoped_lock lock(mutex_);
    unused.swap(free_);
  }

 private:
  void putBack(std::unique_ptr<T> held) {
    const std::scoped_lock lock(mutex_);
    free_.push_back(std::move(held));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> free_;
};

}  // namespace warpscope

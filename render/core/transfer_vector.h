// Vectors of what travels between processors: their memory may be such that hardware reaches it directly (page-locked for a GPU), and
// growing them does not fill them with zeros that are overwritten anyway.
// The allocator follows std::pmr (C++17), but goes along when a vector is moved or swapped; copies take plain memory.
#pragma once

#include <memory_resource>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace warpscope {

template <class T>
class TransferAllocator {
 public:
  using value_type = T;
  using propagate_on_container_move_assignment = std::true_type;
  using propagate_on_container_swap = std::true_type;

  TransferAllocator() noexcept : memory_(std::pmr::new_delete_resource()) {}
  /// `memory` must outlive every vector that uses it.
  explicit TransferAllocator(std::pmr::memory_resource* memory) noexcept : memory_(memory) {}
  template <class U>
  TransferAllocator(const TransferAllocator<U>& other) noexcept : memory_(other.memory()) {}

  T* allocate(size_t count) { return static_cast<T*>(memory_->allocate(count * sizeof(T), alignof(T))); }
  void deallocate(T* values, size_t count) noexcept { memory_->deallocate(values, count * sizeof(T), alignof(T)); }
  TransferAllocator select_on_container_copy_construction() const { return {}; }

  /// Without a value an element is left as the memory is.
  template <class U>
  void construct(U* place) noexcept(std::is_nothrow_default_constructible_v<U>) {
    ::new (static_cast<void*>(place)) U;
  }
  template <class U, class... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
  }

  std::pmr::memory_resource* memory() const { return memory_; }
  template <class U>
  bool operator==(const TransferAllocator<U>& other) const {
    return memory_ == other.memory();
  }

 private:
  std::pmr::memory_resource* memory_;
};

template <class T>
using TransferVector = std::vector<T, TransferAllocator<T>>;

}  // namespace warpscope

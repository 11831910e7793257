// A dense two-dimensional array. Row 0 is the top row, x runs fastest.
// Colours in Image<glm::vec4> are linear and premultiplied unless a name says otherwise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "render/base/memory.h"

namespace warpscope {

/// The widest and highest image that any part of the program accepts, in pixels.
inline constexpr uint32_t kMaxImageSide = 16384;

/// Images of so many bytes are asked for before they are taken (requireMemory): smaller ones are not worth the question.
inline constexpr size_t kLargeImageBytes = size_t{256} << 20;

/// Leaves elements that are given no value as the memory is: what is written in parallel anyway is not filled first by one thread. Throws InputError for large images that memory has no
/// room for.
template <class T>
struct UnfilledAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UnfilledAllocator<U>;
  };
  UnfilledAllocator() = default;
  template <class U>
  UnfilledAllocator(const UnfilledAllocator<U>&) noexcept {}

  T* allocate(size_t count) {
    if (count >= kLargeImageBytes / sizeof(T)) requireMemory(count * sizeof(T), "a picture of so many pixels");
    return std::allocator<T>::allocate(count);
  }

  template <class U>
  void construct(U* place) {
    ::new (static_cast<void*>(place)) U;
  }
  template <class U, class... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
  }
};

template <class T>
class Image {
 public:
  Image() = default;
  Image(uint32_t width, uint32_t height, const T& value = T{}) { resize(width, height, value); }

  /// Gives the image a new size; every pixel becomes `value`. Keeps its memory where that suffices.
  void resize(uint32_t width, uint32_t height, const T& value = T{}) {
    width_ = width;
    height_ = height;
    pixels_.assign(size_t{width} * height, value);
  }

  /// Gives the image a new size; what its pixels hold is for the caller to write. Cheaper than resize.
  void reshape(uint32_t width, uint32_t height) {
    width_ = width;
    height_ = height;
    pixels_.resize(size_t{width} * height);
  }

  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  size_t size() const { return pixels_.size(); }
  bool empty() const { return pixels_.empty(); }

  T* data() { return pixels_.data(); }
  const T* data() const { return pixels_.data(); }
  T* row(uint32_t y) { return pixels_.data() + size_t{y} * width_; }
  const T* row(uint32_t y) const { return pixels_.data() + size_t{y} * width_; }

  T& operator()(uint32_t x, uint32_t y) { return row(y)[x]; }
  const T& operator()(uint32_t x, uint32_t y) const { return row(y)[x]; }
  T& operator[](size_t i) { return pixels_[i]; }
  const T& operator[](size_t i) const { return pixels_[i]; }

  auto begin() { return pixels_.begin(); }
  auto end() { return pixels_.end(); }
  auto begin() const { return pixels_.begin(); }
  auto end() const { return pixels_.end(); }

  bool operator==(const Image&) const = default;

 private:
  uint32_t width_ = 0;
  uint32_t height_ = 0;
  std::vector<T, UnfilledAllocator<T>> pixels_;
};

}  // namespace warpscope

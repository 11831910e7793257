// Device memory, streams and events that free themselves. For .cu files and what they include.
// CUDA Runtime API: memory, stream and event management.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "render/cuda/check.h"

namespace warpscope::cuda {

/// An array in device memory, of one owner, that grows and never shrinks: steady work allocates nothing.
template <class T>
class DeviceBuffer {
 public:
  DeviceBuffer() = default;
  explicit DeviceBuffer(size_t count) { reserve(count); }
  DeviceBuffer(DeviceBuffer&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), capacity_(std::exchange(other.capacity_, 0)) {}
  DeviceBuffer& operator=(DeviceBuffer&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }
  DeviceBuffer(const DeviceBuffer&) = delete;
  DeviceBuffer& operator=(const DeviceBuffer&) = delete;
  ~DeviceBuffer() { cudaFree(data_); }

  /// Makes room for `count` elements; where that takes new memory, what was there is lost. Waits for the device then. Throws DeviceError.
  void reserve(size_t count) {
    if (count <= capacity_) return;
    // What grows once may grow again: some room to spare, so that counts that vary a little do not allocate each time.
    const size_t wanted = capacity_ == 0 ? count : count + count / 8;
    cudaFree(std::exchange(data_, nullptr));
    capacity_ = 0;
    WARPSCOPE_CUDA_CHECK(cudaMalloc(&data_, wanted * sizeof(T)));
    capacity_ = wanted;
  }
  /// Copies `values` to the front, growing as needed. The host's memory is free again when the stream has got there (at once if it is
  /// not page-locked).
  void upload(std::span<const T> values, cudaStream_t stream) {
    reserve(values.size());
    if (!values.empty())
      WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(data_, values.data(), values.size_bytes(), cudaMemcpyHostToDevice, stream));
  }
  /// The first `count` elements, after the stream has got there.
  std::vector<T> download(size_t count, cudaStream_t stream) const {
    std::vector<T> values(count);
    if (count > 0) WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(values.data(), data_, count * sizeof(T), cudaMemcpyDeviceToHost, stream));
    WARPSCOPE_CUDA_CHECK(cudaStreamSynchronize(stream));
    return values;
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  size_t capacity() const { return capacity_; }

 private:
  T* data_ = nullptr;
  size_t capacity_ = 0;
};

/// One value in page-locked memory: a copy to it does not hold the host up.
template <class T>
class PinnedValue {
 public:
  PinnedValue() { WARPSCOPE_CUDA_CHECK(cudaMallocHost(&value_, sizeof(T))); }
  PinnedValue(const PinnedValue&) = delete;
  PinnedValue& operator=(const PinnedValue&) = delete;
  ~PinnedValue() { cudaFreeHost(value_); }

  T* data() { return value_; }
  const T& operator*() const { return *value_; }
  const T* operator->() const { return value_; }

 private:
  T* value_ = nullptr;
};

/// Whose blocks begin where several streams have some.
enum class Urgency { usual, first };

/// A stream that waits for no other.
class Stream {
 public:
  explicit Stream(Urgency urgency = Urgency::usual) {
    int least = 0, greatest = 0;
    WARPSCOPE_CUDA_CHECK(cudaDeviceGetStreamPriorityRange(&least, &greatest));
    WARPSCOPE_CUDA_CHECK(cudaStreamCreateWithPriority(&stream_, cudaStreamNonBlocking, urgency == Urgency::first ? greatest : least));
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  ~Stream() { cudaStreamDestroy(stream_); }

  operator cudaStream_t() const { return stream_; }
  void synchronize() const { WARPSCOPE_CUDA_CHECK(cudaStreamSynchronize(stream_)); }

 private:
  cudaStream_t stream_ = nullptr;
};

/// However its scope is left, the stream is through with memory that goes back to a pool behind it.
class Settled {
 public:
  explicit Settled(cudaStream_t stream) : stream_(stream) {}
  ~Settled() { cudaStreamSynchronize(stream_); }
  Settled(const Settled&) = delete;
  Settled& operator=(const Settled&) = delete;

 private:
  const cudaStream_t stream_;
};

/// A place in a stream, and its time.
class Event {
 public:
  Event() { WARPSCOPE_CUDA_CHECK(cudaEventCreate(&event_)); }
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;
  ~Event() { cudaEventDestroy(event_); }

  void record(cudaStream_t stream) { WARPSCOPE_CUDA_CHECK(cudaEventRecord(event_, stream)); }
  void synchronize() const { WARPSCOPE_CUDA_CHECK(cudaEventSynchronize(event_)); }
  /// What the stream gets from now on waits until it was passed.
  void holdUp(cudaStream_t stream) const { WARPSCOPE_CUDA_CHECK(cudaStreamWaitEvent(stream, event_, 0)); }
  /// Milliseconds from `earlier` to this; both must have been passed.
  double millisecondsSince(const Event& earlier) const {
    float ms = 0.0f;
    WARPSCOPE_CUDA_CHECK(cudaEventElapsedTime(&ms, earlier.event_, event_));
    return ms;
  }

 private:
  cudaEvent_t event_ = nullptr;
};

/// Memory that CUB asks for before it works.
using Scratch = DeviceBuffer<std::byte>;

/// Runs a CUB algorithm: `algorithm(scratch, scratchBytes)` is called once to ask for bytes and once to work.
template <class Algorithm>
void withScratch(Scratch& scratch, Algorithm&& algorithm) {
  size_t bytes = 0;
  WARPSCOPE_CUDA_CHECK(algorithm(nullptr, bytes));
  scratch.reserve(bytes > 0 ? bytes : 1);
  WARPSCOPE_CUDA_CHECK(algorithm(scratch.data(), bytes));
}

inline unsigned blocksFor(size_t items, unsigned itemsPerBlock) {
  return static_cast<unsigned>((items + itemsPerBlock - 1) / itemsPerBlock);
}

}  // namespace warpscope::cuda

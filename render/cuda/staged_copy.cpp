// Lanes, each with two buffers.
// See staged_copy.h.
#include "render/cuda/staged_copy.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <exception>
#include <memory_resource>
#include <mutex>
#include <thread>

#include "render/cuda/pinned_memory.h"

namespace warpscope::cuda {
namespace {

constexpr size_t kChunkBytes = size_t{4} << 20;
constexpr unsigned kMostLanes = 6;

}  // namespace

class StagedCopy::Lane {
 public:
  void copy(const CopiedRange& chunk) {
    Buffer& buffer = buffers_[next_];
    next_ = 1 - next_;
    buffer.through.synchronize();
    std::memcpy(buffer.bytes.data(), chunk.from, chunk.bytes);
    WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(chunk.to, buffer.bytes.data(), chunk.bytes, cudaMemcpyHostToDevice, stream_));
    buffer.through.record(stream_);
  }
  void wait() { stream_.synchronize(); }

 private:
  struct Buffer {
    std::pmr::vector<std::byte> bytes{kChunkBytes, pinnedMemory()};
    Event through;
  };

  Stream stream_;
  Buffer buffers_[2];
  int next_ = 0;
};

StagedCopy::StagedCopy() = default;
StagedCopy::~StagedCopy() = default;

void StagedCopy::copy(std::span<const CopiedRange> ranges, const std::function<void()>& onChunk) {
  std::vector<CopiedRange> chunks;
  for (const CopiedRange& range : ranges)
    for (size_t at = 0; at < range.bytes; at += kChunkBytes) chunks.push_back({range.from + at, range.to + at, std::min(kChunkBytes, range.bytes - at)});
  const size_t count = std::min<size_t>(std::clamp(std::thread::hardware_concurrency() / 2, 1u, kMostLanes), chunks.size());
  while (lanes_.size() < count) lanes_.push_back(std::make_unique<Lane>());
  std::atomic<size_t> next = 0;
  std::mutex troubleMutex;
  std::exception_ptr trouble;
  {
    std::vector<std::jthread> threads;
    for (size_t i = 0; i < count; ++i)
      threads.emplace_back([&, &lane = *lanes_[i]] {
        try {
          for (size_t at; (at = next++) < chunks.size();) {
            onChunk();
            lane.copy(chunks[at]);
          }
          lane.wait();
        } catch (...) {
          next = chunks.size();
          const std::scoped_lock lock(troubleMutex);
          trouble = std::current_exception();
        }
      });
  }
  if (trouble) std::rethrow_exception(trouble);
}

}  // namespace warpscope::cuda

// The driver's functions, and what is backed.
// See sparse_memory.h.
#include "render/cuda/sparse_memory.h"

#include <cuda.h>

#include <algorithm>
#include <string>

namespace warpscope::cuda {
namespace {

/// A function of the driver's by its name.
template <class Function>
Function* driverFunction(const char* name) {
  void* found = nullptr;
  cudaDriverEntryPointQueryResult result = cudaDriverEntryPointSymbolNotFound;
#if CUDART_VERSION >= 12050
  WARPSCOPE_CUDA_CHECK(cudaGetDriverEntryPointByVersion(name, &found, 10020, cudaEnableDefault, &result));
#else
  WARPSCOPE_CUDA_CHECK(cudaGetDriverEntryPoint(name, &found, cudaEnableDefault, &result));
#endif
  if (result != cudaDriverEntryPointSuccess || found == nullptr) throw DeviceError(std::string("the CUDA driver has no ") + name);
  return reinterpret_cast<Function*>(found);
}

struct Driver {
  decltype(cuGetErrorString)* getErrorString = driverFunction<decltype(cuGetErrorString)>("cuGetErrorString");
  decltype(cuDeviceGetAttribute)* getAttribute = driverFunction<decltype(cuDeviceGetAttribute)>("cuDeviceGetAttribute");
  decltype(cuMemGetAllocationGranularity)* getGranularity = driverFunction<decltype(cuMemGetAllocationGranularity)>("cuMemGetAllocationGranularity");
  decltype(cuMemAddressReserve)* reserve = driverFunction<decltype(cuMemAddressReserve)>("cuMemAddressReserve");
  decltype(cuMemAddressFree)* free = driverFunction<decltype(cuMemAddressFree)>("cuMemAddressFree");
  decltype(cuMemCreate)* create = driverFunction<decltype(cuMemCreate)>("cuMemCreate");
  decltype(cuMemRelease)* release = driverFunction<decltype(cuMemRelease)>("cuMemRelease");
  decltype(cuMemMap)* map = driverFunction<decltype(cuMemMap)>("cuMemMap");
  decltype(cuMemUnmap)* unmap = driverFunction<decltype(cuMemUnmap)>("cuMemUnmap");
  decltype(cuMemSetAccess)* setAccess = driverFunction<decltype(cuMemSetAccess)>("cuMemSetAccess");

  static const Driver& instance() {
    static const Driver driver;
    return driver;
  }
  void check(CUresult result, const char* what) const {
    if (result == CUDA_SUCCESS) return;
    const char* text = nullptr;
    getErrorString(result, &text);
    throw DeviceError(std::string(what) + ": " + (text != nullptr ? text : "CUDA error " + std::to_string(result)));
  }
};

CUmemLocation locationOf(int device) {
  CUmemLocation location{};
  location.type = CU_MEM_LOCATION_TYPE_DEVICE;
  location.id = device;
  return location;
}
CUmemAllocationProp propertiesOf(int device) {
  CUmemAllocationProp properties{};
  properties.type = CU_MEM_ALLOCATION_TYPE_PINNED;
  properties.location = locationOf(device);
  return properties;
}
CUdeviceptr addressOf(const std::byte* data) { return reinterpret_cast<CUdeviceptr>(data); }

}  // namespace

SparseMemory::SparseMemory(size_t bytes) {
  WARPSCOPE_CUDA_CHECK(cudaGetDevice(&device_));
  WARPSCOPE_CUDA_CHECK(cudaFree(nullptr));  // makes the device's context
  const Driver& driver = Driver::instance();
  int isSupported = 0;
  driver.check(driver.getAttribute(&isSupported, CU_DEVICE_ATTRIBUTE_VIRTUAL_MEMORY_MANAGEMENT_SUPPORTED, device_), "asking for virtual memory management");
  if (isSupported == 0) throw DeviceError("the device has no virtual memory management, by which it would hold a part of a volume");
  const CUmemAllocationProp properties = propertiesOf(device_);
  driver.check(driver.getGranularity(&granularity_, &properties, CU_MEM_ALLOC_GRANULARITY_MINIMUM), "asking how memory is divided");
  reservedBytes_ = (std::max<size_t>(bytes, 1) + granularity_ - 1) / granularity_ * granularity_;
  CUdeviceptr address = 0;
  driver.check(driver.reserve(&address, reservedBytes_, 0, 0, 0), "reserving addresses");
  data_ = reinterpret_cast<std::byte*>(address);
}

SparseMemory::~SparseMemory() {
  release();
  Driver::instance().free(addressOf(data_), reservedBytes_);
}

void SparseMemory::back(size_t begin, size_t end) {
  size_t from = begin / granularity_ * granularity_;
  const size_t to = (end + granularity_ - 1) / granularity_ * granularity_;
  while (from < to) {
    const auto next = parts_.upper_bound(from);
    if (next != parts_.begin()) {
      const auto& [first, part] = *std::prev(next);
      if (first + part.bytes > from) {
        from = first + part.bytes;
        continue;
      }
    }
    const size_t gapEnd = next != parts_.end() ? std::min(next->first, to) : to;
    backUnbacked(from, gapEnd);
    from = gapEnd;
  }
}

void SparseMemory::backUnbacked(size_t begin, size_t end) {
  const Driver& driver = Driver::instance();
  const CUmemAllocationProp properties = propertiesOf(device_);
  CUmemGenericAllocationHandle handle = 0;
  driver.check(driver.create(&handle, end - begin, &properties, 0), "taking memory of the device");
  const CUdeviceptr at = addressOf(data_ + begin);
  if (const CUresult result = driver.map(at, end - begin, 0, handle, 0); result != CUDA_SUCCESS) {
    driver.release(handle);
    driver.check(result, "mapping memory of the device");
  }
  parts_[begin] = {end - begin, handle};
  backedBytes_ += end - begin;
  const CUmemAccessDesc access{locationOf(device_), CU_MEM_ACCESS_FLAGS_PROT_READWRITE};
  driver.check(driver.setAccess(at, end - begin, &access, 1), "opening memory of the device");
}

void SparseMemory::release() noexcept {
  const Driver& driver = Driver::instance();
  for (const auto& [begin, part] : parts_) {
    driver.unmap(addressOf(data_ + begin), part.bytes);
    driver.release(part.handle);
  }
  parts_.clear();
  backedBytes_ = 0;
}

}  // namespace warpscope::cuda

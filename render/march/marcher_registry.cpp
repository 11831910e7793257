// The registry of marchers and the choice between them.
// See marcher_registry.h. A new marcher is one file pair and one line here.
#include "render/march/marcher_registry.h"

#include <utility>

#include "render/base/error.h"
#include "render/base/nearest_name.h"
#include "render/cuda/devices.h"
#include "render/march/fallback_marcher.h"
#include "render/march/piece_marcher_cuda.h"
#include "render/march/streamed_marcher.h"

namespace warpscope {
namespace {

std::string everywhere() { return {}; }

constexpr MarcherDescriptor kMarchers[] = {
    {"cpu", "CPU", "all cores of the processor: every machine", Backend::cpu, everywhere, makeFittingCpuMarcher},
    {"cuda", "CUDA", "the first NVIDIA GPU", Backend::cuda, cuda::whyUnavailable, makeFittingCudaMarcher},
};

using Makers = std::vector<std::function<MarcherPtr()>>;

/// The first of the makers from `at` on, left for those behind it.
MarcherPtr makeWithFallback(const Makers& makers, size_t at,
                            const std::function<void(const std::string&)>& onFallback) {
  if (at + 1 == makers.size()) return makers[at]();
  return makeFallbackMarcher(
      makers[at], [=] { return makeWithFallback(makers, at + 1, onFallback); }, onFallback);
}

}  // namespace

MarcherTable marcherRegistry() { return kMarchers; }

const MarcherDescriptor& findMarcher(std::string_view name) {
  if (const MarcherDescriptor* marcher = findNamed(kMarchers, name)) return *marcher;
  throw UsageError(unknownNameIn(kMarchers, "backend", name));
}

std::vector<const MarcherDescriptor*> marchersFor(Backend backend, MarcherTable table) {
  std::vector<const MarcherDescriptor*> usable;
  std::string reasons;
  for (size_t i = table.size(); i-- > 0;) {
    const MarcherDescriptor& marcher = table[i];
    if (backend != Backend::automatic && marcher.backend != backend) continue;
    if (const std::string reason = marcher.whyUnavailable(); reason.empty())
      usable.push_back(&marcher);
    else
      reasons += (reasons.empty() ? "the backend " : "; the backend ") + std::string(marcher.name) +
                 " cannot be used: " + reason;
  }
  if (usable.empty())
    throw DeviceError(reasons.empty() ? "there is no backend " + std::string(nameOf(backend)) : reasons);
  return usable;
}

MarcherPtr makeMarcher(Backend backend, VolumePtr volume, TransferFunction transferFunction,
                       std::function<void(const std::string& reason)> onFallback, MarcherTable table) {
  Makers makers;
  for (const MarcherDescriptor* marcher : marchersFor(backend, table))
    makers.push_back([make = marcher->make, volume, transferFunction] { return make(volume, transferFunction); });
  return makeWithFallback(makers, 0, onFallback);
}

}  // namespace warpscope

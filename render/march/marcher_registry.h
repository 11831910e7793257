// What can march on this machine: one line for each way, the choice between them, and leaving one that fails.
// Backends: core/backend.h.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/march/marcher.h"

namespace warpscope {

struct MarcherDescriptor {
  std::string_view name;            ///< as the command line says it
  std::string_view label;           ///< as a person reads it
  std::string_view summary;         ///< one line for help texts
  Backend backend;                  ///< that stands for it in settings
  std::string (*whyUnavailable)();  ///< why it cannot be used on this machine; empty if it can
  MarcherPtr (*make)(VolumePtr, TransferFunction);
};

using MarcherTable = std::span<const MarcherDescriptor>;

/// Every marcher, the fastest last.
MarcherTable marcherRegistry();

/// The named marcher; throws UsageError that lists the nearest names.
const MarcherDescriptor& findMarcher(std::string_view name);

/// Those that `backend` lets march on this machine, the fastest first: the named one, or of automatic all that can be
/// used. Throws DeviceError with the reason if there is none.
std::vector<const MarcherDescriptor*> marchersFor(Backend backend, MarcherTable table = marcherRegistry());

/// The first of marchersFor(). Where `backend` is automatic it is left for the next from the moment that its device
/// fails, its making included; `onFallback` (may be empty) is then told the reason, once, on the thread that met it.
/// Throws as marchersFor() and the makers do.
MarcherPtr makeMarcher(Backend backend, VolumePtr volume, TransferFunction transferFunction,
                       std::function<void(const std::string& reason)> onFallback,
                       MarcherTable table = marcherRegistry());

}  // namespace warpscope

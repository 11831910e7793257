// What a frame may say of its samples beside position, radius and colour: planes, one value a sample.
// A frame's head names its planes. A reader leaves out those that it does not know, by name and length in bytes, and keeps the rest.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "render/core/transfer_vector.h"

namespace warpscope {

/// What one value is; little-endian in memory and on the wire.
enum class PlaneElement : uint8_t { uint8, uint16, float32 };

/// 0 for an element that this program does not know.
constexpr size_t bytesOf(PlaneElement element) {
  switch (element) {
    case PlaneElement::uint8: return 1;
    case PlaneElement::uint16: return 2;
    case PlaneElement::float32: return 4;
  }
  return 0;
}

struct SamplePlane {
  std::string name;  ///< 1..kMaxPlaneName bytes; no two planes of a frame have the same
  PlaneElement element = PlaneElement::uint8;
  TransferVector<std::byte> values;  ///< bytesOf(element) for each sample

  bool operator==(const SamplePlane&) const = default;
};

inline constexpr size_t kMaxPlanes = 16;  ///< of a frame
inline constexpr size_t kMaxPlaneName = 32;

struct KnownPlane {
  std::string_view name;
  PlaneElement element;
  std::string_view unit;  ///< empty where it is a plain number
  std::string_view summary;
};

inline constexpr std::string_view kLayerPlane = "layer";
inline constexpr std::string_view kExtentPlane = "extent";
inline constexpr std::string_view kSpreadPlane = "spread";

/// Every plane that this program reads. A new one is one line here.
inline constexpr std::array<KnownPlane, 3> kKnownPlanes{{
    {kLayerPlane, PlaneElement::uint8, "", "how many samples of the same ray are in front: 0 begins a ray, each further one counts up by 1"},
    {kExtentPlane, PlaneElement::float32, "volume units", "length along the ray that the sample stands for"},
    {kSpreadPlane, PlaneElement::float32, "volume units", "standard deviation of depth along the ray about its mean, by contribution, in 8 significant bits: how uncertain the depth is"},
}};

/// A plane of that name whose values are of another kind is not known either.
constexpr bool isKnown(std::string_view name, PlaneElement element) {
  for (const KnownPlane& known : kKnownPlanes)
    if (known.name == name) return known.element == element;
  return false;
}

}  // namespace warpscope

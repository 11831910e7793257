// Planes as bytes and back: every element, along layers and without; whatever else than a plane is refused.
// Mirrors render/codec/plane_coding.h.
#include "render/codec/plane_coding.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "render/codec/bytes.h"

namespace warpscope {
namespace {

constexpr PlaneElement kElements[] = {PlaneElement::uint8, PlaneElement::uint16, PlaneElement::float32};

SamplePlane randomPlane(PlaneElement element, size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  SamplePlane plane{"some", element, {}};
  plane.values.resize(count * bytesOf(element));
  for (std::byte& byte : plane.values) byte = static_cast<std::byte>(random());
  return plane;
}

std::vector<uint8_t> someLayers(size_t count) {
  std::vector<uint8_t> layers(count);
  for (size_t i = 0; i < count; ++i) layers[i] = static_cast<uint8_t>(i % 3);
  return layers;
}

/// Empty if what comes back is what went in.
std::string roundTrip(const SamplePlane& plane, std::span<const uint8_t> layers) {
  ByteVector bytes;
  appendPlane(bytes, plane, layers);
  SamplePlane again{plane.name, plane.element, {}};
  if (const DecodeError error = takePlane(bytes, plane.values.size() / bytesOf(plane.element), layers, again)) return *error;
  return again == plane ? "" : "other values";
}

TEST(PlaneCoding, EveryValueOfEveryElementComesBack) {
  for (const PlaneElement element : kElements)
    for (const size_t count : {size_t{0}, size_t{1}, size_t{1000}, kPlanePiece, kPlanePiece + 1, 2 * kPlanePiece + 77}) {
      const SamplePlane plane = randomPlane(element, count, static_cast<uint32_t>(count));
      EXPECT_EQ(roundTrip(plane, {}), "") << count;
      EXPECT_EQ(roundTrip(plane, someLayers(count)), "") << count;
    }
}

TEST(PlaneCoding, WhatChangesSlowlyAlongALayerTakesFewBytes) {
  // Each layer has a level of its own, far from the others', and changes by little.
  std::vector<float> extents;
  const std::vector<uint8_t> layers = someLayers(30'000);
  for (size_t i = 0; i < layers.size(); ++i) extents.push_back(100.0f * static_cast<float>(layers[i] + 1) + 0.25f * static_cast<float>(i / 64 % 8));
  SamplePlane plane{std::string(kExtentPlane), PlaneElement::float32, {}};
  plane.values.resize(extents.size() * sizeof(float));
  std::memcpy(plane.values.data(), extents.data(), plane.values.size());
  ByteVector along, across;
  appendPlane(along, plane, layers);
  appendPlane(across, plane, {});
  EXPECT_EQ(roundTrip(plane, layers), "");
  EXPECT_LT(along.size(), extents.size() / 8);
  EXPECT_LT(2 * along.size(), across.size());
}

TEST(PlaneCoding, CutShortAtAnyByteItIsRefused) {
  const SamplePlane plane = randomPlane(PlaneElement::uint16, 50, 3);
  ByteVector bytes;
  appendPlane(bytes, plane, {});
  SamplePlane again{plane.name, plane.element, {}};
  for (size_t length = 0; length < bytes.size(); ++length)
    EXPECT_NE(takePlane(std::span(bytes).first(length), 50, {}, again), std::nullopt) << length;
  bytes.push_back(std::byte{0});
  EXPECT_NE(takePlane(bytes, 50, {}, again), std::nullopt);
}

TEST(PlaneCoding, OtherNumbersOfValuesAreRefused) {
  const SamplePlane plane = randomPlane(PlaneElement::float32, 500, 4);
  ByteVector bytes;
  appendPlane(bytes, plane, {});
  for (const size_t count : {size_t{0}, size_t{1}, size_t{499}, size_t{501}, kPlanePiece + 1}) {
    SamplePlane again{plane.name, plane.element, {}};
    EXPECT_NE(takePlane(bytes, count, {}, again), std::nullopt) << count;
  }
}

TEST(PlaneCoding, NothingIsAllocatedForPiecesThatAreNotThere) {
  SamplePlane plane{"some", PlaneElement::float32, {}};
  const size_t claimed = size_t{1} << 26;
  ByteVector bytes;
  EXPECT_NE(takePlane(bytes, claimed, {}, plane), std::nullopt);
  EXPECT_EQ(plane.values.capacity(), 0u);
  // A list of all pieces, whose lengths lead beyond the end.
  for (size_t piece = 0; piece < claimed / kPlanePiece; ++piece) appendLittle(bytes, uint32_t{0x3fffffff});
  EXPECT_NE(takePlane(bytes, claimed, {}, plane), std::nullopt);
  EXPECT_EQ(plane.values.capacity(), 0u);
}

}  // namespace
}  // namespace warpscope

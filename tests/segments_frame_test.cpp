// Segments from the march to the picture: what marchers find, the codec's way and back, damage, the technique in the server's own view and beside it, light for
// another camera.
// Mirrors render/codec/segment_coding.h, render/codec/proxy_coding.h, render/effects/relight.h and render/warp/segments_warp.h.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "codec_frames.h"
#include "marcher_cases.h"
#include "render/base/error.h"
#include "render/codec/codec.h"
#include "render/codec/payload_hash.h"
#include "render/codec/proxy_coding.h"
#include "render/effects/relight.h"
#include "render/effects/shading_setup.h"
#include "render/metrics/psnr.h"
#include "render/volume/proxy.h"
#include "render/warp/fill.h"
#include "render/warp/segments/segment_field_build.h"
#include "render/warp/warp.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

const glm::uvec3 kDims(48, 44, 40);

TransferFunction colorful(float alpha) {
  return {{{15.0, {0.2f, 0.4f, 1.0f}, 0.0f}, {40.0, {0.9f, 0.8f, 0.3f}, 0.3f * alpha}, {80.0, {1.0f, 0.3f, 0.1f}, alpha}}};
}

MarcherPtr blobMarcher(float alpha = 0.5f, VoxelType type = VoxelType::uint8) {
  return makeCpuMarcher(makeTestVolume(type, kDims, blobs(kDims, 11)), colorful(alpha));
}

/// Two balls without any roughness, one in front of the other.
MarcherPtr ballMarcher(float alpha) {
  const FieldFunction balls = [](const glm::ivec3& p) {
    const double big = 1.0 - glm::length(glm::dvec3(p) - glm::dvec3(22.0, 22.0, 16.0)) / 18.0, small = 1.0 - glm::length(glm::dvec3(p) - glm::dvec3(30.0, 24.0, 32.0)) / 9.0;
    return 100.0 * std::max({big, small, 0.0});
  };
  return makeCpuMarcher(makeTestVolume(VoxelType::uint8, kDims, balls), colorful(alpha));
}

MarchSettings segmented(int segments, int proxy = 0) {
  MarchSettings settings;
  settings.sample.segments = segments;
  settings.sample.proxy = proxy;
  return settings;
}

const Camera kBlobsCamera = lookingFrom({30.0f, 25.0f, 75.0f}, glm::vec3(0.0f), 160, 120, 0.45f);

WarpedImage warped(const SampleFramePtr& frame, const Camera& camera, std::string_view technique = "segments", const WarpSettings& settings = {}) {
  WarpResources resources;
  const std::unique_ptr<Warp> warp = findWarp(technique).make(resources);
  warp->setFrame(frame, settings);
  WarpedImage image;
  warp->draw(camera, settings, image);
  return image;
}

double psnrAgainst(Marcher& marcher, const MarchSettings& settings, const Camera& camera, const WarpedImage& image) {
  Image<glm::vec4> reference;
  marcher.render(camera, settings.render, reference);
  return psnrSrgb(image.color, reference, glm::vec3(0.0f));
}

SampleFramePtr marched(const MarcherPtr& marcher, const MarchSettings& settings, const Camera& camera = kBlobsCamera) {
  return std::make_shared<const SampleFrame>(marcher->march(camera, settings));
}

bool sameSegments(const FrameSegments& a, const FrameSegments& b) {
  return a.rays == b.rays && a.depths == b.depths && a.colors == b.colors && a.normals == b.normals;
}
TEST(SegmentsOfAMarch, AreAsManyAsWereAskedForAndLeaveSamplesAlone) {
  const MarcherPtr marcher = blobMarcher();
  const SampleFrame without = marcher->march(kBlobsCamera, segmented(0));
  EXPECT_TRUE(without.segments.empty());
  for (const int most : {1, 3, 16}) {
    const SampleFrame frame = marcher->march(kBlobsCamera, segmented(most));
    EXPECT_EQ(frame.samples, without.samples);
    EXPECT_EQ(frame.colors, without.colors);
    ASSERT_EQ(frame.segments.rays.size(), size_t{160} * 120);
    int highest = 0;
    size_t covered = 0;
    for (const RaySegmentCount ray : frame.segments.rays) {
      highest = std::max(highest, ray.count());
      covered += ray.count() > 0;
    }
    EXPECT_EQ(highest, most);
    EXPECT_GE(covered, frame.size() * 98 / 100);  // hardly visible ones round to nothing
    EXPECT_TRUE(frame.segments.normals.empty());  // nothing is lit
  }
}

TEST(SegmentsOfAMarch, RaysThatEndSayThatTheyDid) {
  const MarcherPtr marcher = blobMarcher(1.0f);
  MarchSettings settings = segmented(2);
  const auto ended = [](const SampleFrame& frame) {
    return std::ranges::count_if(frame.segments.rays, [](RaySegmentCount ray) { return ray.isEnded(); });
  };
  EXPECT_GT(ended(marcher->march(kBlobsCamera, settings)), 300);
  settings.render.terminateEarly = false;
  EXPECT_EQ(ended(marcher->march(kBlobsCamera, settings)), 0);
}

TEST(SegmentsOfAMarch, EveryModeHasSome) {
  for (const RenderMode mode : {RenderMode::composite, RenderMode::mip, RenderMode::isosurface}) {
    MarchSettings settings = segmented(4);
    settings.render.effects.mode = mode;
    settings.render.effects.isoValues = parseIsoValues("50@0.5", "it");
    const MarcherPtr marcher = blobMarcher();
    const SampleFramePtr frame = marched(marcher, settings);
    EXPECT_GT(frame->segments.size(), 1000u);
    // Own pictures are the frame's, up to 8 bits.
    EXPECT_GT(psnrAgainst(*marcher, settings, kBlobsCamera, warped(frame, kBlobsCamera)), 50.0) << static_cast<int>(mode);
  }
}

TEST(SegmentCodec, ComesBackInEveryFormatFromEveryKindOfMarch) {
  for (const VoxelType type : {VoxelType::uint8, VoxelType::float32})
    for (const float shading : {0.0f, 1.0f})
      for (const char* clip : {"none", "1,0.2,0,0"}) {
        MarchSettings settings = segmented(5, 16);
        settings.render.effects.shading.strength = shading;
        settings.render.effects.jitter = 0.5f;
        settings.render.effects.clip.planes = parseClipPlanes(clip, "it");
        const SampleFrame frame = blobMarcher(0.6f, type)->march(kBlobsCamera, settings);
        EXPECT_EQ(frame.segments.normals.empty(), shading == 0.0f);
        for (const PayloadFormat format : {PayloadFormat::raw, PayloadFormat::packed, PayloadFormat::tiled}) {
          FrameCodec codec;
          CodecSettings coding;
          coding.format = format;
          coding.color = ColorCoding::lossless;
          const ByteVector payload = codec.encode(frame, coding);
          EXPECT_LE(payload.size(), mostPayloadBytes(frame, frame.size(), coding));
          // What each part takes is known from the encoding, and from the decoding: as much as its absence saves.
          const FrameBytes bytes = codec.bytes();
          EXPECT_EQ(bytes.all(), payload.size());
          EXPECT_EQ(bytes.proxy, proxyBytesOf(*frame.proxy));
          SampleFrame bare = frame;
          bare.settings.sample.segments = bare.settings.sample.proxy = 0;
          bare.segments = {};
          bare.proxy.reset();
          EXPECT_EQ(bytes.samples, FrameCodec().encode(bare, coding).size());
          SampleFrame back = headOf(frame);
          FrameCodec receiver;
          ASSERT_EQ(receiver.decode(payload, frame.size(), back), std::nullopt);
          EXPECT_EQ(receiver.bytes(), bytes);
          EXPECT_TRUE(sameSegments(back.segments, frame.segments));
          EXPECT_EQ(back.samples, frame.samples);
          ASSERT_TRUE(back.proxy);
          EXPECT_EQ(back.proxy->function, frame.proxy->function);
          EXPECT_EQ(back.proxy->scale, frame.proxy->scale);
          EXPECT_EQ(back.proxy->isExact, frame.proxy->isExact);
          EXPECT_EQ(back.proxy->volume->bounds().upper, frame.proxy->volume->bounds().upper);
          EXPECT_TRUE(std::equal(back.proxy->volume->voxelsAs<uint8_t>(), back.proxy->volume->voxelsAs<uint8_t>() + back.proxy->volume->voxelCount(),
                                 frame.proxy->volume->voxelsAs<uint8_t>()));
        }
      }
}

TEST(SegmentCodec, TakesFewBytesForWhatLiesOnTheLattice) {
  const SampleFrame frame = blobMarcher()->march(kBlobsCamera, segmented(4));
  FrameCodec codec;
  CodecSettings coding;
  coding.color = ColorCoding::lossless;
  const SampleFrame plain = blobMarcher()->march(kBlobsCamera, segmented(0));
  const size_t bytes = codec.encode(frame, coding).size() - codec.encode(plain, coding).size();
  EXPECT_LT(static_cast<double>(bytes), 5.0 * static_cast<double>(frame.segments.size()));
}

/// And opacities within three codes; what is nearly all or nearly nothing as it is.
TEST(SegmentCodec, JpegKeepsDepths) {
  for (const float alpha : {0.05f, 0.5f, 1.0f}) {
    const SampleFrame frame = blobMarcher(alpha)->march(kBlobsCamera, segmented(3));
    FrameCodec codec;
    const ByteVector payload = codec.encode(frame, {});
    SampleFrame back = headOf(frame);
    ASSERT_EQ(codec.decode(payload, frame.size(), back), std::nullopt);
    EXPECT_EQ(back.segments.depths, frame.segments.depths);
    ASSERT_EQ(back.segments.colors.size(), frame.segments.colors.size());
    size_t rounded = 0;
    for (size_t i = 0; i < back.segments.colors.size(); ++i) {
      const int sent = static_cast<int>(frame.segments.colors[i] >> 24), found = static_cast<int>(back.segments.colors[i] >> 24);
      const bool isKept = sent < 8 || sent > 249;
      ASSERT_LE(std::abs(sent - found), isKept ? 0 : 3);
      rounded += sent != found;
    }
    EXPECT_GT(rounded, back.segments.colors.size() / 10);
  }
}

/// Colours with loss are in the frame's own view as good as those of one picture by that quality are, about, whatever lies behind what.
TEST(SegmentCodec, JpegIsCoarserWhereLessIsSeen) {
  for (const float alpha : {0.05f, 0.5f, 1.0f}) {
    const MarcherPtr marcher = blobMarcher(alpha);
    const MarchSettings settings = segmented(4);
    const SampleFrame frame = marcher->march(kBlobsCamera, settings);
    FrameCodec codec;
    double last = 0.0;
    size_t bytes = 0;
    for (const int quality : {40, 75, 95}) {
      CodecSettings coding;
      coding.jpegQuality = quality;
      SampleFrame back = headOf(frame);
      const ByteVector payload = codec.encode(frame, coding);
      ASSERT_EQ(codec.decode(payload, frame.size(), back), std::nullopt);
      EXPECT_GT(payload.size(), bytes);
      bytes = payload.size();
      const double psnr = psnrAgainst(*marcher, settings, kBlobsCamera, warped(std::make_shared<const SampleFrame>(std::move(back)), kBlobsCamera));
      EXPECT_GT(psnr, last) << alpha << ", " << quality;
      last = psnr;
    }
    EXPECT_GT(last, 42.0) << alpha;
  }
}

TEST(SegmentCodec, CopiesAreWhatTheySayTheyAre) {
  for (const auto& [type, longest, isExact] : {std::tuple(VoxelType::uint8, 48, true), {VoxelType::uint8, 24, false}, {VoxelType::float32, 48, false}}) {
    const Proxy copy = makeProxy(*makeTestVolume(type, kDims, blobs(kDims, 11)), colorful(0.5f), longest, CopyFilter::leastSquares);
    ByteVector bytes;
    appendProxy(bytes, copy);
    ProxyPtr back;
    ASSERT_EQ(takeProxy(bytes, longest, back), std::nullopt);
    EXPECT_EQ(back->isExact, isExact);
    // Behind dimensions, geometry and the codes' scale. What has steps that are not whole is not exact, whatever is said, and nothing else may be said.
    constexpr size_t kFacts = 3 * 4 + 18 * 8;
    ASSERT_EQ(bytes[kFacts], std::byte{static_cast<uint8_t>(isExact ? 2 : 0)});
    for (const uint8_t said : {2, 3, 4, 255}) {
      bytes[kFacts] = std::byte{said};
      const DecodeError error = takeProxy(bytes, longest, back);
      EXPECT_EQ(error.has_value(), said != 2 || copy.scale.perCode != 1.0) << static_cast<int>(said);
    }
  }
}

TEST(SegmentCodec, DamageIsFoundAndNothingIsTakenOnTrust) {
  const SampleFrame frame = blobMarcher()->march(lookingFrom({30.0f, 25.0f, 75.0f}, glm::vec3(0.0f), 40, 30, 0.45f), segmented(3, 8));
  std::mt19937 random(3);
  for (const PayloadFormat format : {PayloadFormat::raw, PayloadFormat::packed, PayloadFormat::tiled}) {
    FrameCodec codec;
    CodecSettings coding;
    coding.format = format;
    const ByteVector payload = codec.encode(frame, coding);
    size_t refused = 0;
    for (int round = 0; round < 600; ++round) {
      ByteVector damaged = payload;
      if (round % 3 == 0)
        damaged.resize(9 + random() % (damaged.size() - 9));
      else
        for (int k = 0; k < 3; ++k) damaged[9 + random() % (damaged.size() - 9)] = static_cast<std::byte>(random());
      sealPayload(damaged);  // who means harm would
      SampleFrame back = headOf(frame);
      const DecodeError error = codec.decode(damaged, frame.size(), back);
      if (error) {
        ++refused;
        EXPECT_FALSE(error->empty());
        EXPECT_TRUE(back.segments.empty());
      } else {
        // What is let through can be drawn.
        const auto drawn = std::make_shared<const SampleFrame>(std::move(back));
        const WarpedImage image = warped(drawn, lookingFrom({50.0f, 5.0f, 65.0f}, glm::vec3(0.0f), 20, 15, 0.45f));
        for (const glm::vec4& color : image.color) EXPECT_TRUE(std::isfinite(color.r + color.g + color.b + color.a));
      }
    }
    EXPECT_GT(refused, 250u);
    DecodeLimits few;
    few.maxSegments = 10;
    SampleFrame back = headOf(frame);
    EXPECT_NE(codec.decode(payload, frame.size(), back, few), std::nullopt);
  }
}

TEST(SegmentCodec, FramesThatAreNoneAreRefused) {
  const SampleFrame frame = blobMarcher()->march(kBlobsCamera, segmented(3));
  const auto expectRefused = [&](const auto& change) {
    SampleFrame wrong = frame;
    change(wrong);
    EXPECT_THROW(FrameCodec().encode(wrong, {}), InputError);
  };
  expectRefused([](SampleFrame& f) { f.segments.rays.pop_back(); });
  expectRefused([](SampleFrame& f) { f.segments.depths.pop_back(); });
  expectRefused([](SampleFrame& f) { f.segments.colors.pop_back(); });
  expectRefused([](SampleFrame& f) { f.segments.normals.resize(3); });
  expectRefused([](SampleFrame& f) { f.segments.depths[0].end = 0, f.segments.depths[0].begin = 9; });
  expectRefused([](SampleFrame& f) { f.segments.depths.back().end = kDepthCodeMax + 1; });
  expectRefused([](SampleFrame& f) { f.settings.sample.segments = 2; });
  expectRefused([](SampleFrame& f) { f.settings.sample.segments = 0; });
  expectRefused([](SampleFrame& f) { f.settings.sample.proxy = 8; });
}

TEST(SegmentsWarp, TheServersOwnViewIsTheFramesToACodeValue) {
  for (const float alpha : {0.05f, 0.5f, 1.0f})
    for (const float shading : {0.0f, 1.0f})
      for (const int most : {1, 4, 16}) {
        const MarcherPtr marcher = blobMarcher(alpha);
        MarchSettings settings = segmented(most, 16);
        settings.render.effects.shading.strength = shading;
        const SampleFramePtr frame = marched(marcher, settings);
        const WarpedImage image = warped(frame, kBlobsCamera);
        Image<glm::vec4> reference;
        marcher->render(kBlobsCamera, settings.render, reference);
        const ColorTables& tables = ColorTables::instance();
        size_t different = 0;
        for (size_t i = 0; i < image.color.size(); ++i) {
          const Rgba8 a = tables.encodeOver(image.color[i], glm::vec3(0.0f)), b = tables.encodeOver(reference[i], glm::vec3(0.0f));
          for (const int shift : {0, 8, 16}) different += std::abs(static_cast<int>(a >> shift & 255) - static_cast<int>(b >> shift & 255)) > 1;
        }
        EXPECT_LT(different, image.color.size() / 1000) << alpha << ", " << shading << ", " << most;
        EXPECT_GT(psnrAgainst(*marcher, settings, kBlobsCamera, image), 50.0) << alpha << ", " << shading << ", " << most;
      }
}

TEST(SegmentsWarp, BesideItIsFarBetterThanSpheres) {
  const Camera beside = lookingFrom({43.0f, 25.0f, 68.0f}, glm::vec3(0.0f), 160, 120, 0.45f);
  for (const float alpha : {0.05f, 0.5f}) {
    const MarcherPtr marcher = blobMarcher(alpha);
    const MarchSettings settings = segmented(8, 24);
    const SampleFramePtr frame = marched(marcher, settings);
    EXPECT_GT(psnrAgainst(*marcher, settings, beside, warped(frame, beside)), psnrAgainst(*marcher, settings, beside, warped(frame, beside, "spheres")) + 8.0);
  }
}

TEST(SegmentsWarp, LightGoesWithTheCamera) {
  const Camera beside = lookingFrom({70.0f, 25.0f, 40.0f}, glm::vec3(0.0f), 160, 120, 0.45f);
  const MarcherPtr marcher = ballMarcher(0.9f);
  MarchSettings settings = segmented(4, 24);
  settings.render.effects.shading.strength = 1.0f;
  auto frame = std::make_shared<SampleFrame>(marcher->march(kBlobsCamera, settings));
  ASSERT_EQ(frame->segments.normals.size(), frame->segments.size());
  const double with = psnrAgainst(*marcher, settings, beside, warped(frame, beside));
  auto without = std::make_shared<SampleFrame>(*frame);
  without->segments.normals.clear();
  EXPECT_GT(with, psnrAgainst(*marcher, settings, beside, warped(without, beside)) + 1.5);
  // Lights of the world that shine evenly have no need of normals.
  settings.render.effects.lights = parseLights("world:1,1,1", "it");
  settings.render.effects.shading.specular = 0.0f;
  EXPECT_TRUE(marcher->march(kBlobsCamera, settings).segments.normals.empty());
}

/// Lights that stay in the world are where they are whether the copy of the volume comes along or not.
TEST(SegmentsWarp, LightsOfTheWorldStayWhereTheyAreWithoutTheCopy) {
  const Camera beside = lookingFrom({70.0f, 25.0f, 40.0f}, glm::vec3(0.0f), 160, 120, 0.45f);
  VolumeGeometry geometry;
  geometry.dims = kDims;
  geometry.spacing = glm::dvec3(0.001);  // metres
  geometry.origin = {5.0, -3.0, 2.0};
  geometry.direction = glm::dmat3(glm::dvec3(0.0, 1.0, 0.0), glm::dvec3(0.0, 0.0, 1.0), glm::dvec3(1.0, 0.0, 0.0));
  const VolumePtr ball = makeTestVolume(VoxelType::uint8, kDims, [](const glm::ivec3& p) {
    return 100.0 * std::max(1.0 - glm::length(glm::dvec3(p) - glm::dvec3(23.5, 21.5, 19.5)) / 18.0, 0.0);
  });
  const auto volume = std::make_shared<const Volume>("ball", VoxelType::uint8, geometry, ball, ball->voxelsAs<uint8_t>());
  const MarcherPtr marcher = makeCpuMarcher(volume, colorful(0.9f));
  MarchSettings settings = segmented(4, 24);
  settings.render.effects.shading.strength = 1.0f;
  settings.render.effects.shading.specular = 0.6f;
  settings.render.effects.lights = parseLights("point:5.06,-2.97,2.05 world:0,0,1@0.5", "it");
  auto frame = std::make_shared<SampleFrame>(marcher->march(kBlobsCamera, settings));
  ASSERT_EQ(frame->segments.normals.size(), frame->segments.size());
  auto bare = std::make_shared<SampleFrame>(*frame);
  bare->proxy.reset();
  WarpSettings unfilled;
  unfilled.knobs.set(kFillKnob, Fill::none);
  EXPECT_TRUE(warped(frame, beside, "segments", unfilled).color == warped(bare, beside, "segments", unfilled).color);
  const Effects& effects = settings.render.effects;
  const ShadingSetup known = segmentLightsFor(*bare, beside), truth = prepareLights(effects.shading, effects.lights, geometry, beside);
  ASSERT_EQ(known.lightCount, 2);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(known.lights[i].vector, truth.lights[i].vector) << i;
  // In voxels, not in metres.
  EXPECT_GT(glm::length(known.lights[0].vector), 30.0f);
  EXPECT_GT(psnrAgainst(*marcher, settings, beside, warped(bare, beside)), 28.0);
}

/// What light made of a colour is taken away and given back: for every kind of light, from every side.
TEST(SegmentsWarp, UnlitColoursComeBackLit) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  Shading shading;
  shading.strength = 1.0f;
  const Camera camera = kBlobsCamera;
  for (const char* text : {"headlight", "camera:1,1,-1", "world:0,1,0", "point:20,30,40@0.7 headlight@0.3"}) {
    VolumeGeometry geometry;
    geometry.dims = kDims;
    const ShadingSetup setup = prepareLights(shading, parseLights(text, "it"), geometry, camera);
    for (int i = 0; i < 200; ++i) {
      const NormalCode normal = encodeNormal(glm::vec3(unit(random), unit(random), unit(random)));
      const glm::vec3 toEye = glm::normalize(glm::vec3(unit(random), unit(random), unit(random)) + glm::vec3(0.01f)), place = 20.0f * glm::vec3(unit(random), unit(random), unit(random));
      const LightFactors<float> factors = factorsOf(setup, normal, toEye, place);
      const glm::vec3 color = 0.5f + 0.5f * glm::vec3(unit(random), unit(random), unit(random)), back = unlit(factors, relit(factors, color));
      for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(back[channel], color[channel], 2e-5f) << text;
      if (factors.kept >= kLeastKept)
        for (int channel = 0; channel < 3; ++channel) EXPECT_FLOAT_EQ(relit(factors, color)[channel], factors.kept * color[channel] + factors.white);
    }
  }
}

/// A ball that is hidden behind another, seen from the side.
TEST(SegmentsWarp, WhatNoFrameHasSeenComesFromTheCopy) {
  const FieldFunction balls = [](const glm::ivec3& p) {
    const double front = 1.0 - glm::length(glm::dvec3(p) - glm::dvec3(24.0, 22.0, 28.0)) / 11.0, hidden = 1.0 - glm::length(glm::dvec3(p) - glm::dvec3(24.0, 22.0, 8.0)) / 8.0;
    return 100.0 * std::max({front, hidden, 0.0});
  };
  const MarcherPtr marcher = makeCpuMarcher(makeTestVolume(VoxelType::uint8, kDims, balls), colorful(1.0f));
  const Camera server = lookingFrom({0.0f, 0.0f, 75.0f}, glm::vec3(0.0f), 160, 120, 0.45f), side = lookingFrom({75.0f, 0.0f, 0.0f}, glm::vec3(0.0f), 160, 120, 0.45f);
  const MarchSettings with = segmented(4, 48), without = segmented(4);
  const double filled = psnrAgainst(*marcher, with, side, warped(marched(marcher, with, server), side));
  EXPECT_GT(filled, psnrAgainst(*marcher, without, side, warped(marched(marcher, without, server), side)) + 6.0);
}

TEST(SegmentsWarp, AFrameWithoutSegmentsCoversNothing) {
  const WarpedImage image = warped(marched(blobMarcher(), segmented(0)), kBlobsCamera);
  for (const uint32_t id : image.samples) EXPECT_EQ(id, kNoSample);
}

TEST(Normals, ComeBackWithinWhatTheirHeaderSaysWithoutTheirSign) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  double worst = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const glm::vec3 v = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    const NormalCode code = encodeNormal(v * 37.0f);
    ASSERT_NE(code, 0);
    EXPECT_EQ(encodeNormal(-v), code);
    const double cosine = std::abs(static_cast<double>(glm::dot(glm::normalize(decodeNormal(code)), v)));
    worst = std::max(worst, std::acos(std::min(cosine, 1.0)) * 180.0 / 3.14159265358979);
  }
  EXPECT_LT(worst, 0.6);
  EXPECT_EQ(encodeNormal(glm::vec3(0.0f)), 0);
  EXPECT_EQ(decodeNormal(0), glm::vec3(0.0f));
}

}  // namespace
}  // namespace warpscope

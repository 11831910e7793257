// Settings, frames and limits between the program and the network: what goes out comes back, and what could not be used is refused.
// Mirrors app/frames/wire_fields.h.
#include "app/frames/wire_fields.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <map>

#include "app/frames/backend.h"
#include "app/frames/color_bytes.h"
#include "headless.h"
#include "net/messages.h"
#include "render/base/error.h"
#include "render/march/march_knobs.h"

namespace warpscope {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

/// Some settings another than by default.
MarchSettings turned() {
  MarchSettings settings;
  settings.render = {.step = 0.1f, .contribution = 1.0f / 3.0f, .skipEmpty = false, .terminateEarly = false};
  settings.sample.heuristic = Heuristic::relThreshold;
  settings.sample.threshold = 0.7f;
  settings.sample.radiusPolicy = RadiusPolicy::opacity;
  settings.sample.radiusScale = 1.7f;
  settings.sample.samplesPerRay = 5;
  return settings;
}

template <class Call>
std::string refusal(Call call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

std::string refusalOf(const net::SettingFields& fields) {
  return refusal([&] { marchFrom(fields); });
}

TEST(WireFields, SettingsComeBack) {
  EXPECT_EQ(marchFrom(toFields(turned())), turned());
  EXPECT_EQ(marchFrom(toFields(MarchSettings{})), MarchSettings{});
  MarchSettings all;
  const auto expectBack = [&](auto turn) {
    MarchSettings one;
    turn(one);
    turn(all);
    EXPECT_NE(one, MarchSettings{});
    EXPECT_EQ(marchFrom(toFields(one)), one);
  };
  for (const MarchKnob& row : marchKnobs()) {
    SCOPED_TRACE(row.knob->key);
    const bool isChosen = row.knob->type == KnobType::choice || row.knob->type == KnobType::flag;
    const double lowest = isChosen ? 0.0 : row.knob->range.lowest, other = isChosen ? 1.0 : row.knob->range.highest;
    expectBack([&](MarchSettings& settings) { row.set(settings, row.knob->defaultValue == lowest ? other : lowest); });
  }
  std::map<std::string_view, std::string_view> written{
      {"lights", "headlight camera:1,2,3@0.5"}, {"clipPlanes", "1,0,0,-5"}, {"clipBox", "0,0,0,1,1,0.5"}, {"isovalues", "33.3@0.5 70"}};
  for (const MarchText& text : marchTexts()) {
    SCOPED_TRACE(text.key);
    ASSERT_TRUE(written.contains(text.key)) << "say one here";
    expectBack([&](MarchSettings& settings) { text.set(settings, written[text.key], "it"); });
  }
  EXPECT_EQ(marchFrom(toFields(all)), all);
  for (const auto& heuristic : kHeuristics)
    for (const auto& policy : kRadiusPolicies) {
      MarchSettings settings;
      settings.sample.heuristic = heuristic.value;
      settings.sample.radiusPolicy = policy.value;
      EXPECT_EQ(marchFrom(toFields(settings)), settings) << heuristic.name << " " << policy.name;
    }
  // Floats keep every bit.
  MarchSettings settings;
  settings.render.step = 0.001f;
  for (int i = 0; i < 5000; ++i) {
    settings.render.step = std::nextafter(1.0007f * settings.render.step, 1000.0f);
    ASSERT_EQ(marchFrom(toFields(settings)), settings) << settings.render.step;
  }
}

TEST(WireFields, SettingsHaveTheNamesOfTheOptions) {
  const auto field = [](const char* name, const char* value) { return ::testing::FieldsAre(name, value); };
  EXPECT_THAT(toFields(turned()),
              UnorderedElementsAre(field("step", "0.1"), field("contribution", "0.33333334"), field("skipEmpty", "false"),
                                   field("terminateEarly", "false"), field("heuristic", "rel-threshold"), field("threshold", "0.7"),
                                   field("radius", "opacity"), field("radiusScale", "1.7"), field("samplesPerRay", "5")));
}

TEST(WireFields, WhatIsAskedOfTheServerIsSaidWhereItIsAnything) {
  const MarchSettings march;
  EXPECT_EQ(toFields(march, ServerWishes{}), toFields(march)) << "servers that do not know it refuse what names it";
  EXPECT_EQ(wishesFrom(toFields(march)), ServerWishes{});
  for (const auto& [wishes, most] : {std::pair(ServerWishes{.movingMs = 40}, "10001"), std::pair(ServerWishes{.loadPercent = 75}, "91")}) {
    net::SettingFields fields = toFields(march, wishes);
    EXPECT_EQ(fields.size(), toFields(march).size() + 1);
    EXPECT_EQ(wishesFrom(fields), wishes);
    EXPECT_EQ(marchFrom(fields), march);
    for (const char* wrong : {"-1", "1.5", most, "nan", ""}) {
      fields.back().value = wrong;
      EXPECT_THROW(wishesFrom(fields), InputError) << wrong;
      EXPECT_THROW(marchFrom(fields), InputError) << wrong;
    }
  }
}

TEST(WireFields, SettingsThatAreNotSaidKeepTheirDefaults) {
  EXPECT_EQ(marchFrom({}), MarchSettings{});
  MarchSettings settings;
  settings.sample.samplesPerRay = 3;
  EXPECT_EQ(marchFrom({{"samplesPerRay", "3"}}), settings);
}

TEST(WireFields, SettingsThatAreNotKnownAreRefused) {
  EXPECT_THAT(refusalOf({{"step", "1"}, {"shadows", "soft"}}), HasSubstr("setting \"shadows\""));
  EXPECT_THAT(refusalOf({{"Step", "1"}}), HasSubstr("setting \"Step\""));
  EXPECT_THAT(refusalOf({{"heuristic", "best"}}), AllOf(HasSubstr("setting \"heuristic\""), HasSubstr("best")));
  EXPECT_THAT(refusalOf({{"radius", "1"}}), HasSubstr("setting \"radius\""));
  for (const char* value : {"", " ", "1 ", " 1", "0x1", "1,5", "one", "1e", "1.0.0", "1e999"})
    EXPECT_THAT(refusalOf({{"step", value}}), HasSubstr("setting \"step\"")) << value;
  EXPECT_THAT(refusalOf({{"step", std::string("1\0", 2)}}), HasSubstr("setting \"step\""));
  for (const char* value : {"", "1.5", "two"}) EXPECT_THAT(refusalOf({{"samplesPerRay", value}}), HasSubstr("setting \"samplesPerRay\"")) << value;
  for (const char* value : {"", "1", "True", "yes"}) EXPECT_THAT(refusalOf({{"skipEmpty", value}}), HasSubstr("setting \"skipEmpty\"")) << value;
}

TEST(WireFields, SettingsOutOfRangeAreRefused) {
  for (const char* value : {"0", "-1", "nan", "inf", "1001", "1e-30"})
    EXPECT_THAT(refusalOf({{"step", value}}), AllOf(HasSubstr("setting \"step\""), HasSubstr("0.001"), HasSubstr("1000"))) << value;
  for (const char* value : {"0", "9", "-1", "2147483647", "4294967297"})
    EXPECT_THAT(refusalOf({{"samplesPerRay", value}}), AllOf(HasSubstr("setting \"samplesPerRay\""), HasSubstr("8"))) << value;
}

SampleFrame someFrame() {
  SampleFrame frame;
  frame.camera.width = 20;
  frame.camera.height = 10;
  frame.quantization = {{glm::vec3(-1.0f), glm::vec3(1.0f)}, 0.5f, 3.0f, 0.25f};
  frame.settings = turned();
  frame.samples = {1, 2};
  frame.colors = {3, 4};
  frame.planes.push_back({std::string(kLayerPlane), PlaneElement::uint8, {std::byte{0}, std::byte{1}}});
  frame.planes.push_back({"future", PlaneElement::uint16, TransferVector<std::byte>(4)});
  return frame;
}

TEST(WireFields, HeadsOfFramesComeBack) {
  const SampleFrame frame = someFrame(), again = frameFrom(headOf(frame, {}));
  EXPECT_EQ(again.camera, frame.camera);
  EXPECT_EQ(again.settings, frame.settings);
  EXPECT_EQ(again.quantization, frame.quantization);
  ASSERT_EQ(again.planes.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(again.planes[i].name, frame.planes[i].name);
    EXPECT_EQ(again.planes[i].element, frame.planes[i].element);
    EXPECT_TRUE(again.planes[i].values.empty());
  }
}

TEST(WireFields, HeadsNameElementsThatAreNotKnown) {
  net::FrameHead head = headOf(someFrame(), {});
  head.planes.push_back({"from the future", 77});
  const SampleFrame frame = frameFrom(head);
  ASSERT_EQ(frame.planes.size(), 3u);
  EXPECT_EQ(bytesOf(frame.planes[2].element), 0u);
}

TEST(WireFields, AFrameHasAtMostAsManySamplesAsItsRaysMayHave) {
  SampleFrame frame = someFrame();
  for (int perRay = 1; perRay <= 8; ++perRay) {
    frame.settings.sample.samplesPerRay = perRay;
    EXPECT_EQ(decodeLimitsFor(frame).maxSamples, static_cast<size_t>(perRay) * 20 * 10);
  }
  frame.camera.width = frame.camera.height = 8192;
  EXPECT_EQ(decodeLimitsFor(frame).maxSamples, DecodeLimits{}.maxSamples);
}

TEST(WireFields, EverythingComesBack) {
  const Scene scene = smallScene("vessels");
  const net::Bytes message = net::sceneMessage(toFields(scene));
  const Scene back = sceneFrom(*net::readScene(net::ByteView(message).subspan(net::kMessageHeadBytes)));
  EXPECT_EQ(toFields(back), toFields(scene));
  for (const auto& policy : kRadiusPolicies) {
    MarchSettings settings = scene.march;
    settings.sample.radiusPolicy = policy.value;
    settings.render.skipEmpty = false;
    EXPECT_EQ(marchFrom(toFields(settings)), settings);
  }
  for (const auto& coding : kColorCodings) {
    const CodecSettings settings{PayloadFormat::raw, coding.value, 77};
    EXPECT_EQ(codecFrom(toFields(settings)), settings);
  }
}

TEST(WireFields, WhatIsImpossibleIsRefused) {
  const Scene scene = smallScene("vessels");
  const auto refused = [&](auto change) {
    net::SceneFields fields = toFields(scene);
    change(fields);
    EXPECT_THROW(sceneFrom(fields), std::runtime_error);
  };
  refused([](auto& f) { f.dims[1] = 0; });
  refused([](auto& f) { f.spacing[2] = -1.0; });
  refused([](auto& f) { f.spacing[0] = std::numeric_limits<double>::quiet_NaN(); });
  refused([](auto& f) { f.direction[4] = 3.0; });
  refused([](auto& f) { f.front = f.up; });
  refused([](auto& f) { f.fovYDeg = 180.0; });
  refused([](auto& f) { f.background[0] = std::numeric_limits<float>::infinity(); });
  for (const double wrong : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN(), 0.0, -1.0, 1e300})
    refused([wrong](auto& f) { f.views[0].distance = wrong; });
  for (const double wrong : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN(), -1e300}) {
    refused([wrong](auto& f) { f.views[0].angleDeg = wrong; });
    refused([wrong](auto& f) { f.views[0].elevationDeg = wrong; });
    refused([wrong](auto& f) { f.views[0].panRight = wrong; });
    refused([wrong](auto& f) { f.views[0].panUp = wrong; });
  }
  refused([](auto& f) { f.name = ""; });
  refused([](auto& f) { f.name = "a\nb"; });
  refused([](auto& f) { f.title = "\x1b[2J"; });
  const auto refusedSetting = [&](const std::string& name, const std::string& value) {
    refused([&](auto& f) {
      for (auto& setting : f.settings)
        if (setting.name == name) setting.value = value;
    });
  };
  // Unknown choices are no choices of the first: they are refused.
  refusedSetting("heuristic", "200");
  refusedSetting("heuristic", "");
  refusedSetting("radius", "voxels");
  refusedSetting("step", "0");
  refusedSetting("step", "nan");
  refusedSetting("samplesPerRay", "1.5");
  refusedSetting("skipEmpty", "maybe");
  refused([](auto& f) { f.settings.push_back({"light", "on"}); });

  const SampleFrame frame = makeMarcher(Backend::cpu, scene.volume, scene.transferFunction)->march(makeCamera(scene, scene.views[0], 16, 16), scene.march);
  const auto refusedFrame = [&](auto change) {
    net::FrameHead head = headOf(frame, {});
    EXPECT_NO_THROW(frameFrom(head));
    change(head);
    EXPECT_THROW(frameFrom(head), std::runtime_error);
  };
  refusedFrame([](auto& h) { h.radiusUnit = 3.0f; });
  refusedFrame([](auto& h) { h.radiusUnit = 0.0f; });
  refusedFrame([](auto& h) { h.voxelRadius = -1.0f; });
  refusedFrame([](auto& h) { h.bounds[0] = h.bounds[3] + 1.0f; });
  refusedFrame([](auto& h) { h.bounds[5] = std::numeric_limits<float>::infinity(); });
  for (const float bad : {-1.0f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    refusedFrame([bad](auto& h) { h.nearDepth = bad; });
    refusedFrame([bad](auto& h) { h.depthStep = bad; });
  }
  refusedFrame([](auto& h) { h.depthStep = 0.0f; });
  refusedFrame([](auto& h) { h.camera.width = 0; });
  refusedFrame([](auto& h) { h.camera.tanHalfFovY = 0.0f; });
}

TEST(WireFields, ColoursOfEveryKindComeBackAndDamageIsRefused) {
  Image<glm::vec4> image(37, 11);
  for (size_t i = 0; i < image.size(); ++i)
    image[i] = {static_cast<float>(i) * 1e-7f, -0.0f, i % 3 == 0 ? std::numeric_limits<float>::infinity() : 1.0f, 1.0f / static_cast<float>(i + 1)};
  ByteVector bytes = encodeColors(image);
  EXPECT_TRUE(decodeColors(bytes, 37, 11) == image);
  EXPECT_THROW(decodeColors(bytes, 38, 11), InputError);
  EXPECT_THROW(decodeColors(bytes, 36, 11), InputError);
  for (size_t cut = 0; cut < bytes.size(); cut += 7) EXPECT_THROW(decodeColors(std::span(bytes).first(cut), 37, 11), InputError);
  bytes.push_back(std::byte{0});
  EXPECT_THROW(decodeColors(bytes, 37, 11), InputError);
}

TEST(WireFields, WhenProcessesWorkedComesAcross) {
  RankWork work;
  work.tiles = 3;
  work.timeline.addMarch(0.0, 0.5);
  work.timeline.addMarch(0.0, 0.25);
  work.timeline.addWait(0.25, 0.375);
  const std::vector<net::ProcessFields> fields = toFields(std::vector{work, RankWork{}});
  ASSERT_EQ(fields.size(), 2u);
  EXPECT_EQ(fields[0].slotMs, 0.25f);
  EXPECT_EQ(fields[0].mostThreads, 2.0f);
  EXPECT_EQ(fields[0].marching[0], 255);
  EXPECT_EQ(fields[0].marching[1], 128);
  EXPECT_EQ(fields[0].waiting[1], 64);
  EXPECT_EQ(fields[0].waiting[0], 0);
  EXPECT_EQ(fields[1].mostThreads, 0.0f);
  EXPECT_EQ(fields[1].marching, (std::array<uint8_t, net::kProcessSlots>{}));
}

}  // namespace
}  // namespace warpscope

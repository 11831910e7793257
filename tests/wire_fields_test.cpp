// Settings, frames and limits between the program and the network: what goes out comes back, and what could not be used is refused.
// Mirrors app/frames/wire_fields.h.
#include "app/frames/wire_fields.h"

#include <gmock/gmock.h>

#include <cmath>

#include "render/base/error.h"

namespace warpscope {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

/// Every setting another than by default.
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

}  // namespace
}  // namespace warpscope

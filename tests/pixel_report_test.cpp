// What is said of a pixel, and whose ray is behind it.
// Mirrors app/picture/pixel_report.h and app/experiment/ray_look.h.
#include "app/picture/pixel_report.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "app/experiment/ray_look.h"
#include "app/picture/picture.h"
#include "render/base/error.h"

namespace warpscope {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Six pixels beside each other: a sample, a hole, a guess, nothing, one of an earlier frame, something.
class PixelReportTest : public ::testing::Test {
 protected:
  PixelReportTest() {
    image_.color.resize(6, 1, glm::vec4(0.0f));
    image_.samples.resize(6, 1, kNoSample);
    truth_.resize(6, 1, glm::vec4(0.0f));
    flip_.resize(6, 1, 0.25f);
    image_.color[0] = {0.5f, 0.25f, 0.0f, 1.0f};
    image_.samples[0] = 0;
    truth_[1] = {0.8f, 0.8f, 0.8f, 1.0f};
    image_.samples[2] = kFilled;
    image_.samples[4] = kOfEarlierFrame + 1;
    image_.samples[5] = kNotASample;
    image_.color[5] = {0.1f, 0.1f, 0.1f, 0.5f};
    frame_.camera.eye = {0.0f, 0.0f, 10.0f};
    frame_.camera.width = 5;
    frame_.camera.height = 3;
    frame_.camera.tanHalfFovY = 0.1f;
    frame_.quantization = quantizationFor(frame_.camera, {glm::vec3(-5.0f), glm::vec3(5.0f)}, 1.0f);
    frame_.samples.push_back(packSample(4, 2, 3.0f, 0.5f, frame_.quantization));
    frame_.colors.push_back(0xffffffffu);
    camera_.eye = {0.0f, 0.0f, 20.0f};
    camera_.width = 6;
    camera_.height = 1;
  }

  ContentInputs inputs() const { return {.image = image_, .camera = camera_, .reference = &truth_, .frame = &frame_, .flip = &flip_}; }
  PixelReport report(uint32_t x) const { return pixelReport(inputs(), {x, 0}); }

  WarpedImage image_;
  Image<glm::vec4> truth_;
  Image<float> flip_;
  SampleFrame frame_;
  Camera camera_;
};

TEST_F(PixelReportTest, WhatAFrameSawOfAPlaceIsTold) {
  using Kind = SeenByFrame::Kind;
  const Sphere sphere = unpackSample(frame_.samples.front(), frame_.grid());
  const glm::vec3 along = glm::normalize(sphere.center - frame_.camera.eye);
  const auto seen = [&](const glm::vec3& place) { return seenByFrame(frame_, place); };
  const SeenByFrame there = seen(sphere.center + 0.9f * along);
  EXPECT_EQ(there.kind, Kind::there);
  EXPECT_EQ(there.pixel, glm::uvec2(4, 2));
  EXPECT_NEAR(there.apart, 0.9f, 1e-4f);
  EXPECT_FLOAT_EQ(there.radius, 0.5f);
  EXPECT_EQ(seen(sphere.center + 3.0f * along).kind, Kind::nearer);
  EXPECT_NEAR(seen(sphere.center + 3.0f * along).apart, 3.0f, 1e-4f);
  EXPECT_EQ(seen(sphere.center - 2.0f * along).kind, Kind::farther);
  EXPECT_EQ(seen({0.0f, 0.0f, 7.0f}), (SeenByFrame{Kind::nothing, {2, 1}}));
  EXPECT_EQ(seen({5.0f, 5.0f, 0.0f}).kind, Kind::outside);
  EXPECT_EQ(seen({0.0f, 0.0f, 20.0f}).kind, Kind::outside) << "behind the frame's eye";
  // Of several the one that is nearest to the place.
  frame_.samples.push_back(packSample(4, 2, 6.0f, 0.25f, frame_.quantization));
  frame_.colors.push_back(0xffffffffu);
  const Sphere second = unpackSample(frame_.samples.back(), frame_.grid());
  EXPECT_EQ(seen(second.center).kind, Kind::there);
  EXPECT_FLOAT_EQ(seen(second.center).radius, 0.25f);
}

TEST_F(PixelReportTest, EveryKindIsTold) {
  const std::array kinds{PixelKind::sample, PixelKind::hole, PixelKind::guess, PixelKind::nothing, PixelKind::earlierFrame, PixelKind::other};
  for (uint32_t x = 0; x < kinds.size(); ++x) EXPECT_EQ(report(x).kind, kinds[x]) << x;
  EXPECT_EQ(report(4).framesBack, 2u);
  EXPECT_THAT(textOf(report(4)), HasSubstr("of the kept frame 2 before"));
}

TEST_F(PixelReportTest, ASampleHasItsPlaceDepthAndRadius) {
  const PixelReport sample = report(0);
  ASSERT_TRUE(sample.server);
  EXPECT_EQ(sample.server->place, glm::uvec2(4, 2));
  const Sphere sphere = unpackSample(frame_.samples[0], frame_.grid());
  EXPECT_FLOAT_EQ(sample.server->radius, sphere.radius);
  EXPECT_FLOAT_EQ(sample.server->depth, glm::length(sphere.center - camera_.eye)) << "from the picture's eye, not the server's";
  EXPECT_FALSE(report(1).server);
  EXPECT_THAT(textOf(sample), HasSubstr("server's pixel\t4, 2\n"));
  EXPECT_THAT(textOf(report(1)), Not(HasSubstr("radius")));
}

TEST_F(PixelReportTest, ColoursAreThoseOfTheScreen) {
  const Image<Rgba8> screen = toScreen(image_, glm::vec3(0.0f));
  for (uint32_t x = 0; x < 6; ++x) EXPECT_EQ(report(x).shown, screen[x]);
  EXPECT_EQ(report(1).truthShown, toScreen(truth_, glm::vec3(0.0f))[1]);
  EXPECT_THAT(textOf(report(0)), HasSubstr("colour\t188 137 0\n"));
  EXPECT_EQ(report(3).flip, 0.25f);
}

TEST_F(PixelReportTest, WhatIsNotKnownIsLeftOut) {
  ContentInputs few = inputs();
  few.reference = nullptr;
  few.flip = nullptr;
  few.frame = nullptr;
  const PixelReport sample = pixelReport(few, {0, 0});
  EXPECT_EQ(sample.kind, PixelKind::other);
  EXPECT_FALSE(sample.truth || sample.flip || sample.server);
  EXPECT_EQ(pixelReport(few, {1, 0}).kind, PixelKind::nothing) << "nobody knows that something should be there";
  EXPECT_THROW(pixelReport(inputs(), {6, 0}), InputError);
  EXPECT_THROW(pixelReport(inputs(), {0, 1}), InputError);
}

TEST_F(PixelReportTest, ARayIsTheServersWhereASampleIsSeen) {
  const RayOfPixel sample = rayBehind(inputs(), {0, 0}), hole = rayBehind(inputs(), {1, 0});
  EXPECT_TRUE(sample.isServers);
  EXPECT_EQ(sample.camera, frame_.camera);
  EXPECT_EQ(sample.pixel, glm::uvec2(4, 2));
  EXPECT_EQ(sample.sample, 0u);
  EXPECT_FALSE(hole.isServers);
  EXPECT_EQ(hole.camera, camera_);
  EXPECT_EQ(hole.pixel, glm::uvec2(1, 0));
  EXPECT_FALSE(hole.sample);
  // What shows something of its own leaves no gap, whether or not that is a sample.
  const std::array isGap{false, true, true, false, false, false};
  for (uint32_t x = 0; x < isGap.size(); ++x) EXPECT_EQ(rayBehind(inputs(), {x, 0}).isGap, isGap[x]) << x;
}

TEST_F(PixelReportTest, ARaysJsonHasNullsWhereThereIsNoNumber) {
  RayTrace trace;
  trace.places = {{1.0f, std::nan(""), glm::vec4(0.0f)}, {2.0f, 7.0, glm::vec4(0.5f)}};
  trace.depths = {{Heuristic::peak, {true, 1.5f, 0.0f}}, {Heuristic::median, {}}};
  const nlohmann::json json = toJson(trace, rayBehind(inputs(), {1, 0}), {});
  EXPECT_TRUE(json["places"][0]["value"].is_null());
  EXPECT_EQ(json["places"][1]["value"], 7.0);
  EXPECT_EQ(json["depths"]["peak"], 1.5);
  EXPECT_TRUE(json["depths"]["median"].is_null());
  EXPECT_EQ(json["of"], "picture");
  EXPECT_EQ(depthBy(trace, Heuristic::peak), 1.5f);
  EXPECT_EQ(depthBy(trace, Heuristic::median), std::nullopt);
}

TEST_F(PixelReportTest, ALightsPlacesAreSharesOfWhatTheRayBrings) {
  RayTrace trace;
  EXPECT_EQ(lightAbout(trace, 1.0f).within, 0.0f) << "there is no light";
  trace.samples = {{10.0f, 1.0f, 0.2f, 1.0f, 0.0f}, {11.5f, 1.0f, 0.5f, 0.8f, 0.2f}, {20.0f, 1.0f, 1.0f, 0.4f, 0.6f}};  // 0.2, 0.4 and 0.4 of all light
  trace.depths = {{Heuristic::gradient, {true, 11.5f, 0.0f}}};
  const LightAbout about = lightAbout(trace, 11.5f), first = lightAbout(trace, 10.75f);
  EXPECT_FLOAT_EQ(about.nearer, 0.2f);
  EXPECT_FLOAT_EQ(about.within, 0.4f);
  EXPECT_FLOAT_EQ(about.farther, 0.4f);
  EXPECT_FLOAT_EQ(first.within, 0.6f) << "both are within a unit";
  const nlohmann::json json = toJson(trace, rayBehind(inputs(), {1, 0}), {});
  EXPECT_FLOAT_EQ(json["light"]["farther"], 0.4f);
  EXPECT_TRUE(toJson(RayTrace{}, rayBehind(inputs(), {1, 0}), {})["light"].is_null());
}

TEST(PixelReport, WhereThereIsNoRoomWhatIsLeastAskedForGoesFirst) {
  const std::vector<std::pair<std::string, std::string>> all{{"pixel", "1, 2"},   {"shows", "a sample"},     {"colour", "1 2 3"}, {"opacity", "0.5"},      {"depth", "7"},
                                                             {"radius", "0.8"}, {"server's pixel", "3, 4"}, {"truth", "4 5 6"}, {"its opacity", "0.6"}, {"FLIP", "0.01"}};
  const auto namesOf = [&](size_t most) {
    auto lines = all;
    shorten(lines, most);
    std::string names;
    for (const auto& [name, figure] : lines) names += name + " ";
    return names;
  };
  EXPECT_EQ(namesOf(10), "pixel shows colour opacity depth radius server's pixel truth its opacity FLIP ");
  EXPECT_EQ(namesOf(9), "pixel shows colour opacity depth radius truth its opacity FLIP ");
  EXPECT_EQ(namesOf(6), "shows colour opacity depth truth FLIP ");
  EXPECT_EQ(namesOf(4), "colour depth truth FLIP ");
  EXPECT_EQ(namesOf(2), "colour depth ");
  EXPECT_EQ(namesOf(0), "");
}

}  // namespace
}  // namespace warpscope

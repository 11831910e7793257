// Reading and writing both kinds of files.
// See transfer_file.h.
#include "app/scene/transfer_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "app/scene/json_document.h"
#include "app/scene/knob_json.h"
#include "app/scene/transfer_curves.h"
#include "render/core/color.h"

namespace warpscope {
namespace {

constexpr double kAnyNumber = std::numeric_limits<double>::max();
constexpr size_t kMostCorners = 4096;
/// How often a stretch between two corners is halved at most, and what may be left then: half a code of sRGB.
constexpr int kMostHalvings = 8;
constexpr float kStraight = 0.5f / 255.0f;

glm::vec3 srgbOf(const glm::vec3& linear) { return {srgbFromLinear(linear.r), srgbFromLinear(linear.g), srgbFromLinear(linear.b)}; }
glm::vec3 linearOf(const glm::vec3& srgb) {
  const glm::vec3 inside = glm::clamp(srgb, 0.0f, 1.0f);
  return {linearFromSrgb(inside.r), linearFromSrgb(inside.g), linearFromSrgb(inside.b)};
}

/// Shares of a stretch, rising, between which straight lines in one space keep within kStraight of what `colorAt` says: linear light, in which `mix` draws its
/// straight lines from one to another.
template <class ColorAt, class Mix>
void addSharesBetween(float from, float to, int halvings, const ColorAt& colorAt, const Mix& mix, std::vector<float>& shares) {
  const auto differs = [&](float share) {
    const glm::vec3 wanted = srgbOf(colorAt(std::lerp(from, to, share))), drawn = srgbOf(mix(colorAt(from), colorAt(to), share));
    return glm::any(glm::greaterThan(glm::abs(wanted - drawn), glm::vec3(kStraight)));
  };
  if (halvings == 0 || !(differs(0.5f) || differs(0.25f) || differs(0.75f))) return;
  const float middle = 0.5f * (from + to);
  addSharesBetween(from, middle, halvings - 1, colorAt, mix, shares);
  shares.push_back(middle);
  addSharesBetween(middle, to, halvings - 1, colorAt, mix, shares);
}

glm::vec3 linearMix(const glm::vec3& from, const glm::vec3& to, float share) { return glm::mix(from, to, share); }
glm::vec3 srgbMix(const glm::vec3& from, const glm::vec3& to, float share) { return linearOf(glm::mix(srgbOf(from), srgbOf(to), share)); }

// --- Spaces in which ParaView interpolates, from linear RGB and back. CIE 1976 L*a*b* with the white of sRGB (D65).

constexpr glm::vec3 kWhite{0.950456f, 1.0f, 1.088754f};

glm::vec3 labOf(const glm::vec3& linear) {
  const glm::vec3 xyz{0.412453f * linear.r + 0.357580f * linear.g + 0.180423f * linear.b, 0.212671f * linear.r + 0.715160f * linear.g + 0.072169f * linear.b,
                      0.019334f * linear.r + 0.119193f * linear.g + 0.950227f * linear.b};
  const auto f = [](float t) { return t > 0.008856f ? std::cbrt(t) : 7.787f * t + 16.0f / 116.0f; };
  const float x = f(xyz.x / kWhite.x), y = f(xyz.y / kWhite.y), z = f(xyz.z / kWhite.z);
  return {116.0f * y - 16.0f, 500.0f * (x - y), 200.0f * (y - z)};
}

glm::vec3 linearOfLab(const glm::vec3& lab) {
  const float y = (lab.x + 16.0f) / 116.0f, x = lab.y / 500.0f + y, z = y - lab.z / 200.0f;
  const auto f = [](float t) { return t > 0.206893f ? t * t * t : (t - 16.0f / 116.0f) / 7.787f; };
  const glm::vec3 xyz = kWhite * glm::vec3(f(x), f(y), f(z));
  return glm::clamp(glm::vec3{3.240479f * xyz.x - 1.537150f * xyz.y - 0.498535f * xyz.z, -0.969256f * xyz.x + 1.875992f * xyz.y + 0.041556f * xyz.z,
                              0.055648f * xyz.x - 0.204043f * xyz.y + 1.057311f * xyz.z},
                    0.0f, 1.0f);
}

/// Magnitude, saturation, hue: L*a*b* in polar coordinates (Moreland 2009).
glm::vec3 mshOf(const glm::vec3& lab) {
  const float magnitude = glm::length(lab);
  return {magnitude, magnitude > 0.001f ? std::acos(std::clamp(lab.x / magnitude, -1.0f, 1.0f)) : 0.0f, std::atan2(lab.z, lab.y)};
}
glm::vec3 labOfMsh(const glm::vec3& msh) { return msh.x * glm::vec3(std::cos(msh.y), std::sin(msh.y) * std::cos(msh.z), std::sin(msh.y) * std::sin(msh.z)); }

/// The hue of a saturated colour to interpolate an unsaturated one of that magnitude with.
float adjustedHue(const glm::vec3& msh, float magnitude) {
  if (msh.x >= magnitude - 0.1f) return msh.z;
  const float spin = msh.y * std::sqrt(magnitude * magnitude - msh.x * msh.x) / (msh.x * std::sin(msh.y));
  return msh.z > -0.3f * std::numbers::pi_v<float> ? msh.z + spin : msh.z - spin;
}

glm::vec3 divergedMix(const glm::vec3& from, const glm::vec3& to, float share) {
  glm::vec3 a = mshOf(labOf(from)), b = mshOf(labOf(to));
  const float apart = std::remainder(a.z - b.z, 2.0f * std::numbers::pi_v<float>);
  if (a.y > 0.05f && b.y > 0.05f && std::abs(apart) > 0.33f * std::numbers::pi_v<float>) {
    const float middle = std::max({a.x, b.x, 88.0f});  // white between two hues
    if (share < 0.5f) {
      b = {middle, 0.0f, 0.0f};
      share *= 2.0f;
    } else {
      a = {middle, 0.0f, 0.0f};
      share = 2.0f * share - 1.0f;
    }
  }
  if (a.y < 0.05f && b.y > 0.05f) a.z = adjustedHue(b, a.x);
  if (b.y < 0.05f && a.y > 0.05f) b.z = adjustedHue(a, b.x);
  return linearOfLab(labOfMsh(glm::mix(a, b, share)));
}

glm::vec3 hsvOf(const glm::vec3& rgb) {
  const float most = std::max({rgb.r, rgb.g, rgb.b}), least = std::min({rgb.r, rgb.g, rgb.b}), extent = most - least;
  float hue = 0.0f;
  if (extent > 0.0f) {
    if (most == rgb.r) hue = (rgb.g - rgb.b) / extent;
    else if (most == rgb.g) hue = 2.0f + (rgb.b - rgb.r) / extent;
    else hue = 4.0f + (rgb.r - rgb.g) / extent;
  }
  return {hue < 0.0f ? hue + 6.0f : hue, most > 0.0f ? extent / most : 0.0f, most};
}
glm::vec3 rgbOfHsv(const glm::vec3& hsv) {
  const auto channel = [&](float n) {
    const float k = std::fmod(n + hsv.x, 6.0f);
    return hsv.z - hsv.z * hsv.y * std::clamp(std::min(k, 4.0f - k), 0.0f, 1.0f);
  };
  return {channel(5.0f), channel(3.0f), channel(1.0f)};
}
glm::vec3 hsvMix(const glm::vec3& from, const glm::vec3& to, float share) {
  glm::vec3 a = hsvOf(srgbOf(from)), b = hsvOf(srgbOf(to));
  if (b.x - a.x > 3.0f) a.x += 6.0f;  // the short way around
  if (a.x - b.x > 3.0f) b.x += 6.0f;
  const glm::vec3 mixed = glm::mix(a, b, share);
  return linearOf(rgbOfHsv({std::fmod(mixed.x, 6.0f), mixed.y, mixed.z}));
}

using ColorMix = glm::vec3 (*)(const glm::vec3& from, const glm::vec3& to, float share);

/// Null for steps.
ColorMix mixOf(const Node& space) {
  const std::string name = space.string();
  if (name == "RGB") return srgbMix;
  if (name == "Lab" || name == "Lab/CIEDE2000")
    return [](const glm::vec3& a, const glm::vec3& b, float share) { return linearOfLab(glm::mix(labOf(a), labOf(b), share)); };
  if (name == "HSV") return hsvMix;
  if (name == "Diverging") return divergedMix;
  if (name == "Step") return nullptr;
  space.fail("must be RGB, HSV, Lab, Diverging or Step");
}

/// Groups of `size` numbers.
std::vector<std::vector<double>> groupsOf(const Node& list, size_t size) {
  const std::vector<Node> numbers = list.elements(size, size * kMostCorners);
  if (numbers.size() % size != 0) list.fail("must have " + std::to_string(size) + " numbers for each corner");
  std::vector<std::vector<double>> groups;
  for (size_t i = 0; i < numbers.size(); i += size) {
    std::vector<double>& group = groups.emplace_back();
    for (size_t k = 0; k < size; ++k) group.push_back(numbers[i + k].number(-kAnyNumber, kAnyNumber));
    if (groups.size() > 1 && group[0] < groups[groups.size() - 2][0]) numbers[i].fail("must not be less than the corner's before");
  }
  return groups;
}

std::vector<ColorCorner> paraviewColors(const Node& points, ColorMix mix) {
  std::vector<ColorCorner> colors;
  for (const std::vector<double>& group : groupsOf(points, 4)) {
    const ColorCorner corner{group[0], linearOf(glm::vec3(group[1], group[2], group[3]))};
    if (!colors.empty() && mix == nullptr) colors.push_back({corner.value, colors.back().color});
    if (!colors.empty() && mix != nullptr && corner.value > colors.back().value) {
      const ColorCorner before = colors.back();
      std::vector<float> shares;
      addSharesBetween(0.0f, 1.0f, kMostHalvings, [&](float share) { return mix(before.color, corner.color, share); }, linearMix, shares);
      for (const float share : shares)
        colors.push_back({std::lerp(before.value, corner.value, static_cast<double>(share)), mix(before.color, corner.color, share)});
    }
    colors.push_back(corner);
  }
  return colors;
}

/// With each corner come the middle (where the next stretch has half of its change) and the sharpness (0: straight lines, 1: a step there) of what follows it;
/// what is sharper than straight and no step is taken as straight.
std::vector<OpacityCorner> paraviewOpacities(const Node& points) {
  std::vector<OpacityCorner> opacities;
  const std::vector<std::vector<double>> groups = groupsOf(points, 4);
  for (size_t i = 0; i < groups.size(); ++i) {
    const auto alphaOf = [](const std::vector<double>& group) { return static_cast<float>(std::clamp(group[1], 0.0, 1.0)); };
    opacities.push_back({groups[i][0], alphaOf(groups[i])});
    if (i + 1 == groups.size() || !(groups[i + 1][0] > groups[i][0])) continue;
    const double middle = std::lerp(groups[i][0], groups[i + 1][0], std::clamp(groups[i][2], 0.0, 1.0));
    const float before = alphaOf(groups[i]), after = alphaOf(groups[i + 1]);
    if (groups[i][3] >= 0.99) {
      opacities.push_back({middle, before});
      opacities.push_back({middle, after});
    } else if (groups[i][2] != 0.5) {
      opacities.push_back({middle, 0.5f * (before + after)});
    }
  }
  return opacities;
}

TransferFunction readParaview(const Node& map) {
  const std::optional<Node> space = map.find("ColorSpace");
  TransferCurves curves;
  curves.colors = paraviewColors(map.at("RGBPoints"), space ? mixOf(*space) : ColorMix(srgbMix));
  const std::optional<Node> opacities = map.find("Points");
  if (opacities && !opacities->isNull())
    curves.opacities = paraviewOpacities(*opacities);
  else
    curves.opacities = {{curves.colors.front().value, 0.0f}, {curves.colors.back().value, 1.0f}};
  TransferFunction function = functionOf(curves);
  if (function.points.size() > kMostTransferPoints) map.at("RGBPoints").fail("has more corners than a transfer function can have");
  return function;
}

}  // namespace

TransferFunction readTransferFunction(const Node& node) {
  constexpr std::string_view kKeys[] = {"points"};
  node.requireObject(kKeys);
  TransferFunction function;
  for (const Node& point : node.at("points").elements(1, kMostTransferPoints)) {
    constexpr std::string_view kPointKeys[] = {"value", "color", "alpha"};
    point.requireObject(kPointKeys);
    const Node value = point.at("value");
    function.points.push_back({value.number(-kAnyNumber, kAnyNumber), readColor(point.at("color")),
                               static_cast<float>(point.at("alpha").number(0.0, 1.0))});
    if (function.points.size() > 1 && function.points.back().value < function.points.end()[-2].value)
      value.fail("must not be less than the point's before");
  }
  return function;
}

nlohmann::json toJson(const TransferFunction& function) {
  nlohmann::json points = nlohmann::json::array();
  for (const TransferPoint& point : function.points) {
    const glm::vec3 srgb = srgbOf(point.color);
    points.push_back({{"value", point.value}, {"color", {srgb.r, srgb.g, srgb.b}}, {"alpha", point.alpha}});
  }
  return {{"points", points}};
}

TransferFunction readTransferFile(const std::filesystem::path& path) {
  const JsonDocument document = JsonDocument::fromFile(path);
  const Node root = document.root();
  if (!root.isArray()) return root.find("RGBPoints") ? readParaview(root) : readTransferFunction(root);
  const std::vector<Node> maps = root.elements(1, kMostCorners);
  return readParaview(maps.front());
}

bool isTransferFile(const JsonDocument& document) {
  const Node root = document.root();
  if (root.isArray()) {
    const std::vector<Node> elements = root.elements(0, std::numeric_limits<size_t>::max());
    return !elements.empty() && elements.front().isObject() && elements.front().find("RGBPoints").has_value();
  }
  return root.isObject() && (root.find("RGBPoints") || (root.find("points") && !root.find("volume") && !root.find("rows")));
}

std::string transferText(const TransferFunction& function) { return textOf(toJson(function)); }

std::string paraviewText(const TransferFunction& function, const std::string& name) {
  const TransferCurves curves = curvesOf(function);
  nlohmann::json colors = nlohmann::json::array(), opacities = nlohmann::json::array();
  const auto add = [&](double value, const glm::vec3& linear) {
    const glm::vec3 srgb = srgbOf(linear);
    for (const double number : {value, static_cast<double>(srgb.r), static_cast<double>(srgb.g), static_cast<double>(srgb.b)}) colors.push_back(number);
  };
  for (size_t i = 0; i < curves.colors.size(); ++i) {
    const ColorCorner& corner = curves.colors[i];
    add(corner.value, corner.color);
    if (i + 1 == curves.colors.size() || !(curves.colors[i + 1].value > corner.value)) continue;
    const ColorCorner& next = curves.colors[i + 1];
    std::vector<float> shares;
    addSharesBetween(0.0f, 1.0f, kMostHalvings, [&](float share) { return glm::mix(corner.color, next.color, share); }, srgbMix, shares);
    for (const float share : shares) add(std::lerp(corner.value, next.value, static_cast<double>(share)), glm::mix(corner.color, next.color, share));
  }
  for (const OpacityCorner& corner : curves.opacities)
    for (const double number : {corner.value, static_cast<double>(corner.alpha), 0.5, 0.0}) opacities.push_back(number);
  return textOf(nlohmann::json::array({{{"ColorSpace", "RGB"}, {"Name", name}, {"NanColor", {0.0, 0.0, 0.0}}, {"RGBPoints", colors}, {"Points", opacities}}}));
}

}  // namespace warpscope

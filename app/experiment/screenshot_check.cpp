// Reading the description, drawing, comparing.
// See screenshot_check.h.
#include "app/experiment/screenshot_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "app/picture/picture.h"
#include "app/picture/picture_difference.h"
#include "app/scene/knob_json.h"
#include "render/base/error.h"
#include "render/base/formatted.h"
#include "render/base/nearest_name.h"
#include "render/base/range.h"
#include "render/base/stopwatch.h"
#include "render/metrics/picture_errors.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kAll = "all";

// --- The description

std::vector<const WarpDescriptor*> readTechniques(const Node& node) {
  std::vector<const WarpDescriptor*> techniques;
  if (node.isString()) {
    if (node.string() != kAll) node.fail("must be a list of techniques or \"all\"");
    for (const WarpDescriptor& technique : warpRegistry()) techniques.push_back(&technique);
    return techniques;
  }
  for (const Node& element : node.elements(1, warpRegistry().size())) {
    const WarpDescriptor* const technique = findNamed(warpRegistry(), element.string());
    if (technique == nullptr) element.fail(unknownNameIn(warpRegistry(), "technique", element.string()));
    if (std::ranges::find(techniques, technique) != techniques.end()) element.fail("is listed twice");
    techniques.push_back(technique);
  }
  return techniques;
}

/// One of the tolerances: a number, or null for none.
void readTolerance(const Node& node, std::string_view key, const Range& range, std::optional<double>& value) {
  const std::optional<Node> given = node.find(key);
  if (!given) return;
  value = given->isNull() ? std::nullopt : std::optional(given->number(range));
}

CheckTolerances readTolerances(const Node& node, CheckTolerances tolerances) {
  constexpr std::string_view kKeys[] = {"flip", "psnrDb", "holes", "pixels"};
  node.requireObject(kKeys);
  readTolerance(node, "flip", {0.0, 1.0}, tolerances.flip);
  readTolerance(node, "psnrDb", {0.0, 1000.0}, tolerances.psnrDb);
  readTolerance(node, "holes", {0.0, 1.0}, tolerances.holes);
  readTolerance(node, "pixels", {0.0, 1.0}, tolerances.pixels);
  return tolerances;
}

/// What a case and the description as a whole may say alike.
constexpr std::array<std::string_view, 10> kSettingKeys{"techniques", "anglesDeg", "size", "background", "uncovered", "march", "warp", "tolerances", "volumeSize", "seed"};

void readSettings(const Node& node, CheckCase& settings) {
  if (const auto techniques = node.find("techniques")) settings.techniques = readTechniques(*techniques);
  if (const auto angles = node.find("anglesDeg")) {
    settings.anglesDeg.clear();
    for (const Node& angle : angles->elements(1, 64)) {
      const double value = angle.number(-360.0, 360.0);
      if (std::ranges::find(settings.anglesDeg, value) != settings.anglesDeg.end()) angle.fail("is listed twice");
      settings.anglesDeg.push_back(value);
    }
  }
  if (const auto size = node.find("size")) {
    const std::vector<Node> sides = size->elements(2, 2);
    settings.width = static_cast<uint32_t>(sides[0].integer(1, 8192));
    settings.height = static_cast<uint32_t>(sides[1].integer(1, 8192));
  }
  if (const auto background = node.find("background")) settings.background = readColor(*background);
  if (const auto uncovered = node.find("uncovered")) settings.uncovered = ColorTables::instance().encode(glm::vec4(readColor(*uncovered), 1.0f));
  MarchSettings march;
  KnobValues knobs;
  if (const auto given = node.find("march")) readMarch(*given, march), settings.march.push_back(*given);
  if (const auto given = node.find("warp")) readWarpKnobs(*given, knobs), settings.warp.push_back(*given);
  if (const auto given = node.find("tolerances")) settings.tolerances = readTolerances(*given, settings.tolerances);
  if (const auto size = node.find("volumeSize")) settings.overrides.proceduralDims = readSize(*size);
  if (const auto seed = node.find("seed")) settings.overrides.seed = static_cast<uint32_t>(seed->integer(0, 0xffffffff));
}

bool isName(const std::string& name) {
  return !name.empty() && name.size() <= 100 && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

CheckCase readCase(const Node& node, const CheckCase& usual, const fs::path& folder) {
  std::vector<std::string_view> keys(kSettingKeys.begin(), kSettingKeys.end());
  keys.insert(keys.end(), {"name", "scene"});
  node.requireObject(keys);
  CheckCase what = usual;
  readSettings(node, what);
  const Node scene = node.at("scene");
  const fs::path beside = folder / scene.string();
  std::error_code unknown;
  what.scene = fs::is_regular_file(beside, unknown) ? beside.string() : scene.string();
  try {
    requireScene(what.scene);
  } catch (const std::exception& error) {
    scene.fail(std::string("names no scene: ") + error.what());
  }
  const auto name = node.find("name");
  what.name = name ? name->string() : scene.string();
  if (!isName(what.name)) (name ? *name : scene).fail(name ? "must be of letters, digits, - and _" : "is no name for pictures: give the case a name of letters, digits, - and _");
  if (what.techniques.empty()) node.fail("says no techniques, and neither does the description");
  return what;
}

CheckPlan parsePlan(const fs::path& folder) {
  CheckPlan plan;
  plan.folder = folder;
  plan.document = std::make_shared<const JsonDocument>(JsonDocument::fromFile(folder / kCheckDescription));
  const Node root = plan.document->root();
  std::vector<std::string_view> keys(kSettingKeys.begin(), kSettingKeys.end());
  keys.insert(keys.end(), {"platforms", "cases"});
  root.requireObject(keys);
  CheckCase usual;
  usual.anglesDeg = {0.0};
  readSettings(root, usual);
  if (const auto platforms = root.find("platforms")) {
    for (const Node& element : platforms->elements(1, gl::kPlatforms.size())) {
      const auto* const platform = findNamed(gl::kPlatforms, element.string());
      if (platform == nullptr) element.fail(unknownNameIn(gl::kPlatforms, "platform", element.string()));
      if (std::ranges::find(plan.platforms, platform->value) != plan.platforms.end()) element.fail("is listed twice");
      plan.platforms.push_back(platform->value);
    }
  } else {
    plan.platforms = {gl::Platform::automatic};
  }
  std::set<std::string> names;
  for (const Node& element : root.at("cases").elements(1, 4096)) {
    plan.cases.push_back(readCase(element, usual, folder));
    for (const WarpDescriptor* const technique : plan.cases.back().techniques)
      for (const double angle : plan.cases.back().anglesDeg)
        if (!names.insert(pictureName(plan.cases.back(), *technique, angle)).second) element.fail("has pictures of the same names as a case before it");
  }
  return plan;
}

// --- Comparing

/// Both as displayed: opaque pictures over one background.
WarpedImage displayedImage(const Image<Rgba8>& picture) {
  WarpedImage image{Image<glm::vec4>(picture.width(), picture.height()), Image<uint32_t>(picture.width(), picture.height(), kNotASample)};
  for (size_t i = 0; i < picture.size(); ++i) image.color[i] = decodeRgba8(picture[i] | 0xff000000u);
  return image;
}

double shareOf(const Image<Rgba8>& picture, Rgba8 color) {
  return static_cast<double>(std::ranges::count(picture, color)) / static_cast<double>(picture.size());
}

/// Compares the actual picture with the expected one: fills in all else but its name, platform and time.
void judge(CheckedPicture& picture, const CheckCase& what, const std::string& unreadable) {
  if (!unreadable.empty()) {
    picture.verdict = CheckVerdict::different;
    picture.faults = {unreadable};
    return;
  }
  if (picture.expected.empty()) {
    picture.verdict = CheckVerdict::missing;
    picture.faults = {"there is no golden picture (--update makes it)"};
    return;
  }
  const Image<Rgba8>&actual = picture.actual, &expected = picture.expected;
  const PictureDifference difference = comparePictures(actual, expected);
  if (!difference.sameSize) {
    picture.verdict = CheckVerdict::different;
    picture.faults = {"the golden picture has " + std::to_string(expected.width()) + "x" + std::to_string(expected.height()) + " pixels instead of " +
                      std::to_string(actual.width()) + "x" + std::to_string(actual.height())};
    return;
  }
  picture.psnrDb = std::numeric_limits<double>::infinity();
  if (actual == expected) return;
  const PictureErrors errors = PictureJudge(displayedImage(expected).color, glm::vec3(0.0f)).errorsOf(displayedImage(actual));
  picture.flip = errors.flip;
  picture.psnrDb = errors.psnrDb;
  picture.pixels = difference.fraction;
  picture.holes = std::abs(shareOf(actual, what.uncovered) - shareOf(expected, what.uncovered));
  const CheckTolerances& most = what.tolerances;
  const auto fault = [&](bool isBeyond, std::string text) {
    if (isBeyond) picture.faults.push_back(std::move(text));
  };
  if (most.flip) fault(picture.flip > *most.flip, formatted("FLIP %.4f", picture.flip) + formatted(", at most %g", *most.flip));
  if (most.psnrDb) fault(picture.psnrDb < *most.psnrDb, formatted("PSNR %.2f dB", picture.psnrDb) + formatted(", at least %g", *most.psnrDb));
  if (most.holes) fault(picture.holes > *most.holes, formatted("%.3f %% more or fewer pixels that nothing covers", 100.0 * picture.holes) + formatted(", at most %g %%", 100.0 * *most.holes));
  if (most.pixels) fault(picture.pixels > *most.pixels, formatted("%.3f %% of the pixels differ", 100.0 * picture.pixels) + formatted(", at most %g %%", 100.0 * *most.pixels));
  picture.verdict = picture.faults.empty() ? CheckVerdict::tolerable : CheckVerdict::different;
}

/// Reads golden pictures, and keeps those that are to be made.
class GoldenPictures {
 public:
  GoldenPictures(fs::path folder, bool makes) : folder_(std::move(folder)), makes_(makes) {}

  Image<Rgba8> expected(const std::string& name) const {
    if (const auto made = made_.find(name); made != made_.end()) return made->second;
    const fs::path path = folder_ / (name + ".png");
    std::error_code unknown;
    return fs::exists(path, unknown) ? readPng(path) : Image<Rgba8>();
  }
  /// What failed becomes golden, unless another platform made it so.
  void take(CheckedPicture& picture) {
    if (!makes_ || !picture.isFailure() || !made_.emplace(picture.name, picture.actual).second) return;
    picture.verdict = CheckVerdict::made;
  }

 private:
  fs::path folder_;
  bool makes_;
  std::map<std::string, Image<Rgba8>> made_;
};

}  // namespace

size_t CheckPlan::pictures() const {
  size_t count = 0;
  for (const CheckCase& what : cases) count += what.techniques.size() * what.anglesDeg.size() * platforms.size();
  return count;
}

std::string pictureName(const CheckCase& what, const WarpDescriptor& technique, double angleDeg) {
  return what.name + "-" + std::string(technique.name) + "-" + numberText(angleDeg);
}

std::vector<std::string> pictureNames(const CheckPlan& plan) {
  std::vector<std::string> names;
  for (const CheckCase& what : plan.cases)
    for (const WarpDescriptor* const technique : what.techniques)
      for (const double angle : what.anglesDeg) names.push_back(pictureName(what, *technique, angle));
  return names;
}

CheckPlan readCheckPlan(const fs::path& folder) {
  try {
    return parsePlan(folder);
  } catch (const InputError& error) {
    throw UsageError(error.what());
  }
}

void checkPictures(const CheckPlan& plan, bool makes, const CheckTools& tools, const std::function<void(CheckedPicture)>& onPicture, const std::stop_token& stop) {
  GoldenPictures golden(plan.folder, makes);
  for (const CheckCase& what : plan.cases) {
    const Scene scene = openScene(what.scene, what.overrides, stop);
    MarchSettings march = scene.march;
    WarpSettings settings;
    for (const Node& node : what.march) readMarch(node, march);
    for (const Node& node : what.warp) readWarpKnobs(node, settings.knobs);
    settings.reference = march.render;
    for (const WarpDescriptor* const technique : what.techniques)
      if (const std::string lack = lackOf(*technique, march, settings.knobs); !lack.empty())
        throw UsageError("case " + what.name + ": " + std::string(technique->name) + " shows nothing: " + lack);
    const MarcherPtr marcher = tools.makeMarcher(scene);
    const auto camera = [&](double angleDeg) {
      View view = scene.views.front();
      view.angleDeg += angleDeg;
      return makeCamera(scene, view, what.width, what.height);
    };
    SampleFramePtr frame;
    if (std::ranges::any_of(what.techniques, [](const WarpDescriptor* technique) { return technique->usesFrame; }))
      frame = std::make_shared<SampleFrame>(marcher->march(camera(0.0), march, stop));
    for (const gl::Platform platform : plan.platforms)
      tools.withResources(marcher, platform, [&](const WarpResources& resources) {
        for (const WarpDescriptor* const technique : what.techniques) {
          const std::unique_ptr<Warp> warp = makeWarp(*technique, resources);
          warp->setFrame(technique->usesFrame ? frame : nullptr, settings, stop);
          for (const double angleDeg : what.anglesDeg) {
            CheckedPicture picture;
            picture.name = pictureName(what, *technique, angleDeg);
            picture.platform = nameOf(gl::kPlatforms, platform);
            WarpedImage image;
            picture.seconds = 1e-3 * milliseconds([&] { warp->draw(camera(angleDeg), settings, image, stop); });
            picture.actual = toScreen(image, what.background.value_or(scene.background), {.uncovered = what.uncovered});
            std::string unreadable;
            try {
              picture.expected = golden.expected(picture.name);
            } catch (const InputError& error) {
              unreadable = "the golden picture is damaged: " + std::string(error.what()) + " (--update makes it anew)";
            }
            judge(picture, what, unreadable);
            golden.take(picture);
            onPicture(std::move(picture));
          }
        }
      });
  }
}

}  // namespace warpscope

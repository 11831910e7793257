// Reading scenes and placing cameras.
// See scene.h.
#include "app/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "app/scene/auto_transfer_function.h"
#include "app/scene/fitting_view.h"
#include "app/scene/json_document.h"
#include "app/scene/knob_json.h"
#include "app/scene/session_key.h"
#include "app/scene/transfer_file.h"
#include "app/scene/view_json.h"
#include "app/shell/log.h"
#include "render/base/error.h"
#include "render/base/formatted.h"
#include "render/base/nearest_name.h"
#include "render/base/stopwatch.h"
#include "render/core/color.h"
#include "render/core/picture_size.h"
#include "render/effects/isosurface_setup.h"
#include "render/march/march_knobs.h"
#include "render/volume/masked_volume.h"
#include "render/volume/procedural.h"
#include "render/volume/reader.h"
#include "render/volume/torture_volume.h"
#include "scenes.h"
#include "torture_scenes.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTortureFolder = "torture/";

glm::dvec3 readVector(const Node& node, double lowest, double highest) {
  const std::vector<Node> elements = node.elements(3, 3);
  return {elements[0].number(lowest, highest), elements[1].number(lowest, highest), elements[2].number(lowest, highest)};
}

glm::dvec3 readDirection(const Node& node) {
  const glm::dvec3 vector = readVector(node, -1e6, 1e6);
  if (!(glm::length(vector) > 1e-9)) node.fail("must not be a zero vector");
  return glm::normalize(vector);
}

/// For volumes that are files.
void refuseSize(const SceneOverrides& overrides) {
  if (overrides.proceduralDims) throw UsageError("--volume-size is for built-in volumes; a file has its own size");
}

/// That a node names, from the folder of its description on.
fs::path fileOf(const Node& node, const fs::path& folder) {
  const Node name = node.at("file");
  const fs::path file = name.string();
  if (file.empty()) name.fail("must not be empty");
  return file.is_absolute() ? file : folder / file;
}

VolumePtr readVolume(const Node& node, const fs::path& folder, const SceneOverrides& overrides, const std::stop_token& stop) {
  constexpr std::string_view kKeys[] = {"file", "spacing", "procedural", "size"};
  node.requireObject(kKeys);
  if (const auto procedural = node.find("procedural")) {
    if (node.find("file")) procedural->fail("and 'file' exclude each other");
    if (const auto spacing = node.find("spacing")) spacing->fail("is for raw files; the voxels of a procedural volume are cubes");
    const std::string name = procedural->string();
    if (name.starts_with(kTortureFolder)) {
      if (const auto size = node.find("size")) size->fail("is not for torture volumes, which have their own");
      if (overrides.proceduralDims) throw UsageError("--volume-size is not for torture volumes, which have their own size");
      if (findNamed(kTortureVolumes, name) == nullptr) procedural->fail("holds an " + unknownNameIn(kTortureVolumes, "torture volume", name));
      if (overrides.ranks) throw UsageError("torture volumes are too small for several processes");
      return makeTortureVolume(name, stop);
    }
    const ProceduralVolume* known = findNamed(kProceduralVolumes, name);
    if (known == nullptr) procedural->fail("holds an " + unknownNameIn(kProceduralVolumes, "procedural volume", name));
    glm::uvec3 dims = known->defaultDims;
    if (const auto size = node.find("size")) dims = readSize(*size);
    return makeProceduralVolume(name, overrides.proceduralDims.value_or(dims), overrides.seed, stop, overrides.ranks);
  }
  refuseSize(overrides);
  if (const auto size = node.find("size")) size->fail("is for procedural volumes; a file has its own size");
  std::optional<glm::dvec3> spacing;
  if (const auto given = node.find("spacing")) spacing = readVector(*given, 1e-12, 1e12);
  return openVolume(fileOf(node, folder), spacing, stop, overrides.ranks);
}

void crop(Scene& scene, const fs::path& mask, const std::stop_token& stop) {
  if (scene.volume->ranks()) throw UsageError("a mask is for a volume of one process; several share this one");
  scene.volume = masked(*scene.volume, *openVolume(mask, {}, stop), stop);
}

/// World axes of volumes that say nothing: y is up and the camera is where z grows. Patient axes (LPS): z is up, and the face
/// looks at a camera in front.
void setDefaultAxes(Scene& scene) {
  if (!scene.volume->geometry().hasOrientation) return;
  scene.up = {0.0, 0.0, 1.0};
  scene.front = {0.0, -1.0, 0.0};
}

Scene readScene(const JsonDocument& document, const fs::path& folder, const SceneOverrides& overrides, const std::stop_token& stop) {
  const Node root = document.root();
  constexpr std::string_view kKeys[] = {"name", "title",   "volume",     "transferFunction", "up",
                                        "front", "fovYDeg", "background", "views",            "march", "mask"};
  if (root.isObject() && root.find(kSessionKey)) root.fail("is a session, not a scene: `warpscope view FILE`, or File > Open in the window, goes on with it");
  if (root.isObject() && !root.find("volume") && !root.find("name")) root.fail("is not a scene, which has a name and a volume");
  root.requireObject(kKeys);
  Scene scene;
  const Node name = root.at("name");
  scene.name = name.string();
  if (scene.name.empty()) name.fail("must not be empty");
  scene.title = root.find("title") ? root.at("title").string() : scene.name;
  // Everything that is quick to check comes before the volume is made or opened.
  if (const auto fov = root.find("fovYDeg")) scene.fovYDeg = fov->number(kFovYDegRange);
  if (const auto color = root.find("background")) scene.background = readColor(*color);
  const auto march = root.find("march"), views = root.find("views");
  if (march) readMarch(*march, scene.march);
  if (views)
    for (const Node& view : views->elements(1, 64)) scene.views.push_back(readView(view));
  const auto function = root.find("transferFunction");
  if (function) {
    if (!function->isString())
      scene.transferFunction = readTransferFunction(*function);
    else if (function->string() != "auto")
      function->fail("must be an object or \"auto\"");
  }
  const Node volume = root.at("volume");
  if (overrides.volume) refuseSize(overrides);
  scene.volume = overrides.volume ? openVolume(*overrides.volume, {}, stop, overrides.ranks) : readVolume(volume, folder, overrides, stop);
  if (!overrides.volume && volume.find("file")) scene.files.push_back(fileOf(volume, folder));
  if (const auto mask = root.find("mask"); mask && !overrides.mask) {
    constexpr std::string_view kMaskKeys[] = {"file"};
    mask->requireObject(kMaskKeys);
    scene.files.push_back(fileOf(*mask, folder));
    crop(scene, scene.files.back(), stop);
  }
  // Made for these views, as their golden images are; of a file nobody knows beforehand what it shows.
  if (scene.views.empty() && !overrides.volume && volume.find("procedural")) scene.views = defaultViews();
  setDefaultAxes(scene);
  const auto up = root.find("up"), front = root.find("front");
  if (up) scene.up = readDirection(*up);
  if (front) scene.front = readDirection(*front);
  // What of it only goes together with the volume, or not at all.
  const auto refuseIn = [](const Node& node, const auto& check) {
    try {
      check();
    } catch (const UsageError& error) {
      node.fail(std::string("cannot be: ") + error.what());
    }
  };
  if (march && !overrides.volume && scene.march.render.effects.mode == RenderMode::isosurface && scene.march.render.effects.isoValues.size() > 0)
    refuseIn(*march, [&] { requireIsoValues(scene.march.render.effects.isoValues, *scene.volume); });
  if (glm::length(glm::cross(scene.up, scene.front)) < 1e-3) {
    if (!front) up->fail("and the direction that 'front' has by itself are parallel");
    front->fail(up ? "and 'up' are parallel" : "and the direction that 'up' has by itself are parallel");
  }
  if (views && !overrides.fovYDeg)
    for (size_t i = 0; const Node& view : views->elements(1, 64)) refuseIn(view, [&] { static_cast<void>(makeCamera(scene, scene.views[i++], 64, 64)); });
  return scene;
}

Scene sceneOfVolume(const fs::path& path, const SceneOverrides& overrides, const std::stop_token& stop) {
  Scene scene;
  scene.volume = openVolume(path, {}, stop, overrides.ranks);
  scene.name = scene.volume->name();
  scene.title = path.filename().string();
  scene.march.render.effects.shading.strength = 1.0f;  // surfaces in scans are seen by their light
  setDefaultAxes(scene);
  return scene;
}

Scene openBySpec(const std::string& spec, const SceneOverrides& overrides, const std::stop_token& stop) {
  const auto openBuiltin = [&](const auto& files, const std::string& name) -> std::optional<Scene> {
    for (const auto& file : files)
      if (file.name == name + ".json") return readScene(JsonDocument(file.content, "built-in scene " + spec), {}, overrides, stop);
    return std::nullopt;
  };
  if (auto scene = openBuiltin(scenes::files(), spec)) return std::move(*scene);
  if (spec.starts_with(kTortureFolder))
    if (auto scene = openBuiltin(torture_scenes::files(), spec.substr(kTortureFolder.size()))) return std::move(*scene);
  requireScene(spec);
  const fs::path path(spec);
  if (path.extension() == ".json") return readScene(JsonDocument::fromFile(path), path.parent_path(), overrides, stop);
  if (overrides.volume) throw UsageError("--volume replaces a scene's volume; '" + spec + "' is a volume itself");
  refuseSize(overrides);
  return sceneOfVolume(path, overrides, stop);
}

void logVolume(const Volume& volume, double openMs) {
  const glm::uvec3& dims = volume.dims();
  const VoxelStatistics& statistics = volume.statistics();
  char text[192];
  std::snprintf(text, sizeof text, ": %ux%ux%u voxels of %s, values %g to %g, %zu not finite; opened in %.0f ms", dims.x, dims.y, dims.z,
                std::string(nameOf(volume.type())).c_str(), statistics.lowest, statistics.highest, statistics.nonFinite, openMs);
  logDetail("volume " + volume.name() + text);
}

/// Whether any value between the least and the greatest has opacity; the function is linear between its points.
bool showsAnyOf(const TransferFunction& function, const VoxelStatistics& statistics) {
  return function.at(statistics.lowest).a > 0.0f || function.at(statistics.highest).a > 0.0f ||
         std::any_of(function.points.begin(), function.points.end(), [&](const TransferPoint& point) {
           return point.alpha > 0.0f && point.value >= statistics.lowest && point.value <= statistics.highest;
         });
}

void warnIfInvisible(const Scene& scene) {
  const VoxelStatistics& statistics = scene.volume->statistics();
  const bool hasValues = statistics.nonFinite < scene.volume->voxelCount();
  if (hasValues && showsAnyOf(scene.transferFunction, statistics)) return;
  logWarning("nothing of the volume " + scene.volume->name() + " is visible with this transfer function" +
             (hasValues ? "" : ": none of its values is finite"));
}

template <class Files>
std::vector<BuiltinScene> titlesOf(const Files& files) {
  std::vector<BuiltinScene> all;
  for (const auto& file : files) {
    const JsonDocument document(file.content, std::string(file.name));
    all.push_back({document.root().at("name").string(), document.root().at("title").string()});
  }
  return all;
}

}  // namespace

std::vector<BuiltinScene> builtinScenes() { return titlesOf(scenes::files()); }
std::vector<BuiltinScene> tortureScenes() { return titlesOf(torture_scenes::files()); }

std::vector<View> defaultViews() {
  // The server's view shows three sides of a box; the others turn about it, nearer and farther.
  return {{30.0, 20.0, 0.72}, {40.0, 20.0, 0.72}, {55.0, 20.0, 0.6}, {75.0, 20.0, 0.9}, {0.0, 20.0, 0.5}};
}

void requireScene(const std::string& spec) {
  const std::vector<BuiltinScene> scenes = builtinScenes(), torture = tortureScenes();
  if (findNamed(scenes, spec) != nullptr || findNamed(torture, spec) != nullptr) return;
  const fs::path path(spec);
  std::error_code error;
  if (fs::exists(path, error)) return;
  if (error) throw InputError(spec + ": cannot be looked at: " + error.message());
  if (spec.starts_with(kTortureFolder) && !path.has_extension()) throw UsageError(unknownNameIn(torture, "scene", spec));
  if (path.has_extension() || spec.find('/') != std::string::npos) throw InputError(spec + ": there is no such file");
  throw UsageError(unknownNameIn(scenes, "scene", spec) + " (or a scene file, or a volume file)");
}

bool isBuiltinScene(const std::string& spec) {
  const auto isAmong = [](const auto& files, const std::string& name) { return std::ranges::any_of(files, [&](const auto& file) { return file.name == name + ".json"; }); };
  return isAmong(scenes::files(), spec) || (spec.starts_with(kTortureFolder) && isAmong(torture_scenes::files(), spec.substr(kTortureFolder.size())));
}

Scene openScene(const std::string& spec, const SceneOverrides& overrides, const std::stop_token& stop) {
  Scene scene;
  const double openMs = milliseconds([&] { scene = openBySpec(spec, overrides, stop); });
  if (overrides.mask) crop(scene, *overrides.mask, stop);
  logVolume(*scene.volume, openMs);
  if (overrides.transferFunction)
    scene.transferFunction = readTransferFile(*overrides.transferFunction);
  if (scene.transferFunction.points.empty())
    scene.transferFunction = autoTransferFunction(scene.volume->statistics());
  warnIfInvisible(scene);
  if (overrides.fovYDeg) scene.fovYDeg = *overrides.fovYDeg;
  if (scene.views.empty()) scene.views = fittingViews(scene, stop);
  return scene;
}

Camera makeCamera(const Scene& scene, const View& view, uint32_t width, uint32_t height) {
  if (!(scene.fovYDeg > 0.0 && scene.fovYDeg < 180.0))
    throw UsageError("the field of view must be more than 0 and less than 180 degrees");
  if (!isPictureSize(width, height))
    throw UsageError("an image of " + std::to_string(width) + "x" + std::to_string(height) +
                     " pixels: " + pictureSizes() + " are possible");
  const auto radians = [](double degrees) { return degrees * std::numbers::pi / 180.0; };
  const double angle = radians(view.angleDeg);
  const double elevation = radians(view.elevationDeg);

  // World axes, right-handed, in double.
  const glm::dvec3 up = glm::normalize(scene.up);
  const glm::dvec3 sideways = glm::normalize(glm::cross(up, scene.front));
  const glm::dvec3 front = glm::cross(sideways, up);
  const glm::dvec3 horizontal = std::cos(angle) * front + std::sin(angle) * sideways;
  const glm::dvec3 backward = std::cos(elevation) * horizontal + std::sin(elevation) * up;
  const glm::dvec3 right = std::cos(angle) * sideways - std::sin(angle) * front;  // stays defined at the poles
  const glm::dvec3 cameraUp = glm::cross(backward, right);

  const double tanHalfFovY = std::tan(0.5 * radians(scene.fovYDeg));
  const double radius = 0.5 * glm::length(glm::dvec3(scene.geometry().bounds().extent()));
  // A sphere of that radius touches the border of the image's narrower side.
  const double narrower = std::atan(tanHalfFovY * std::min(1.0, static_cast<double>(width) / height));
  const double distance = view.distance * radius / std::sin(narrower);
  // From farther away single precision could not tell one voxel from the next.
  constexpr double kFarthest = 1 << 22;
  if (distance > kFarthest)
    throw UsageError("the camera would stand too far away from a volume that is " + formatted("%.3g", 2.0 * radius) +
                     " of its shortest voxel edge across: the field of view must be wider, the view's distance less, or the volume's voxel spacing is wrong");

  // Directions only: volume space has the world's angles, its own origin and unit, and perhaps the other handedness.
  const glm::dmat3 volumeFromWorld = glm::transpose(scene.geometry().direction);
  const glm::dvec3 center = radius * (view.pan.x * right + view.pan.y * cameraUp);
  Camera camera;
  camera.eye = glm::vec3(volumeFromWorld * (center + distance * backward));
  camera.right = glm::vec3(volumeFromWorld * right);
  camera.up = glm::vec3(volumeFromWorld * cameraUp);
  camera.forward = glm::vec3(volumeFromWorld * -backward);
  camera.tanHalfFovY = static_cast<float>(tanHalfFovY);
  camera.width = width;
  camera.height = height;
  if (!isUsable(camera)) throw UsageError("the view is not finite, or its field of view is too wide or too narrow");
  return camera;
}

}  // namespace warpscope

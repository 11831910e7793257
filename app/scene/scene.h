// Scenes: a volume, how its values look, and the views from which techniques are compared.
// The protocol of five views, the first being the server's, after Zellmann 2020, section 4; the file format is in assets/scenes/README.md.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "render/base/range.h"
#include "render/core/camera.h"
#include "render/core/transfer_function.h"
#include "render/march/march_settings.h"
#include "render/volume/volume.h"

namespace warpscope {

/// Where a camera stands: on a sphere about the volume's centre, looking at it (or past it, by `pan`).
struct View {
  double angleDeg = 0.0;      ///< about the vertical axis; positive moves the camera to its right
  double elevationDeg = 0.0;  ///< above the horizon, -90..90
  double distance = 1.0;      ///< 1: the volume's bounding sphere just fills the image
  glm::dvec2 pan{0.0};        ///< of the point looked at, right and up, in radii of the bounding sphere

  bool operator==(const View&) const = default;
};

/// What files may say, and programs make, of views.
inline constexpr Range kViewDistanceRange{1e-3, 1e3};
inline constexpr double kMostViewPan = 100.0;

/// Scenes' settings unless they say others: frames have segments and a copy of the volume for the techniques that draw them (neededBy).
inline MarchSettings defaultMarch() {
  MarchSettings march;
  march.sample.segments = kUsualSegments;
  march.sample.proxy = 128;
  return march;
}

struct Scene {
  std::string name;
  std::string title;
  VolumePtr volume;          ///< null where the voxels are a server's
  VolumeGeometry elsewhere;  ///< theirs, then
  TransferFunction transferFunction;
  glm::dvec3 up{0.0, 1.0, 0.0};     ///< world direction
  glm::dvec3 front{0.0, 0.0, 1.0};  ///< world direction from the volume to the camera at angle 0, elevation 0
  double fovYDeg = 40.0;
  glm::vec3 background{0.0f};  ///< linear RGB, behind everything that is transparent
  std::vector<View> views;     ///< at least one; the first is the server's
  std::vector<std::filesystem::path> files;  ///< that its description names: of voxels and of a mask
  MarchSettings march = defaultMarch();
  std::optional<MarchSettings> describedMarch{};  ///< `march` before options replaced some of it

  const VolumeGeometry& geometry() const { return volume ? volume->geometry() : elsewhere; }
};

/// Vertical fields of view that files and options may ask for.
inline constexpr Range kFovYDegRange{0.001, 170.0};

/// What the command line may replace in any scene.
struct SceneOverrides {
  std::optional<std::filesystem::path> volume;
  std::optional<std::filesystem::path> mask;  ///< of the volume: what it is 0 at is cropped (masked_volume.h)
  std::optional<std::filesystem::path> transferFunction;
  std::optional<glm::uvec3> proceduralDims;
  std::optional<double> fovYDeg;
  uint32_t seed = 1;
  RanksPtr ranks;  ///< that share the volume (Volume); null: it is this process's alone
};

/// The scene that is shown when none is named.
inline constexpr std::string_view kDefaultScene = "vessels";

struct BuiltinScene {
  std::string name;
  std::string title;
};
std::vector<BuiltinScene> builtinScenes();
/// Those that are hard on arithmetic: "torture/...".
std::vector<BuiltinScene> tortureScenes();

/// Whether openScene takes it for the name of one of these, whatever files there are.
bool isBuiltinScene(const std::string& spec);

/// Throws what openScene would for a name that is neither built in nor a file that is there; quick.
void requireScene(const std::string& spec);

/// Opens a scene by its built-in name, a scene file (.json) or a volume file. Throws InputError; UsageError for a name that is neither;
/// OperationCancelled if `stop` is set.
Scene openScene(const std::string& spec, const SceneOverrides& overrides = {}, const std::stop_token& stop = {});

/// Five views in which nearly any volume fills the picture; those of files are brought nearer or farther by fitting_view.h.
std::vector<View> defaultViews();

/// A camera of the scene, computed in double and rounded once: each coordinate of the eye and component of an axis by
/// 2^-24 of itself, and what 4e-15 makes of the eye's distance. That is at most 2^22 units of volume space: from
/// farther away single precision could not tell one voxel from the next. Throws UsageError for a view from there, a field
/// of view outside (0, 180) degrees, a size that is no isPictureSize(), or a view that is not finite.
Camera makeCamera(const Scene& scene, const View& view, uint32_t width, uint32_t height);

}  // namespace warpscope

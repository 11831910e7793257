// Screenshot regression: pictures that a description lists, against golden ones that lie beside it.
// The description is check.json in the folder; what it may hold is in app/README.md.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "app/scene/json_document.h"
#include "app/scene/scene.h"
#include "render/gl/context.h"
#include "render/warp/warp.h"

namespace warpscope {

/// What a picture may be off from its golden one; what is not there is not looked at.
struct CheckTolerances {
  std::optional<double> flip = 0.005;    ///< mean over the picture, at most
  std::optional<double> psnrDb = 30.0;   ///< at least
  std::optional<double> holes = 0.001;   ///< by how much the share of pixels that nothing covers may differ
  std::optional<double> pixels = 0.001;  ///< share of pixels that may differ by more than kChannelTolerance
};

/// One scene, by several techniques from several angles.
struct CheckCase {
  std::string name;   ///< letters, digits, '-' and '_'; no other case has it
  std::string scene;  ///< as openScene takes it
  SceneOverrides overrides;
  std::vector<const WarpDescriptor*> techniques;
  std::vector<double> anglesDeg;  ///< that the camera turns from the scene's first view, from which the frame is marched
  uint32_t width = 256, height = 256;
  std::optional<glm::vec3> background;  ///< linear RGB; the scene's without
  Rgba8 uncovered = 0xff502030u;        ///< of pixels that nothing covers, so that holes are told from the background
  std::vector<Node> march, warp;        ///< settings on top of the scene's and the usual ones, one after the other
  CheckTolerances tolerances;
};

struct CheckPlan {
  std::filesystem::path folder;
  std::shared_ptr<const JsonDocument> document;  ///< that nodes refer to
  std::vector<gl::Platform> platforms;           ///< that all pictures are drawn by, one after the other
  std::vector<CheckCase> cases;

  size_t pictures() const;
};

inline constexpr std::string_view kCheckDescription = "check.json";

/// Throws UsageError that names file, line and key: nothing was checked.
CheckPlan readCheckPlan(const std::filesystem::path& folder);

/// "shells-spheres-15": of the golden picture, without ".png".
std::string pictureName(const CheckCase& what, const WarpDescriptor& technique, double angleDeg);
/// Of all golden pictures, each once.
std::vector<std::string> pictureNames(const CheckPlan& plan);

enum class CheckVerdict {
  same,       ///< bit for bit
  tolerable,
  different,
  missing,    ///< there is no golden picture
  made,       ///< it was missing or different, and is to be replaced
};

struct CheckedPicture {
  std::string name;
  std::string_view platform;
  CheckVerdict verdict = CheckVerdict::same;
  std::vector<std::string> faults;  ///< "FLIP 0.012, at most 0.005"
  double flip = 0.0, psnrDb = 0.0, holes = 0.0, pixels = 0.0;  ///< as the tolerances are; of pictures of the same size
  double seconds = 0.0;             ///< that drawing took
  Image<Rgba8> actual, expected;    ///< the second is empty where there is none

  bool isFailure() const { return verdict == CheckVerdict::different || verdict == CheckVerdict::missing; }
};

/// What draws: of a scene, and for as long as what it calls takes, by a platform.
struct CheckTools {
  std::function<MarcherPtr(const Scene& scene)> makeMarcher;
  std::function<void(const MarcherPtr& marcher, gl::Platform platform, const std::function<void(const WarpResources&)>& draw)> withResources;
};

/// Draws all pictures and tells `onPicture` of each. `makes`: golden pictures that are missing or different become the picture by the first platform, and
/// later platforms are compared with that; whoever is told writes them. Throws as opening, marching and drawing do; UsageError for techniques that can show
/// nothing as the case is set.
void checkPictures(const CheckPlan& plan, bool makes, const CheckTools& tools, const std::function<void(CheckedPicture)>& onPicture, const std::stop_token& stop);

/// One page: a table of all, pictures of those that failed.
std::string checkPage(const std::vector<CheckedPicture>& pictures, const std::string& title);
/// JUnit XML, a test case a picture (the format of Apache Ant's JUnit task, as CI servers read it).
std::string checkJunit(const std::vector<CheckedPicture>& pictures, const std::string& title);
/// "FAIL shells-spheres-15 (egl): FLIP 0.012, at most 0.005".
std::string lineOf(const CheckedPicture& picture);

}  // namespace warpscope

// `check`: screenshot regression for whoever has pictures that must stay as they are.
// Exit codes: 0 all pictures are as expected, 1 some are not, 2 the description is wrong.
#include <CLI/CLI.hpp>
#include <filesystem>

#include "app/commands/options.h"
#include "app/experiment/screenshot_check.h"
#include "app/picture/picture.h"
#include "app/picture/picture_difference.h"
#include "app/shell/interrupt.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "app/shell/progress.h"
#include "render/base/error.h"
#include "render/base/printable.h"
#include "render/core/backend.h"

namespace warpscope {
namespace {

struct CheckOptions {
  CommonOptions common;  ///< of it: what is said, and on what is marched
  std::string folder, out = "out/check", junit;
  bool updates = false;
};

constexpr std::string_view kPage = "check.html";

/// Of what is written about a picture that failed: "actual", "expected" or "difference".
std::string failureName(const CheckedPicture& picture, const char* what) { return picture.name + "-" + std::string(picture.platform) + "-" + what + ".png"; }

/// Pictures of what failed; `out` gets them under their name and platform.
void writeFailure(const CheckedPicture& picture, StagedFolder& out, const std::stop_token& stop) {
  const auto write = [&](const char* what, const Image<Rgba8>& shown) {
    if (!shown.empty()) out.write(failureName(picture, what), encodePng(shown, stop));
  };
  write("actual", picture.actual);
  write("expected", picture.expected);
  if (!picture.expected.empty()) write("difference", amplifiedDifference(picture.actual, picture.expected));
}

/// Pictures of an earlier run of what is as expected now.
void removeFormer(const std::vector<CheckedPicture>& pictures, const std::filesystem::path& folder) {
  for (const CheckedPicture& picture : pictures) {
    if (picture.isFailure()) continue;
    for (const char* const what : {"actual", "expected", "difference"}) {
      std::error_code ignored;
      std::filesystem::remove(folder / failureName(picture, what), ignored);
    }
  }
}

void checkFolder(const CheckOptions& options) {
  const Interrupt interrupt;
  const Backend backend = check(options.common).backend;
  const CheckPlan plan = readCheckPlan(options.folder);
  const std::string title = "warpscope check of " + printable(std::filesystem::weakly_canonical(options.folder).filename().string());
  if (!options.junit.empty()) {
    std::vector<std::filesystem::path> read{std::filesystem::path(options.folder) / kCheckDescription};
    for (const std::string& name : pictureNames(plan)) read.push_back(plan.folder / (name + ".png"));
    requireNoneOf(options.junit, read);
    requireWritable(options.junit);
  }
  StagedFolder out(options.out, {std::string(kPage)});
  std::unique_ptr<StagedFolder> golden;
  if (options.updates) {
    std::vector<std::string> names = pictureNames(plan);
    for (std::string& name : names) name += ".png";
    golden = std::make_unique<StagedFolder>(plan.folder, names);
  }

  const CheckTools tools{
      .makeMarcher = [&](const Scene& scene) { return makeMarcher(backend, scene.volume, scene.transferFunction); },
      .withResources =
          [&](const MarcherPtr& marcher, gl::Platform platform, const std::function<void(const WarpResources&)>& draw) {
            HeadlessResources headless(marcher, platform, backend);
            draw(headless.resources());
          }};
  std::vector<CheckedPicture> pictures;
  size_t failures = 0, made = 0;
  try {
    Progress progress("check", plan.pictures(), !options.common.showsProgress());
    checkPictures(
        plan, options.updates, tools,
        [&](CheckedPicture picture) {
          progress.step(picture.name);
          logResult(lineOf(picture));
          if (picture.isFailure()) writeFailure(picture, out, interrupt.token());
          if (picture.verdict == CheckVerdict::made) golden->write(picture.name + ".png", encodePng(picture.actual, interrupt.token()));
          failures += picture.isFailure();
          made += picture.verdict == CheckVerdict::made;
          if (!picture.isFailure()) picture.actual = picture.expected = {};  // a page of thousands need not hold them
          pictures.push_back(std::move(picture));
        },
        interrupt.token());
    if (interrupt.token().stop_requested()) throw OperationCancelled();
  } catch (const OperationCancelled&) {
    if (made > 0) logWarning("none of the pictures called made was kept: " + plan.folder.string() + " is as it was");
    throw;
  }
  out.write(std::string(kPage), checkPage(pictures, title));
  if (golden) golden->commit();
  out.commit();
  removeFormer(pictures, options.out);
  if (!options.junit.empty()) writeFileWhole(options.junit, checkJunit(pictures, title), interrupt.token());
  const std::string page = (std::filesystem::path(options.out) / kPage).string();
  if (failures > 0)
    throw InputError(std::to_string(failures) + " of " + std::to_string(pictures.size()) + " pictures are not as expected; see " + page);
  logResult(std::to_string(pictures.size()) + " pictures are as expected" + (made > 0 ? ", " + std::to_string(made) + " of them made now: look at them before you keep them" : ""));
}

}  // namespace

void addCheckCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = program.add_subcommand("check", "Screenshot regression: pictures that a check.json lists, against golden ones beside it");
  command->add_option("folder", options->folder, "Folder with a check.json and golden pictures")->required();
  command->add_flag("--update", options->updates, "Make golden pictures of what is missing or different, instead of failing");
  command->add_option("--out", options->out, "Folder for check.html and pictures of what failed")->capture_default_str();
  command->add_option("--junit", options->junit, "File for the results as JUnit XML");
  addBackendOption(*command, options->common);
  addLogOptions(*command, options->common);
  command->callback([options, &chosen] { chosen = [options] { checkFolder(*options); }; });
}

}  // namespace warpscope

// With threads that stand back: the window is looked at meanwhile.
// See replay_export.h.
#include "app/session/replay_export.h"

#include <utility>

#include "app/session/own_context.h"
#include "render/base/error.h"
#include "render/core/crew_work.h"
#include "render/volume/volume_format.h"

namespace warpscope {
namespace {

/// On the worker's thread, whose context it keeps.
class ExportWork {
 public:
  ExportWork(gl::Platform platform, WarpResources resources, std::function<void()> onNews) : resources_(std::move(resources)), onNews_(std::move(onNews)) {
    resources_.context = makeOwnContext(platform);
  }

  void operator()(const ExportJob& job, ExportResult& result, const std::stop_token& stop) {
    ReplaySettings settings;
    settings.columns = job.columns;
    settings.picturesPerSecond = kExportRate;
    settings.width = job.look.sizePx.x;
    settings.height = job.look.sizePx.y;
    settings.hasLabels = job.look.hasLabels;
    settings.hasErrors = job.look.hasErrors;
    settings.resources = resources_;
    settings.resources.marcher = job.marcher;
    result.pictures = writeReplay(*job.recording, settings, job.files,
                                  [&](const std::string& /*what*/) {
                                    if (job.progress->begun == 0) job.progress->first = std::chrono::steady_clock::now();
                                    ++job.progress->begun;
                                    onNews_();
                                  },
                                  stop);
    result.made = firstOf(job.files);
  }

 private:
  WarpResources resources_;
  const std::function<void()> onNews_;
};

}  // namespace

ReplayFiles exportedAs(const std::filesystem::path& path) {
  const std::string ending = lowered(path.extension().string());
  ReplayFiles files{.folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".")};
  if (ending == ".png") {
    files.prefix = path.stem().string() + "-";
    if (const std::optional<std::filesystem::path> picture = pictureThere(files)) throw InputError(picture->filename().string() + " is there already: choose another name");
    return files;
  }
  if (ending != ".mp4" && ending != ".gif") throw InputError(path.filename().string() + ": its ending is to be .mp4 or .gif for a film, or .png for numbered pictures");
  if (!canFilm()) throw InputError("films need ffmpeg, which is not installed; a name with .png gives numbered pictures");
  files.film = path.filename().string();
  files.hasPictures = false;
  return files;
}

std::filesystem::path firstOf(const ReplayFiles& files) { return files.folder / (files.film.empty() ? pictureNameOf(files.prefix, 0) : files.film); }

ReplayExport::ReplayExport(gl::Platform platform, WarpResources resources, std::function<void()> onNews, std::shared_ptr<Crew> crew)
    : worker_(workOfCrew([platform, resources = std::move(resources), onNews]() -> ExportWorker::Work { return ExportWork(platform, resources, onNews); }, std::move(crew),
                         Crew::kOfMarches),
              onNews) {}

void ReplayExport::start(ExportJob job) {
  cancel();
  progress_ = job.progress = std::make_shared<ExportProgress>();
  hasFilm_ = !job.files.film.empty();
  steps_ = stepsOf(*job.recording, kExportRate, job.files);
  worker_.post(std::move(job));
}

std::optional<double> ReplayExport::secondsLeft() const {
  constexpr size_t kTelling = 3;  // steps begun
  const size_t begunNow = begun(), pictures = this->pictures();
  if (!isAtWork() || begunNow < kTelling || begunNow > pictures) return std::nullopt;
  const double taken = std::chrono::duration<double>(std::chrono::steady_clock::now() - progress_->first.load()).count();
  return taken * static_cast<double>(pictures - begunNow + 1) / static_cast<double>(begunNow - 1);
}

void ReplayExport::cancel() {
  worker_.cancel();
  static_cast<void>(worker_.tryTake());
  steps_ = 0;
}

std::optional<std::string> ReplayExport::takeNote() {
  const std::optional<ExportResult> result = worker_.tryTake();
  if (!result || steps_ == 0) return std::nullopt;
  steps_ = 0;
  if (!result->error.empty()) return "not exported: " + result->error;
  return "exported " + std::to_string(result->pictures) + " pictures: " + result->made.string();
}

}  // namespace warpscope

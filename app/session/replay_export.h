// A recording written as numbered pictures or as a film while the window goes on: replay_files.h in a thread of its own.
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/experiment/replay_files.h"
#include "render/base/newest_worker.h"
#include "render/core/crew.h"
#include "render/gl/context.h"

namespace warpscope {

/// Pictures a second of what the window exports: those of films.
inline constexpr double kExportRate = 30.0;

/// How its pictures are to be.
struct ExportLook {
  glm::uvec2 sizePx{0};    ///< of each technique's; 0: as on show
  bool hasLabels = true;   ///< as ReplaySettings has them
  bool hasErrors = false;
};

/// Written by the thread that exports.
struct ExportProgress {
  std::atomic<size_t> begun = 0;                               ///< steps
  std::atomic<std::chrono::steady_clock::time_point> first{};  ///< when the first one began
};

struct ExportJob {
  std::shared_ptr<const Recording> recording;
  MarcherPtr marcher;                          ///< of what was recorded, for techniques that march
  std::vector<ReplayColumn> columns;
  ExportLook look;                             ///< its size is not 0
  ReplayFiles files;
  std::shared_ptr<ExportProgress> progress;
};

struct ExportResult {
  std::string error;
  size_t pictures = 0;
  std::filesystem::path made;  ///< the film, or the first of the pictures
};

using ExportWorker = NewestWorker<ExportJob, ExportResult>;

/// Files for that name: a film where it ends with .mp4 or .gif; where it ends with .png, pictures whose names begin as it does. Throws InputError for another ending,
/// for a film without the program for it, and where there are pictures of such names: nobody was asked about those.
ReplayFiles exportedAs(const std::filesystem::path& path);
/// The film, or the first of the pictures.
std::filesystem::path firstOf(const ReplayFiles& files);

class ReplayExport {
 public:
  /// `onNews` is called on another thread after each step, and when one has ended. `crew` draws; null: all cores.
  ReplayExport(gl::Platform platform, WarpResources resources, std::function<void()> onNews, std::shared_ptr<Crew> crew);

  /// In place of one that is at work.
  void start(ExportJob job);
  /// Leaves nothing of it.
  void cancel();
  bool isAtWork() const { return steps_ > 0; }
  /// Steps that were begun, and all.
  size_t begun() const { return progress_ ? progress_->begun.load() : 0; }
  size_t steps() const { return steps_; }
  /// Of these, pictures.
  size_t pictures() const { return steps_ - (hasFilm_ ? 1 : 0); }
  /// Whether all pictures are drawn and ffmpeg makes a film of them.
  bool isFilming() const { return isAtWork() && hasFilm_ && begun() == steps_; }
  /// Seconds until all pictures are drawn, by what they have taken so far; nothing before that says anything, and then.
  std::optional<double> secondsLeft() const;
  /// What became of it, once: a sentence without its full stop.
  std::optional<std::string> takeNote();

  void requestStop() { worker_.requestStop(); }
  bool waitForEnd(std::chrono::steady_clock::time_point time) const { return worker_.waitForEnd(time); }

 private:
  std::shared_ptr<ExportProgress> progress_;
  size_t steps_ = 0;  // 0: nothing is at work
  bool hasFilm_ = false;
  ExportWorker worker_;
};

}  // namespace warpscope

// Pictures first, then the film of them.
// See replay_files.h.
#include "app/experiment/replay_files.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/picture/picture.h"
#include "app/shell/child_process.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "render/volume/volume_format.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;

/// Numbered pictures behind those that were written may be anybody's: they stay, and one is told of them.
void tellOfLaterPictures(const ReplayFiles& files, size_t count) {
  std::error_code failed;
  size_t end = count;
  while (fs::exists(files.folder / pictureNameOf(files.prefix, end), failed)) ++end;
  if (end > count)
    logWarning((files.folder / pictureNameOf(files.prefix, count)).string() + (end > count + 1 ? " to " + pictureNameOf(files.prefix, end - 1) : "") + " were there before, and are not of this recording");
}

/// As ffmpeg reads names of numbered pictures: a percent sign of a folder's name is two.
std::string patternOf(const fs::path& folder, const std::string& prefix) {
  std::string pattern;
  for (const char c : (folder / prefix).string()) pattern += c == '%' ? std::string("%%") : std::string(1, c);
  return pattern + "%06d.png";
}

/// `film`: a path in which ffmpeg can take no word for an option, or for a protocol.
void makeFilm(const std::string& pattern, const fs::path& film, size_t count, double picturesPerSecond, const std::stop_token& stop) {
  const std::string rate = nlohmann::json(picturesPerSecond).dump();
  std::vector<std::string> command{"ffmpeg", "-nostdin", "-y", "-loglevel", "error", "-framerate", rate, "-f", "image2", "-i", pattern};
  if (lowered(film.extension().string()) == ".gif") {
    for (const char* word : {"-vf", "split[a][b];[a]palettegen[p];[b][p]paletteuse"}) command.emplace_back(word);
  } else {
    for (const char* word : {"-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-movflags", "+faststart"}) command.emplace_back(word);
  }
  command.insert(command.end(), {"-frames:v", std::to_string(count), "file:" + film.string()});
  runProgram(command, stop);
}

}  // namespace

bool canFilm() { return hasProgram("ffmpeg"); }

size_t stepsOf(const Recording& recording, double picturesPerSecond, const ReplayFiles& files) {
  return pictureCount(recording, picturesPerSecond) + (files.film.empty() ? 0 : 1);
}

std::string pictureNameOf(const std::string& prefix, size_t index) {
  char number[32];
  std::snprintf(number, sizeof number, "%06zu.png", index + 1);
  return prefix + number;
}

std::optional<fs::path> pictureThere(const ReplayFiles& files) {
  const size_t length = pictureNameOf(files.prefix, 0).size();
  std::error_code failed;
  for (fs::directory_iterator at(files.folder, failed), end; !failed && at != end; at.increment(failed)) {
    const std::string name = at->path().filename().string();
    if (name.size() == length && name.starts_with(files.prefix) && name.ends_with(".png")) return at->path();
  }
  return std::nullopt;
}

size_t writeReplay(const Recording& recording, const ReplaySettings& settings, const ReplayFiles& files, const std::function<void(const std::string&)>& onStep,
                   const std::stop_token& stop) {
  requireDrawable(recording, settings);
  const size_t count = pictureCount(recording, settings.picturesPerSecond);
  std::optional<StagedFolder> folder(std::in_place, files.folder, files.film.empty() ? std::vector<std::string>{} : std::vector{files.film});
  replay(
      recording, settings,
      [&](size_t index, const Image<Rgba8>& picture) {
        onStep("picture " + std::to_string(index + 1) + " of " + std::to_string(count));
        const std::string name = pictureNameOf(files.prefix, index), bytes = encodePng(picture, stop);
        if (files.hasPictures)
          folder->write(name, bytes);
        else
          writeFileWhole(folder->placeOf(name), bytes);
      },
      stop);
  fs::path pictures = folder->placeOf("").parent_path();
  if (files.hasPictures) {
    folder->commit();
    tellOfLaterPictures(files, count);
    pictures = files.folder;
  }
  if (files.film.empty()) return count;
  onStep(files.film);
  if (files.hasPictures) folder.emplace(files.folder);
  makeFilm(patternOf(fs::absolute(pictures), files.prefix), fs::absolute(folder->placeOf(files.film)), count, settings.picturesPerSecond, stop);
  folder->add(files.film);
  folder->commit();
  return count;
}

}  // namespace warpscope

// Reading and writing what is cut off.
// See clip_settings.h.
#include "render/effects/clip_settings.h"

#include <cmath>

#include "render/base/error.h"
#include "render/effects/setting_text.h"

namespace warpscope {

std::string textOf(const ClipPlanes& planes) {
  return textOfList(planes, [](const ClipPlane& plane) {
    const float numbers[] = {plane.normal.x, plane.normal.y, plane.normal.z, plane.distance};
    return textOfNumbers(numbers);
  });
}

ClipPlanes parseClipPlanes(std::string_view text, std::string_view name) {
  constexpr Range kRange{-ClipPlanes::kFarthest, ClipPlanes::kFarthest};
  return parseList<ClipPlanes>(text, name, "planes", [&](std::string_view word) -> ClipPlane {
    const std::string what = std::string(name) + ": " + quotedSetting(word);
    float numbers[4];
    parseNumbers(word, numbers, kRange, what);
    if (!(std::hypot(numbers[0], numbers[1], numbers[2]) > 1e-9f)) throw UsageError(what + ": a plane's normal must not be a zero vector");
    return {{numbers[0], numbers[1], numbers[2]}, numbers[3]};
  });
}

std::string textOf(const ClipBox& box) {
  if (box == ClipBox{}) return "none";
  const float numbers[] = {box.lower.x, box.lower.y, box.lower.z, box.upper.x, box.upper.y, box.upper.z};
  return textOfNumbers(numbers);
}

ClipBox parseClipBox(std::string_view text, std::string_view name) {
  const std::vector<std::string_view> words = settingWords(text);
  if (words.empty()) return {};
  const std::string what = std::string(name) + ": " + quotedSetting(text);
  if (words.size() > 1) throw UsageError(what + ": wants one box, six numbers with commas between them");
  float numbers[6];
  parseNumbers(words.front(), numbers, {0.0, 1.0}, what);
  const ClipBox box{{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}};
  for (int axis = 0; axis < 3; ++axis)
    if (!(box.lower[axis] < box.upper[axis])) throw UsageError(what + ": the box is empty: its first corner must be less than its second along every axis");
  return box;
}

}  // namespace warpscope

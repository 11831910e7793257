// What a check found, as lines, as a page and as JUnit XML.
// See screenshot_check.h. XML 1.0: characters that it cannot hold do not occur in what is written here.
#include <algorithm>
#include <cmath>

#include "app/experiment/screenshot_check.h"
#include "app/picture/html_page.h"
#include "app/picture/picture_difference.h"
#include "app/picture/svg_plot.h"
#include "render/base/formatted.h"

namespace warpscope {
namespace {

std::string_view wordOf(CheckVerdict verdict) {
  switch (verdict) {
    case CheckVerdict::same: return "same";
    case CheckVerdict::tolerable: return "ok";
    case CheckVerdict::different: return "FAIL";
    case CheckVerdict::missing: return "NONE";
    case CheckVerdict::made: return "made";
  }
  return "";
}

std::string joined(const std::vector<std::string>& sentences) {
  std::string text;
  for (const std::string& sentence : sentences) text += (text.empty() ? "" : "; ") + sentence;
  return text;
}

std::string figures(const CheckedPicture& picture) {
  if (!picture.faults.empty()) return joined(picture.faults);
  if (picture.verdict == CheckVerdict::same) return "";
  return formatted("FLIP %.4f", picture.flip) + formatted(", %.2f dB", picture.psnrDb) + formatted(", %.3f %% of the pixels differ", 100.0 * picture.pixels);
}

}  // namespace

std::string lineOf(const CheckedPicture& picture) {
  const std::string what = figures(picture);
  return std::string(wordOf(picture.verdict)) + "  " + picture.name + " (" + std::string(picture.platform) + ")" + (what.empty() ? "" : ": " + what);
}

std::string checkPage(const std::vector<CheckedPicture>& pictures, const std::string& title) {
  const auto failures = static_cast<size_t>(std::count_if(pictures.begin(), pictures.end(), [](const CheckedPicture& picture) { return picture.isFailure(); }));
  std::string html = pageHead(title) + "<h1>" + escaped(title) + "</h1>\n<p class=\"dim\">" + std::to_string(pictures.size()) + " pictures, " + std::to_string(failures) +
                     " of which are not as expected. Differences are shown sixteenfold.</p>\n";
  for (const CheckedPicture& picture : pictures) {
    if (!picture.isFailure()) continue;
    html += "<h2>" + escaped(picture.name) + " (" + std::string(picture.platform) + ")</h2>\n<p>" + escaped(joined(picture.faults)) + ".</p>\n<table class=\"strip case\"><tbody><tr>";
    const auto cell = [&](const Image<Rgba8>& shown, const char* caption) {
      if (!shown.empty()) html += "<td>" + imageTag(shown, caption, 512) + caption + "</td>";
    };
    cell(picture.expected, "expected");
    cell(picture.actual, "actual");
    cell(amplifiedDifference(picture.actual, picture.expected), "difference");
    html += "</tr></tbody></table>\n";
  }
  html += "<h2>All pictures</h2>\n<div class=\"wide\"><table><thead><tr><th>picture</th><th>platform</th><th>verdict</th><th>FLIP</th><th>PSNR</th><th>pixels that differ</th></tr></thead><tbody>\n";
  for (const CheckedPicture& picture : pictures)
    html += "<tr><td>" + escaped(picture.name) + "</td><td>" + std::string(picture.platform) + "</td><td>" + std::string(wordOf(picture.verdict)) + "</td><td>" + formatted("%.4f", picture.flip) +
            "</td><td>" + (std::isfinite(picture.psnrDb) ? formatted("%.2f dB", picture.psnrDb) : "identical") + "</td><td>" + formatted("%.3f %%", 100.0 * picture.pixels) + "</td></tr>\n";
  return html + "</tbody></table></div>\n</body></html>\n";
}

std::string checkJunit(const std::vector<CheckedPicture>& pictures, const std::string& title) {
  size_t failures = 0;
  double seconds = 0.0;
  std::string cases;
  for (const CheckedPicture& picture : pictures) {
    failures += picture.isFailure();
    seconds += picture.seconds;
    cases += "    <testcase classname=\"" + escaped(title) + "." + std::string(picture.platform) + "\" name=\"" + escaped(picture.name) + "\" time=\"" + formatted("%.3f", picture.seconds) + "\"";
    cases += picture.isFailure() ? ">\n      <failure message=\"" + escaped(joined(picture.faults)) + "\"/>\n    </testcase>\n" : "/>\n";
  }
  const std::string counts = " tests=\"" + std::to_string(pictures.size()) + "\" failures=\"" + std::to_string(failures) + "\" errors=\"0\" time=\"" + formatted("%.3f", seconds) + "\"";
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites" + counts + ">\n  <testsuite name=\"" + escaped(title) + "\"" + counts + ">\n" + cases + "  </testsuite>\n</testsuites>\n";
}

}  // namespace warpscope

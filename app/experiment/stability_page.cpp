// A block for each case.
// See stability_page.h.
#include "app/experiment/stability_page.h"

#include <cmath>
#include <utility>

#include "app/picture/heat_map.h"
#include "app/picture/html_page.h"
#include "app/picture/picture.h"
#include "app/picture/svg_plot.h"
#include "render/base/formatted.h"

namespace warpscope {
namespace {

constexpr uint32_t kPicturePx = 256;
constexpr float kErrorGain = 10.0f;

std::string timeText(double ms) { return formatted(ms < 0.0995 ? "%.3f" : ms < 9.95 ? "%.2f" : "%.0f", ms); }

/// Small pictures are enlarged, pixel by pixel, so that they can be seen.
Image<Rgba8> enlarged(const Image<Rgba8>& picture) {
  const uint32_t factor = std::max(1u, kPicturePx / picture.width());
  Image<Rgba8> larger(picture.width() * factor, picture.height() * factor);
  for (uint32_t y = 0; y < larger.height(); ++y)
    for (uint32_t x = 0; x < larger.width(); ++x) larger(x, y) = picture(x / factor, y / factor);
  return larger;
}

/// Largest difference of a channel or of opacity; kErrorGain makes 1 of one that is 1/kErrorGain.
Image<Rgba8> errorMap(const Image<glm::vec4>& picture, const Image<glm::vec4>& exact) {
  Image<float> errors(exact.width(), exact.height());
  for (size_t i = 0; i < exact.size(); ++i) {
    const glm::vec4 apart = glm::abs(picture[i] - exact[i]);
    errors[i] = glm::max(glm::max(apart.r, apart.g), glm::max(apart.b, apart.a));
    if (!std::isfinite(errors[i])) errors[i] = 1.0f;
  }
  return enlarged(heatMap(errors, kErrorGain));
}

std::string pictureCell(const Image<Rgba8>& picture, const std::string& description) {
  return "<td>" + imageTag(picture, description, kPicturePx) + escaped(description) + "</td>";
}

std::string formCell(const StabilityForm& form) {
  return "<td>" + errorText(form.worst) + "</td><td>" + formatted("%.2f", 100.0 * form.wrongShare) + " %</td><td>" +
         timeText(form.time.medianMs) + "</td>";
}

std::string summaryTable(const std::vector<StabilityResult>& results) {
  std::string html =
      "<div class=\"wide\"><table><thead><tr><th rowspan=\"2\">case</th><th rowspan=\"2\">backend</th><th colspan=\"3\">stable</th>"
      "<th colspan=\"3\">textbook</th><th rowspan=\"2\">bound of stable</th><th rowspan=\"2\">stability costs</th></tr><tr>";
  for (int form = 0; form < 2; ++form) html += "<th>worst</th><th>wrong</th><th>ms</th>";
  html += "</tr></thead><tbody>\n";
  for (const StabilityResult& result : results) {
    const StabilityCase& what = *result.what;
    html += "<tr><td><a href=\"#" + escaped(std::string(what.name)) + "\">" + escaped(std::string(what.name)) + "</a></td><td>" +
            std::string(nameOf(result.backend)) + "</td>" + formCell(result.stable) + formCell(result.textbook) + "<td>" +
            errorText(what.bound) + " " + std::string(wordsOf(what.subject).error) + (result.isStable() ? "" : " <strong>exceeded</strong>") +
            "</td><td>" + formatted("%+.1f", result.costNs()) + " ns a pixel</td></tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

}  // namespace

std::string errorText(double value) { return value == 0.0 ? "0" : formatted("%.1e", value); }

std::string stabilityPage(const std::vector<StabilityResult>& results, const std::string& machine) {
  constexpr const char* kTitle = "Hard cases: stable arithmetic and the textbook's";
  std::string html = pageHead(kTitle);
  html += "<h1>" + escaped(kTitle) + "</h1>\n<p class=\"dim\">" + escaped(machine) + "</p>\n";
  html += "<p>Each case is drawn in both forms and compared with the same picture in double precision. <em>worst</em> is the largest difference of a "
          "colour channel or of opacity, from 0 to 1; <em>wrong</em> are pixels that differ by more than 1/255 or, where samples are spheres, that show "
          "another sample than the first one along their ray. For SSIM, <em>worst</em> is the difference of the number. What stability costs is the difference of the two times: it says nothing where the "
          "textbook's picture lacks what is slow to draw. Maps of errors are black where a picture is exact and brightest from 0.1 on.</p>\n" +
          summaryTable(results);
  const StabilityCase* before = nullptr;
  for (const StabilityResult& result : results) {
    const StabilityCase& what = *result.what;
    if (&what != before)
      html += "<h2 id=\"" + escaped(std::string(what.name)) + "\">" + escaped(std::string(what.name)) + ": " + escaped(std::string(what.hazard)) +
              "</h2>\n<p>" + (what.scene.empty() ? "" : "Scene <code>" + escaped(std::string(what.scene)) + "</code>. ") + "Textbook: " +
              escaped(std::string(what.textbook)) + ". The stable form is bounded by " + errorText(what.bound) + ": " +
              escaped(std::string(what.boundFrom)) + ".</p>\n";
    before = &what;
    if (result.exact.size() == 0) continue;
    const auto caption = [&](const char* form, const StabilityForm& of) {
      return std::string(form) + ": worst " + errorText(of.worst) + ", wrong " + formatted("%.2f", 100.0 * of.wrongShare) + " %";
    };
    html += "<table class=\"strip case\"><tbody><tr><th>" + std::string(nameOf(result.backend)) + "</th>" +
            pictureCell(enlarged(toScreen(result.exact, result.background)), "exact");
    for (const auto& [name, form] : {std::pair("stable", &result.stable), std::pair("textbook", &result.textbook)})
      html += pictureCell(enlarged(toScreen(form->picture, result.background)), caption(name, *form)) +
              pictureCell(errorMap(form->picture, result.exact), std::string("error of ") + name);
    html += "</tr></tbody></table>\n";
  }
  return html + "</body></html>\n";
}

}  // namespace warpscope

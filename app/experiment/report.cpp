// Writing the page.
// See report.h.
#include "app/experiment/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "app/picture/heat_map.h"
#include "app/picture/html_page.h"
#include "app/picture/picture.h"
#include "app/picture/svg_plot.h"
#include "app/picture/technique_color.h"
#include "render/base/formatted.h"

namespace warpscope {
namespace {

const char* const kScript = R"(
document.querySelectorAll('#rows th').forEach((head,column)=>head.addEventListener('click',()=>{
const body=document.querySelector('#rows tbody'),falls=head.dataset.order==='rises';
document.querySelectorAll('#rows th').forEach(other=>delete other.dataset.order);head.dataset.order=falls?'falls':'rises';
const value=row=>{const cell=row.cells[column];return cell.dataset.value===undefined?cell.textContent:+cell.dataset.value};
[...body.rows].sort((a,b)=>{const x=value(a),y=value(b);return (x<y?-1:x>y?1:0)*(falls?-1:1)}).forEach(row=>body.append(row));}));
)";

std::string milliseconds(double value) { return formatted(value < 9.95 ? "%.2f" : value < 99.5 ? "%.1f" : "%.0f", value); }
std::string percent(double fraction) { return formatted("%.1f", 100.0 * fraction); }
std::string angled(double degrees) { return formatted("%g°", degrees); }

std::string cell(const std::string& text) { return "<td>" + escaped(text) + "</td>"; }
/// What is sorted by is the value, not its text.
std::string cell(double value, const std::string& text) {
  return "<td data-value=\"" + formatted("%.9g", std::isfinite(value) ? value : 1e9) + "\">" + escaped(text) + "</td>";
}
std::string header(std::initializer_list<const char*> names) {
  std::string row = "<thead><tr>";
  for (const char* name : names) row += "<th>" + escaped(name) + "</th>";
  return row + "</tr></thead>";
}

std::string titleOf(const Summary& summary) {
  return fullNameOf(summary.configuration) + "\nFLIP " + formatted("%.4f", summary.flip) + ", holes " + percent(summary.holeFraction) + " %\n" +
         milliseconds(summary.frameMs) + " ms a frame (draw " + milliseconds(summary.drawMs) + "), server " + milliseconds(summary.serverMs) +
         " ms, " + formatted("%.0f", 1e-3 * static_cast<double>(summary.bytes)) + " kB";
}

std::string findingsTables(const Findings& findings) {
  std::string html = "<div class=\"wide\"><table>" + header({"Within", "least error with", "FLIP", "holes %", "ms a frame", "draw ms"}) + "<tbody>";
  const auto rest = [](const std::optional<Summary>& summary) {
    if (!summary) return std::string("<td class=\"dim\">nothing that was measured</td><td></td><td></td><td></td><td></td></tr>");
    return cell(fullNameOf(summary->configuration)) + cell(formatted("%.4f", summary->flip)) + cell(percent(summary->holeFraction)) +
           cell(milliseconds(summary->frameMs)) + cell(milliseconds(summary->drawMs)) + "</tr>";
  };
  for (const Findings::WithinTime& row : findings.equalTime) html += "<tr>" + cell(formatted("%g ms", row.budgetMs)) + rest(row.best);
  for (const Findings::WithinError& row : findings.equalError) html += "<tr>" + cell("FLIP " + formatted("%g", row.flip) + ", least time") + rest(row.fastest);
  return html + "</tbody></table></div>";
}

Plot errorAgainst(const SweepReport& report, const std::string& label, bool marksFront, double (*value)(const Summary&)) {
  Plot plot{{label, true}, {"FLIP, mean of the angles", true}, {}};
  std::set<size_t> front;
  if (marksFront) {
    const std::vector<size_t> indices = frontOf(report.summaries);
    front.insert(indices.begin(), indices.end());
  }
  for (const WarpDescriptor& technique : warpRegistry()) {
    PlotSeries series{std::string(technique.name), techniqueRgb(technique), {}};
    for (size_t i = 0; i < report.summaries.size(); ++i) {
      const Summary& summary = report.summaries[i];
      if (summary.configuration.technique == &technique && value(summary) > 0.0 && summary.flip > 0.0)
        series.points.push_back({value(summary), summary.flip, titleOf(summary), front.contains(i)});
    }
    if (!series.points.empty()) plot.series.push_back(std::move(series));
  }
  return plot;
}

Plot errorAgainstAngle(const SweepReport& report) {
  Plot plot{{"angle between the frame's camera and the view, degrees", false}, {"FLIP", true}, {}};
  for (const PictureStrip& strip : report.strips) {
    if (!strip.configuration.technique->usesFrame) continue;
    PlotSeries series{nameAmong(strip.configuration, report.summaries), techniqueRgb(*strip.configuration.technique), {}, true, isPapersMethod(strip.configuration) || isPointBaseline(strip.configuration)};
    for (const SweepRow& row : report.rows)
      if (row.link.empty() && row.configuration == strip.configuration)
        series.points.push_back({row.angleDeg, row.errors.flip,
                                 fullNameOf(row.configuration) + "\n" + angled(row.angleDeg) + ": FLIP " + formatted("%.4f", row.errors.flip) + ", holes " +
                                     percent(row.errors.holeFraction) + " %"});
    std::sort(series.points.begin(), series.points.end(), [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
    plot.series.push_back(std::move(series));
  }
  PlotSeries floor{"step against half of it", 0x7b8794, {}, true, true};
  for (const SweepFloor& row : report.floors)
    floor.points.push_back({row.angleDeg, row.errors.flip, "the ground truth against one of half its step\n" + angled(row.angleDeg) + ": FLIP " + formatted("%.5f", row.errors.flip)});
  std::sort(floor.points.begin(), floor.points.end(), [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
  plot.series.push_back(std::move(floor));
  for (const SweepBound::Kind kind : {SweepBound::Kind::bestDot, SweepBound::Kind::perfectWarp}) {
    PlotSeries bound{std::string(labelOf(kind)), kind == SweepBound::Kind::bestDot ? 0xa8842cu : 0x3f8f6bu, {}, true, true};
    for (const SweepBound& row : report.bounds)
      if (row.kind == kind)
        bound.points.push_back({row.angleDeg, row.errors.flip,
                                std::string(labelOf(kind)) + "\n" + angled(row.angleDeg) + ": FLIP " + formatted("%.4f", row.errors.flip) + ", " +
                                    formatted("%.1f", row.errors.psnrDb) + " dB, holes " + percent(row.errors.holeFraction) + " %"});
    std::sort(bound.points.begin(), bound.points.end(), [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
    if (!bound.points.empty()) plot.series.push_back(std::move(bound));
  }
  return plot;
}

Plot errorBehindLinks(const SweepReport& report) {
  Plot plot{{"age of the frame on show, ms", true}, {"FLIP while the camera moves", true}, {}};
  for (const WarpDescriptor& technique : warpRegistry()) {
    PlotSeries series{std::string(technique.name), techniqueRgb(technique), {}};
    for (const SweepRow& row : report.rows)
      if (!row.link.empty() && row.configuration.technique == &technique)
        series.points.push_back({row.ageMs, row.errors.flip,
                                 fullNameOf(row.configuration) + " behind " + row.link + "\nFLIP " + formatted("%.4f", row.errors.flip) + ", " +
                                     formatted("%.0f", row.ageMs) + " ms old, " + angled(std::round(10.0 * row.angleDeg) / 10.0) + " behind, " +
                                     formatted("%.1f", row.framesPerSecond) + " frames/s"});
    if (!series.points.empty()) plot.series.push_back(std::move(series));
  }
  return plot;
}

std::string stripsTable(const SweepReport& report) {
  std::string html = "<div class=\"wide\"><table class=\"strip\"><thead><tr><th></th>";
  if (report.strips.empty()) return "";
  const auto& angles = report.head.at("plan").at("angles");
  for (const auto& angle : angles) html += "<th>" + escaped(angled(angle.get<double>())) + "</th>";
  html += "</tr></thead><tbody>";
  for (const PictureStrip& strip : report.strips) {
    const std::string name = fullNameOf(strip.configuration);
    html += "<tr><th>" + escaped(nameAmong(strip.configuration, report.summaries)) + "</th>";
    for (size_t i = 0; i < strip.pictures.size(); ++i) {
      const SweepPicture& picture = strip.pictures[i];
      html += "<td>" + imageTag(toScreen(picture.image, report.background), name + " at " + angled(angles.at(i).get<double>()));
      if (strip.configuration.technique->usesFrame)
        html += imageTag(heatMap(picture.flipMap, kHeatGain), "its FLIP") + "<span class=\"dim\">FLIP " + formatted("%.4f", picture.flip) + "</span>";
      html += "</td>";
    }
    html += "</tr>";
  }
  return html + "</tbody></table></div>";
}

std::string rowsTable(const std::vector<SweepRow>& rows) {
  std::string html = "<div class=\"wide all\"><table id=\"rows\">" +
                     header({"configuration", "angle or link", "FLIP", "PSNR dB", "linear dB", "SSIM", "holes %", "guesses %", "FLIP visible", "FLIP disoccluded",
                             "kB", "server ms", "decode", "upload, build", "draw", "± spread", "ms a frame", "age ms", "flicker"}) +
                     "<tbody>\n";
  const auto optional = [](const std::optional<double>& value, const char* pattern) {
    return value ? cell(*value, formatted(pattern, *value)) : std::string("<td data-value=\"-1\"></td>");
  };
  for (const SweepRow& row : rows) {
    const bool isStill = row.link.empty();
    const double builtMs = row.cost.upload.medianMs + row.cost.build.medianMs;
    const auto decibels = [](double value) { return cell(value, std::isfinite(value) ? formatted("%.1f", value) : "equal"); };
    html += "<tr>" + cell(fullNameOf(row.configuration)) + cell(row.angleDeg, isStill ? angled(row.angleDeg) : row.link) +
            cell(row.errors.flip, formatted("%.4f", row.errors.flip)) + decibels(row.errors.psnrDb) + decibels(row.errors.psnrLinearDb) +
            cell(row.errors.ssim, formatted("%.4f", row.errors.ssim)) + cell(row.errors.holeFraction, percent(row.errors.holeFraction)) + cell(row.errors.filledFraction, percent(row.errors.filledFraction)) +
            optional(row.errors.flipVisible, "%.4f") + optional(row.errors.flipDisoccluded, "%.4f") +
            cell(static_cast<double>(row.cost.bytes), formatted("%.0f", 1e-3 * static_cast<double>(row.cost.bytes))) +
            cell(row.cost.serverMs(), milliseconds(row.cost.serverMs())) + cell(row.cost.decode.medianMs, milliseconds(row.cost.decode.medianMs)) +
            cell(builtMs, milliseconds(builtMs)) + cell(row.draw.medianMs, milliseconds(row.draw.medianMs)) +
            cell(row.draw.spreadMs, milliseconds(row.draw.spreadMs)) + cell(row.frameMs(), milliseconds(row.frameMs())) +
            (isStill ? std::string("<td data-value=\"-1\"></td>") : cell(row.ageMs, formatted("%.0f", row.ageMs))) +
            optional(row.flicker, "%.4f") + "</tr>\n";
  }
  return html + "</tbody></table></div>";
}

std::string headText(const nlohmann::json& head) {
  const nlohmann::json& machine = head.at("machine");
  std::string text = head.at("scene").get<std::string>() + ", pictures of " + std::to_string(head.at("width").get<uint32_t>()) + " x " +
                     std::to_string(head.at("height").get<uint32_t>()) + " pixels; marched on " + machine.at("backend").get<std::string>();
  for (const auto& device : machine.at("devices")) text += ", " + device.get<std::string>();
  text += "; " + std::to_string(machine.at("threads").get<unsigned>()) + " threads";
  if (const std::string openGl = machine.at("openGl").get<std::string>(); !openGl.empty()) text += "; OpenGL: " + openGl;
  return text + "; warpscope " + head.at("version").get<std::string>() + ".";
}

/// A block of that class with a paragraph for each line.
std::string paragraphs(const char* kind, const std::string& lines) {
  std::string html = "<div class=\"" + std::string(kind) + "\">";
  std::istringstream text(lines);
  for (std::string line; std::getline(text, line);) html += "<p>" + escaped(line) + "</p>";
  return html + "</div>\n";
}

/// "up", "down" or both values of a link's two directions; empty where both are nothing.
std::string bothWays(const net::DuplexLinkSettings& link, double net::LinkSettings::*member, const char* pattern, double scale) {
  const double up = scale * (link.up.*member), down = scale * (link.down.*member);
  if (up == 0.0 && down == 0.0) return "";
  if (up == down) return formatted(pattern, up);
  return (down == 0.0 ? "no limit" : formatted(pattern, down)) + " down, " + (up == 0.0 ? "no limit" : formatted(pattern, up)) + " up";
}

/// What a link does, in words: "50 ms there and back, ...".
std::string meaningOf(const net::DuplexLinkSettings& link) {
  std::string text;
  const auto add = [&](const std::string& what, const std::string& more) {
    if (!what.empty()) text += (text.empty() ? "" : "; ") + what + more;
  };
  const double roundTripMs = link.up.delayMs + link.down.delayMs;
  add(roundTripMs > 0.0 ? formatted("%g ms", roundTripMs) : "", " there and back");
  add(bothWays(link, &net::LinkSettings::jitterMs, "%g ms", 1.0), " of jitter");
  if (link.up.trace || link.down.trace) add((link.down.trace ? link.down.trace : link.up.trace)->file, ": its delays");
  add(bothWays(link, &net::LinkSettings::rateBitPerS, "%g Mbit/s", 1e-6), "");
  add(bothWays(link, &net::LinkSettings::loss, "%g %%", 100.0), " of segments lost");
  add(bothWays(link, &net::LinkSettings::outageMs, "%g ms", 1.0), " without anything every now and then");
  return text.empty() ? "nothing is simulated" : text;
}

/// Every link by its name, and what it does.
std::string linksList(const std::vector<SweepLink>& links) {
  std::string html = "<ul class=\"links\">";
  for (const SweepLink& link : links) html += "<li><strong>" + escaped(link.name) + "</strong>: " + escaped(meaningOf(link.settings)) + "</li>";
  return html + "</ul>\n";
}

std::string figure(const std::string& svg, const std::string& caption) {
  return "<figure>" + svg + "<figcaption>" + escaped(caption) + "</figcaption></figure>\n";
}

}  // namespace

std::vector<Configuration> shownConfigurations(const std::vector<Summary>& summaries, const Findings& findings) {
  std::vector<Configuration> shown;
  const auto add = [&](const Configuration& configuration) {
    if (std::find(shown.begin(), shown.end(), configuration) == shown.end()) shown.push_back(configuration);
  };
  const auto addIf = [&](const std::optional<Summary>& summary) {
    if (summary) add(summary->configuration);
  };
  for (const Summary& summary : summaries)
    if (!summary.configuration.technique->usesFrame) {
      add(summary.configuration);
      break;
    }
  addIf(findings.pointBaseline);
  addIf(findings.papersMethod);
  for (const WarpDescriptor& technique : warpRegistry()) {
    const Summary* best = nullptr;
    for (const Summary& summary : summaries)
      if (summary.configuration.technique == &technique && technique.usesFrame && (best == nullptr || summary.flip < best->flip)) best = &summary;
    if (best != nullptr) add(best->configuration);
  }
  return shown;
}

std::string htmlOf(const SweepReport& report) {
  const int draws = report.head.at("plan").at("draws").get<int>();
  std::string html = pageHead(report.title + ": accuracy against time");
  html += "<h1>" + escaped(report.title) + ": accuracy against time</h1>\n<p class=\"dim\">" + escaped(headText(report.head)) + "</p>\n";

  html += paragraphs("headline", report.findings.headline) + paragraphs("answer", report.findings.answer);
  html += "<p>One frame from the first view, warped to the camera turned by each angle, against the volume marched for that camera. Errors are of "
          "whole pictures, means over the angles (FLIP: 0 equal, 1 as different as can be); holes count as they are shown. <em>ms a frame</em> is "
          "decoding, building and drawing in the slowest view: what a picture costs at the client if every frame is new. Work that several share is "
          "charged to each. " + (draws > 1 ? "Medians of " + std::to_string(draws) + " runs" : std::string("Times of a run")) +
          " after one that warmed up and does not count; the spread is between quartiles.</p>\n";

  html += "<h2>At equal time, at equal error</h2>\n" + findingsTables(report.findings);
  constexpr const char* kShared = " Points at one place are one mark with their number.";
  html += "<h2>Error against time</h2>\n" +
          figure(svgOf(errorAgainst(report, "ms a frame", true, [](const Summary& summary) { return summary.frameMs; })),
                 "Each point is a configuration; point at it for its name. Rings: the front, which nothing beats in both; the reference needs the volume "
                 "and is not on it." + std::string(kShared));
  html += "<h2>Error against angle</h2>\n" +
          figure(svgOf(errorAgainstAngle(report)), "Dashed: the paper's method, that of 2012, and what marching itself is off by: the ground truth against "
                                                   "one of half its step.");
  html += "<h2>Error against bytes</h2>\n" +
          figure(svgOf(errorAgainst(report, "bytes a frame", false, [](const Summary& summary) { return static_cast<double>(summary.bytes); })),
                 "On the wire; for hold its picture alone, as viewers that stream images send it. Its times are those of a whole frame, with depths.");
  if (!report.links.empty())
    html += "<h2>Behind a link</h2>\n" + linksList(report.links) +
            figure(svgOf(errorBehindLinks(report)),
                   "The camera turns at " + formatted("%g", report.head.at("plan").at("speedDegPerS").get<double>()) +
                       " degrees a second; frames come through a simulated link in virtual time, with what the server and the client take as measured. "
                       "Errors are against what should be on show at that instant, so that slow drawing counts as well; means over the instants that were looked at: " +
                       std::to_string(report.head.at("plan").at("instants").get<int>()) + ".");
  html += "<h2>Pictures</h2>\n<p class=\"dim\">Beneath each picture its FLIP for each pixel, twice as bright: black is equal.</p>\n" + stripsTable(report);
  html += "<h2>All rows</h2>\n<p class=\"dim\">A click on a heading sorts.</p>\n" + rowsTable(report.rows);
  html += "<script>" + std::string(kScript) + "</script>\n</body></html>\n";
  return html;
}

}  // namespace warpscope

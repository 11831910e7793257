// `info`: what this build is and what it found on this machine.
// Every part answers for itself; a missing driver is a line of the answer, not an error.
#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/commands/options.h"
#include "app/commands/tables.h"
#include "app/scene/json_document.h"
#include "app/shell/log.h"
#include "render/base/error.h"
#include "render/core/instruction_set.h"
#include "render/cuda/devices.h"
#include "render/cuda/gl_interop.h"
#include "render/march/marcher_registry.h"
#include "render/volume/reader.h"

namespace warpscope {
namespace {

using Json = nlohmann::json;

Json describeGl(gl::Platform platform) {
  logDetail(std::string("looking for OpenGL through ") + (platform == gl::Platform::egl ? "EGL" : "OSMesa"));
  try {
    const std::unique_ptr<gl::Context> context = gl::makeHeadlessContext(platform);
    Json description{{"platform", context->platformName()}, {"renderer", context->renderer()}, {"version", context->version()}};
    if (cuda::whyUnavailable().empty()) {
      context->makeCurrent();
      const std::string reason = cuda::whyNoInterop();
      description["cudaPictures"] = reason.empty() ? "by interop" : "through page-locked memory: " + reason;
    }
    return description;
  } catch (const InputError& error) {
    return {{"unavailable", error.what()}};
  }
}

Json describeCuda() {
  logDetail("looking for CUDA devices");
  const cuda::DeviceReport report = cuda::listDevices();
  Json devices = Json::array();
  for (const cuda::Device& device : report.devices)
    devices.push_back({{"name", device.name},
                       {"computeCapability", std::to_string(device.computeMajor) + "." + std::to_string(device.computeMinor)},
                       {"memoryBytes", device.memoryBytes}});
  Json description{{"devices", devices}};
  if (!report.reason.empty()) description["unavailable"] = report.reason;
  return description;
}

template <class Table>
Json namesOf(const Table& table) {
  Json names = Json::array();
  for (const auto& entry : table) names.push_back(entry.name);
  return names;
}

Json describe(const std::vector<BuiltinScene>& scenes) {
  Json described = Json::array();
  for (const BuiltinScene& scene : scenes) described.push_back({{"name", scene.name}, {"title", scene.title}});
  return described;
}

Json describe() {
  Json backends = Json::array();
  for (const MarcherDescriptor& marcher : marcherRegistry())
    if (marcher.whyUnavailable().empty()) backends.push_back(marcher.name);
  return {{"version", WARPSCOPE_VERSION},
          {"backends", backends},
          {"cores", std::thread::hardware_concurrency()},
          {"instructionSet", instructionSet()},
          {"floatsInVector", floatsInVector()},
          {"openGl", {{"egl", describeGl(gl::Platform::egl)}, {"osmesa", describeGl(gl::Platform::osmesa)}}},
          {"cuda", describeCuda()},
          {"techniques", namesOf(warpRegistry())},
          {"heuristics", namesOf(kHeuristics)},
          {"radiusPolicies", namesOf(kRadiusPolicies)},
          {"scenes", describe(builtinScenes())},
          {"tortureScenes", describe(tortureScenes())},
          {"volumeFormats", supportedVolumeEndings()}};
}

std::string elementText(const Json& element) {
  if (element.is_string()) return element.get<std::string>();
  const std::string name = element["name"].get<std::string>();
  return element.contains("title") ? name : name + " (" + element["computeCapability"].get<std::string>() + ")";
}

void printFigure(const std::string& name, const Json& value) {
  std::cout << name << ':';
  if (value.is_array())
    for (const Json& element : value) std::cout << ' ' << elementText(element);
  else
    std::cout << ' ' << (value.is_string() ? value.get<std::string>() : value.dump());
  std::cout << '\n';
}

void printGl(const std::string& name, const Json& gl) {
  std::cout << "OpenGL, " << name << ": ";
  if (gl.contains("unavailable"))
    std::cout << gl["unavailable"].get<std::string>() << '\n';
  else
    std::cout << gl["platform"].get<std::string>() << ", " << gl["renderer"].get<std::string>() << ", "
              << gl["version"].get<std::string>()
              << (gl.contains("cudaPictures") ? ", CUDA pictures " + gl["cudaPictures"].get<std::string>() : "") << '\n';
}

void inform(const CommonOptions& options) {
  const Json info = describe();
  if (options.json) {
    std::cout << textOf(info);
    return;
  }
  std::cout << "warpscope " << WARPSCOPE_VERSION << '\n';
  printFigure("backends", info["backends"]);
  printFigure("cores", info["cores"]);
  std::cout << "instruction set: " << instructionSet() << ", vectors of " << floatsInVector() << " floats\n";
  printGl("EGL", info["openGl"]["egl"]);
  printGl("OSMesa", info["openGl"]["osmesa"]);
  printFigure("CUDA", info["cuda"].contains("unavailable") ? info["cuda"]["unavailable"] : info["cuda"]["devices"]);
  printFigure("techniques", info["techniques"]);
  printFigure("heuristics", info["heuristics"]);
  printFigure("radius policies", info["radiusPolicies"]);
  printFigure("scenes", info["scenes"]);
  printFigure("scenes that are hard on arithmetic", info["tortureScenes"]);
  printFigure("volume formats", info["volumeFormats"]);
}

}  // namespace

void addInfoCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<CommonOptions>();
  auto table = std::make_shared<std::string>();
  CLI::App* command = program.add_subcommand("info", "Version, backends, devices, formats");
  command->add_flag("--json", options->json, "One JSON document on standard output");
  std::string names;
  for (const std::string_view name : tableNames()) names += " " + std::string(name);
  command->add_option("--table", *table, "One table of what the program knows, as Markdown, and nothing else:" + names);
  addLogOptions(*command, *options);
  command->callback([options, table, &program, &chosen] {
    chosen = [options, table, &program] {
      if (!table->empty() && options->json) throw UsageError("--table and --json print different things: give one of them");
      if (table->empty()) return inform(*options);
      std::cout << tableText(*table, program);
    };
  });
}

}  // namespace warpscope

// What a comparison with another renderer needs of this one: times of single pictures, the picture, its camera and the transfer function as numbers.
// Run by vtk_march.py. Prints one JSON object; the picture is 4 floats a pixel, linear and premultiplied, as they lie in memory.
#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "app/scene/scene.h"
#include "render/base/error.h"
#include "render/core/transfer_function.h"
#include "render/march/march_setup.h"
#include "render/march/marcher_cpu.h"
#include "tests/bench/bench_main.h"

namespace warpscope {
namespace {

using Json = nlohmann::json;

Json jsonOf(const glm::vec3& v) { return {v.x, v.y, v.z}; }

double cpuSeconds() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Seconds of every run but the first, which warms up: by the clock, and of all cores together.
template <class Work>
Json timesOf(int runs, const Work& work) {
  Json wall = Json::array(), cpu = Json::array();
  for (int i = 0; i <= runs; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const double cpuStart = cpuSeconds();
    work();
    if (i == 0) continue;
    cpu.push_back(cpuSeconds() - cpuStart);
    wall.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return {{"wallS", wall}, {"cpuS", cpu}};
}

/// Colour (linear) and opacity of a unit at each whole number that 8 bits hold, as the march looks them up.
Json transferOf(const MarchedVolume& marched, const RenderSettings& settings) {
  const auto baked = marched.bakedFor(settings);
  const TransferLookup lookup = baked->table.lookup();
  Json rows = Json::array();
  for (int value = 0; value < 256; ++value) {
    const int entry = lookup.entryOf(static_cast<float>(value));
    const glm::vec4 premultiplied = lookup.entries[entry];
    const glm::vec3 color = premultiplied.a > 0.0f ? glm::vec3(premultiplied) / premultiplied.a : glm::vec3(0.0f);
    rows.push_back({color.r, color.g, color.b, lookup.unitAlphas[entry]});
  }
  return rows;
}

void run(char** arguments) {
  const Scene scene = openScene(arguments[0]);
  const auto side = static_cast<uint32_t>(std::stoul(arguments[1]));
  View view;
  view.angleDeg = std::stod(arguments[2]);
  view.distance = std::stod(arguments[3]);
  const int runs = std::stoi(arguments[4]);
  if (scene.volume->type() != VoxelType::uint8) throw InputError("only volumes of 8-bit voxels, whose every value has a line of its own");

  const Camera camera = makeCamera(scene, view, side, side);
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  Image<glm::vec4> picture;
  const Json pictures = timesOf(runs, [&] { marcher->render(camera, scene.march.render, picture, {}); });
  size_t samples = 0;
  const Json frames = timesOf(runs, [&] { samples = marcher->march(camera, scene.march).size(); });
  std::ofstream(arguments[5], std::ios::binary)
      .write(reinterpret_cast<const char*>(&picture[0]), static_cast<std::streamsize>(picture.size() * sizeof picture[0]));

  const Volume& volume = *scene.volume;
  const glm::uvec3 dims(volume.dims());
  const MarchedVolume marched(scene.volume, scene.transferFunction);
  std::cout << Json{{"pictures", pictures},
                    {"frames", frames},
                    {"samples", samples},
                    {"step", scene.march.render.step},
                    {"transfer", transferOf(marched, scene.march.render)},
                    {"volume", {{"dims", {dims.x, dims.y, dims.z}}, {"lower", jsonOf(volume.bounds().lower)}, {"edges", jsonOf(volume.geometry().voxelEdges())}}},
                    {"camera",
                     {{"eye", jsonOf(camera.eye)},
                      {"right", jsonOf(camera.right)},
                      {"up", jsonOf(camera.up)},
                      {"forward", jsonOf(camera.forward)},
                      {"tanHalfFovY", camera.tanHalfFovY}}}}
                   .dump()
            << "\n";
}

}  // namespace
}  // namespace warpscope

int main(int argc, char** argv) {
  if (argc != 7) {
    std::fputs("usage: march_frames SCENE SIDE ANGLE DISTANCE RUNS PICTURE.rgba\n", stderr);
    return 2;
  }
  return warpscope::benchMain("march_frames", [&] { warpscope::run(argv + 1); });
}

// What the program says to wrong input: the right exit code, one sentence that helps, and nothing left behind.
// Through the built program, because that is where messages and exit codes are made.
#include <sys/stat.h>

#include "tests/cli.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;

/// Bytes that are nothing: the same on every run, with zeros, line ends and what is no UTF-8 among them.
std::string garbage(size_t count) {
  std::mt19937 random(17);
  std::string bytes;
  for (size_t i = 0; i < count; ++i) bytes += static_cast<char>(random());
  return bytes;
}

class Refusal : public CommandLine {
 protected:
  static Arguments shot(Arguments arguments) {
    arguments.insert(arguments.begin(), "shot");
    arguments.insert(arguments.end(), {"-o", "a.png"});
    return arguments;
  }
  /// A scene file around "volume" and more members; the volume is small and quick.
  std::string scene(const std::string& name, const std::string& members) const {
    return folder_.write(name, "{\n  \"name\": \"mine\",\n  \"volume\": {\"procedural\": \"block\", \"size\": [9, 8, 7]}" + members + "\n}\n");
  }
};

TEST_F(Refusal, VolumesThatAreNone) {
  const std::string kilobyte(1000, 'x');
  folder_.write("short_10x10x10_uint8.raw", kilobyte.substr(1));
  folder_.write("long_10x10x10_uint8.raw", kilobyte + "y");
  folder_.write("typed_10x10x10_uint16.raw", kilobyte);
  folder_.write("misnamed.raw", kilobyte);
  folder_.write("odd_10x10_uint8.raw", kilobyte);
  folder_.write("type_10x10x10_uint9.raw", kilobyte);
  folder_.write("none_0x10x10_uint8.raw", kilobyte);
  folder_.write("big_99999999999x10x10_uint8.raw", kilobyte);
  folder_.write("product_4294967295x4294967295x4294967295_float64.raw", kilobyte);
  folder_.write("large_65536x65536x65536_float64.raw", kilobyte);
  folder_.write("empty_1x1x1_uint8.raw", "");
  folder_.write("volume.txt", kilobyte);
  fs::create_directory(folder_.path() / "folder_10x10x10_uint8.raw");
  fs::create_directory(folder_.path() / "folder.nii");
  const std::pair<std::string, std::string> wrong[] = {
      {"missing_10x10x10_uint8.raw", "missing_10x10x10_uint8.raw"},
      {"short_10x10x10_uint8.raw", "999 bytes"},
      {"long_10x10x10_uint8.raw", "1001 bytes"},
      {"typed_10x10x10_uint16.raw", "2000 bytes"},
      {"misnamed.raw", "256x256x128_uint8"},
      {"odd_10x10_uint8.raw", "256x256x128_uint8"},
      {"type_10x10x10_uint9.raw", "uint9"},
      {"none_0x10x10_uint8.raw", "none_0x10x10"},
      {"big_99999999999x10x10_uint8.raw", "99999999999"},
      {"product_4294967295x4294967295x4294967295_float64.raw", "product_"},
      {"large_65536x65536x65536_float64.raw", "large_"},
      {"empty_1x1x1_uint8.raw", "empty"},
      {"volume.txt", ".raw"},
      {"folder_10x10x10_uint8.raw", "folder_"},
      {"folder.nii", "folder.nii"},
      {"./", "./"},
      {"/dev/null", "/dev/null"},
      {"missing.json", "missing.json"},
  };
  for (const auto& [file, reason] : wrong) expectRefused(shot({file}), kFailure, {file, reason});
  for (const char* file : {"short_10x10x10_uint8.raw", "/dev/null", "missing.nii"}) expectRefused(shot({"block", "--volume", file}), kFailure, {file});
}

TEST_F(Refusal, PathsThatCannotBeLookedAt) {
  fs::create_symlink("circle.nii", folder_.path() / "circle.nii");
  fs::create_symlink("circle.json", folder_.path() / "circle.json");
  const std::string endless(300, 'n');
  for (const std::string& file : {std::string("circle.nii"), std::string("circle.json"), endless, endless + ".json", endless + "/a.nii"})
    for (const Arguments& command : {shot({file}), Arguments{"view", file}}) expectRefused(command, kFailure, {file, "cannot be looked at: "});
  for (const std::string& file : {std::string("circle.nii"), endless + ".nii"}) expectRefused(shot({"block", "--volume", file}), kFailure, {file});
  for (const std::string& file : {std::string("circle.json"), endless + ".json"}) expectRefused(shot({"block", "--tf", file}), kFailure, {file, "cannot be read: "});
  folder_.write("scene.json", "{\"name\": \"a\", \"volume\": {\"file\": \"" + endless + ".nii\"}}");
  expectRefused(shot({"scene.json"}), kFailure, {endless, "cannot be looked at: "});
  folder_.write("session.json", "{\"warpscopeSession\": 1}");
  expectRefused(shot({"session.json"}), kFailure, {"session.json", "is a session, not a scene", "warpscope view FILE"});
  folder_.write("presets.json", R"({"version": 3, "configurePresets": []})");
  expectRefused(shot({"presets.json"}), kFailure, {"presets.json", "is not a scene, which has a name and a volume"});
  expectRefused({"view", "block", "--tf", "nowhere.json"}, kFailure, {"nowhere.json"});
  expectRefused({"view", "session.json", "--heuristic", "exit"}, kUsage, {"a session says that itself: leave out --heuristic"});
}

TEST_F(Refusal, MoreFilesThanMayBeOpen) {
  for (int limit = 3; limit < 12; ++limit) {
    const ProgramResult result = runShell("ulimit -n " + std::to_string(limit) + "; exec \"$W\" shot block -o a.png --volume-size 8x8x8 --size 8x8 --quiet",
                                          folder_.path());
    for (const char* noise : {"signal_set", "terminate", "what()", "filesystem error"}) EXPECT_THAT(result.err, testing::Not(testing::HasSubstr(noise))) << limit;
    if (result.err.find("interrupts cannot be listened for: Too many open files\n") == std::string::npos) continue;
    EXPECT_EQ(result.code, kFailure) << limit;
    EXPECT_TRUE(folder_.listing().empty()) << limit;
    return;
  }
  FAIL() << "no limit was reached";
}

TEST_F(Refusal, TruncatedAndDamagedImages) {
  const std::string nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 10 10 10\nencoding: raw\n\n" + std::string(1000, 'x');
  folder_.write("cut.nrrd", nrrd.substr(0, nrrd.size() - 1));
  folder_.write("head.nrrd", nrrd.substr(0, 30));
  folder_.write("noise.nrrd", garbage(3000));
  folder_.write("empty.nrrd", "");
  // NIfTI-1: 348 bytes of header, 4 more, then the voxels.
  std::string nifti(352, '\0');
  const auto put = [&](size_t offset, auto value) { std::memcpy(nifti.data() + offset, &value, sizeof value); };
  put(0, int32_t{348});
  const int16_t dims[] = {3, 10, 10, 10, 1, 1, 1, 1};
  for (size_t i = 0; i < 8; ++i) put(40 + 2 * i, dims[i]);
  put(70, int16_t{2});  // uint8
  put(72, int16_t{8});
  for (size_t i = 0; i < 4; ++i) put(76 + 4 * i, 1.0f);
  put(108, 352.0f);
  std::memcpy(nifti.data() + 344, "n+1", 4);
  folder_.write("whole.nii", nifti + std::string(1000, 'x'));
  folder_.write("cut.nii", nifti + std::string(999, 'x'));
  folder_.write("head.nii", nifti.substr(0, 100));
  folder_.write("noise.nii", garbage(3000));
  folder_.write("noise.nii.gz", garbage(3000));
  folder_.write("cut.nii.gz", std::string("\x1f\x8b\x08\0\0\0\0\0\0\3", 10) + garbage(50));
  succeed({"shot", "whole.nii", "-o", "whole.png", "--size", "8x8"});  // what the others are made from is right
  for (const char* file : {"cut.nrrd", "head.nrrd", "noise.nrrd", "empty.nrrd", "cut.nii", "head.nii", "noise.nii", "noise.nii.gz", "cut.nii.gz"})
    expectRefused(shot({file}), kFailure, {file});
}

TEST_F(Refusal, NumbersOutOfRange) {
  const std::pair<Arguments, std::string> wrong[] = {
      {{"--view-angle", "nan"}, "--view-angle"},   {{"--view-angle", "inf"}, "--view-angle"}, {{"--view-angle", "361"}, "360"},
      {{"--view-angle", "left"}, "--view-angle left: give a number"}, {{"--seed=-1"}, "--seed -1: give a whole number from 0 on"}, {{"--seed", "1.5"}, "--seed 1.5: give a whole number"},
         {{"--fov", "0"}, "--fov"},                 {{"--fov", "180"}, "180"},
      {{"--fov", "nan"}, "--fov"},                 {{"--fov", "-40"}, "--fov"},               {{"--fov", "1e-30"}, "0.001 and 170"},
      {{"--size", "0x0"}, "--size 0x0"},           {{"--size", "100000x100000"}, "16384"},    {{"--size", "10"}, "WxH"},
      {{"--size", "8193x8192"}, "67108864 in all"}, {{"--size", "16384x16384"}, "67108864 in all"},
      {{"--size", "axb"}, "WxH"},                  {{"--size", "10x"}, "WxH"},                {{"--size", "-10x10"}, "WxH"},
      {{"--size", "10x10x10"}, "WxH"},             {{"--size", "10x10 "}, "WxH"},             {{"--size", "4294967306x10"}, "WxH"},
      {{"--size", "x"}, "WxH"},                    {{"--point-size", "0"}, "1 and 16"},       {{"--point-size", "17"}, "1 and 16"},
      {{"--hits", "0"}, "1 and 16"},               {{"--hits", "17"}, "1 and 16"},            {{"--hits", "x"}, "--hits"},
      {{"--point-size", "2.5"}, "point-size"},     {{"--step", "0"}, "step"},                 {{"--step", "nan"}, "step"},
      {{"--step", "1e-9"}, "not 1e-09"},               {{"--step", "-1"}, "step"},                {{"--radius-scale", "0"}, "--radius-scale"},
      {{"--seed", "-1"}, "seed"},                  {{"--seed", "99999999999"}, "seed"},       {{"--volume-size", "0x1x1"}, "XxYxZ"},
      {{"--volume-size", "10x10"}, "XxYxZ"},       {{"--uncovered", "red"}, "RRGGBB"},        {{"--uncovered", "#1234567"}, "RRGGBB"},
      {{"--filled", "green"}, "--filled green"},   {{"--fill", "poxy"}, "did you mean 'proxy'"},  {{"--keep", "0"}, "--keep"},
      {{"--keep", "9"}, "1 and 8"},                {{"--mesh-cut", "0"}, "--mesh-cut"},           {{"--picture-plane", "near"}, "middle"},
      {{"--fill", "proxy", "--proxy", "0"}, "--proxy is 0"}, {{"--technique", "proxy", "--proxy", "0"}, "more than 0"},
      {{"--show", "hols"}, "did you mean 'holes'"},     {{"--show", "holes", "--range", "1"}, "--range is for contents with a ramp"},
      {{"--range", "1"}, "--range is for contents with a ramp"}, {{"--show", "flip", "--range", "0"}, "--range"},
      {{"--show", "depth", "--technique", "reference"}, "reference draws none"},
  };
  for (const auto& [arguments, reason] : wrong) expectRefused(shot(arguments), kUsage, {reason});
  for (const char* value : {"179.99", "170.0000001", "0.000999"})
    expectRefused(shot({"--fov", value}), kUsage, {std::string("--fov must be between 0.001 and 170, not ") + value});
  for (const char* value : {"0.001", "170"}) succeed(quick({"shot", "-o", "/dev/null", "--fov", value}));
  // As typed, and not what is left of it in single precision.
  for (const char* option : {"--step", "--radius-scale"})
    for (const char* value : {"1e-300", "-1e-300", "1e+300", "0.0009999999999", "1000.0000001"})
      expectRefused(shot({option, value}), kUsage, {std::string(option) + " must be between 0.001 and 1000, not " + value});
  for (const char* width : {"15", "0", "4097", "wide"}) expectRefused({"compare", "--out", "o", "--cell", width}, kUsage, {"--cell"});
}

TEST_F(Refusal, SurfacesThatAreNone) {
  const Arguments block{"block", "--volume-size", "9x8x7", "--mode", "isosurface"};
  const auto with = [&](const Arguments& more) {
    Arguments arguments = block;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  expectRefused(shot(block), kUsage, {"wants the values of its surfaces", "--isovalues"});
  expectRefused(shot(with({"--isovalues", "100 70000"})), kUsage, {"the iso-value 70000 lies outside the volume's range, 0 to "});
  expectRefused(shot(with({"--isovalues", "100@2"})), kUsage, {"--isovalues", "between 0 and 1"});
  expectRefused(shot(with({"--isovalues", "1 2 3 4 5"})), kUsage, {"at most 4 values"});
  Arguments plan = with({"--isovalues", "70000"});
  plan.insert(plan.begin(), "plan");
  expectRefused(plan, kUsage, {"70000"});
  expectRefused(shot({scene("surfaces.json", ", \"march\": {\"mode\": \"isosurface\"}")}), kUsage, {"wants the values of its surfaces"});
  succeed(quick({"shot", "block", "-o", "/dev/null", "--mode", "isosurface", "--isovalues", "100"}));
}

TEST_F(Refusal, UnknownNamesAreAnsweredWithTheNearest) {
  const std::pair<Arguments, std::vector<std::string>> wrong[] = {
      {{"--technique", "sphere"}, {"technique", "sphere", "spheres"}},
      {{"--technique", "Points"}, {"points"}},
      {{"blok"}, {"scene", "blok", "block"}},
      {{"--heuristic", "gradiant"}, {"heuristic", "gradiant", "gradient"}},
      {{"--radius", "voxl"}, {"radius", "voxl", "voxel"}},
      {{"--backend", "cude"}, {"backend", "cude", "cuda"}},
      {{"--gl", "elg"}, {"OpenGL", "elg", "egl"}},
      {{"--via", "lbhv"}, {"lbhv", "lbvh"}},
      {{"--technique", ""}, {"technique"}},
      {{""}, {"scene"}},
  };
  for (const auto& [arguments, reasons] : wrong) expectRefused(shot(arguments), kUsage, reasons);
}

TEST_F(Refusal, OptionsThatAreMissingOrUnknown) {
  const std::pair<Arguments, std::string> wrong[] = {
      {{"shot"}, "--out"},
      {{"compare"}, "--out"},
      {{"shot", "-o"}, "--out"},
      {{"shot", "-o", "a.png", "--bogus"}, "--bogus"},
      {{"shot", "-o", "a.png", "block", "shells"}, "shells"},
      {{"info", "--bogus"}, "--bogus"},
      {{"info", "block"}, "block"},
      {{"bogus"}, "bogus"},
      {{"--bogus"}, "--bogus"},
      {{"shot", "-o", "a.png", "--size"}, "--size"},
      {{"shot", "-o", "a.png", "--size", "9x9", "--size", "8x8"}, "--size is given more than once"},
  };
  for (const auto& [arguments, reason] : wrong) expectRefused(arguments, kUsage, {reason, "--help"});
  const std::pair<Arguments, std::vector<std::string>> near[] = {
      {{"shot", "--heuristik", "median", "-o", "a.png"}, {"unknown option '--heuristik'; did you mean '--heuristic'?", "(see warpscope shot --help)"}},
      {{"compare", "--otu", "o"}, {"unknown option '--otu'; did you mean '--out'?", "(see warpscope compare --help)"}},
      {{"export", "--plx=a.ply"}, {"unknown option '--plx'; did you mean '--ply'?", "(see warpscope export --help)"}},
      {{"shot", "-o", "a.png", "--incomprehensible"}, {"unknown option '--incomprehensible' (see"}},
      {{"shto", "-o", "a.png"}, {"unknown command 'shto'; did you mean 'shot'?"}},
      {{"comapre"}, {"unknown command 'comapre'; did you mean 'compare'?", "(see warpscope --help)"}},
      {{"frobnicate"}, {"unknown command 'frobnicate'; known: view serve shot compare"}},
  };
  for (const auto& [arguments, reasons] : near) expectRefused(arguments, kUsage, reasons);
}

/// The next option's name is no value: `--out --quiet` would write a file named --quiet.
TEST_F(Refusal, OptionsWithoutTheirValue) {
  const std::pair<Arguments, std::string> wrong[] = {
      {{"shot", "--out", "--quiet"}, "--out needs a value"},
      {{"shot", "-o", "--json"}, "--out needs a value"},
      {{"shot", "--technique", "-o", "a.png"}, "--technique needs a value"},
      {{"shot", "--heuristic=", "-o", "a.png"}, "--heuristic needs a value"},
      {{"shot", "--out", "--bogus"}, "--out needs a value"},
      {{"shot", "--out", ""}, "--out needs a value"},
      {{"shot", "-o", ""}, "--out needs a value"},
      {{"shot", "-o", "a.png", "--size", ""}, "--size needs a value"},
      {{"shot", "-o", "a.png", "--volume", ""}, "--volume needs a value"},
      {{"shot", "-o", "a.png", "--size"}, "--size needs a value"},
      {{"compare", "--out", ""}, "--out needs a value"},
      {{"compare", "--out", "--quiet"}, "--out needs a value"},
      {{"export"}, "give --ply, --spread-map or both"},
      {{"export", "--spread-map", ""}, "--spread-map needs a value"},
      {{"export", "--ply", "a", "--spread-map", "a"}, "--ply and --spread-map are the same file: a"},
      {{"export", "--ply", "a", "--spread-map", "./b/../a"}, "--ply and --spread-map are the same file: a"},
      {{"export", "--ply", "--size"}, "--ply needs a value"},
      {{"export", "--ply", ""}, "--ply needs a value"},
      {{"view", "--screenshot", ""}, "--screenshot needs a value"},
  };
  for (const auto& [arguments, reason] : wrong) expectRefused(arguments, kUsage, {reason});
  succeed(quick({"shot", "--out", "./--quiet", "--view-angle", "-20"}));
  succeed(quick({"shot", "-o", "scene"}));  // what an argument is called is no option
  EXPECT_EQ(folder_.listing(), (std::vector<std::string>{"--quiet", "scene"}));
}

TEST_F(Refusal, HierarchiesWhereTheyAreNot) {
  expectRefused(shot({"--via", "clusters", "--backend", "cpu"}), kUsage, {"clusters", "CUDA"});
}

TEST_F(Refusal, BenchesOfNothing) {
  expectRefused({"bench", "block", "--runs", "0"}, kUsage, {"--runs"});
  expectRefused({"bench", "block", "--runs", "1.5"}, kUsage, {"--runs"});
  expectRefused({"bench", "block", "--technique", "reference"}, kUsage, {"reference", "no frames"});
  expectRefused({"bench", "block", "--against", "nowhere.json"}, kFailure, {"nowhere.json"});
  std::ofstream(folder_.path() / "other.json") << R"({"backends": [{"backend": "cpu"}]})";
  expectRefused({"bench", "block", "--against", (folder_.path() / "other.json").string()}, kFailure, {"other.json", "no figures"});
  expectRefused({"bench", "block", "--technique", "sphere"}, kUsage, {"sphere", "spheres"});
  expectRefused({"bench", "block", "--technique", "segments", "--segments", "0"}, kUsage, {"segments", "--segments 0"});
  expectRefused({"bench", "block", "--technique", "proxy", "--proxy", "0"}, kUsage, {"proxy", "--proxy 0"});
  expectRefused({"sweep", "block", "--volume-size", "16x16x16", "--out", (folder_.path() / "swept").string(), "--techniques", "spheres", "--fills", "proxy", "--proxy-sizes", "0"}, kUsage,
                {"spheres", "fill gaps", "--proxy 0"});
}

TEST_F(Refusal, CudaWithoutAGpuSaysWhy) {
  const ProgramResult info = run({"info", "--json"});
  if (!nlohmann::json::parse(info.out)["cuda"]["devices"].empty()) GTEST_SKIP() << "this machine has a GPU";
  expectRefused(shot({"--backend", "cuda"}), kFailure, {"cuda", "cannot be used"});
  expectRefused({"compare", "--out", "o", "--backend", "cuda"}, kFailure, {"cuda", "cannot be used"});
}

TEST_F(Refusal, PlacesThatCannotBeWrittenTo) {
  // Not by permissions, which root does not feel.
  folder_.write("file", "x");
  fs::create_directory(folder_.path() / "folder");
  for (const std::string place : {"file/a.png", "folder", "/proc/a.png", "missing/a.png", "folder/"}) {
    expectRefused(quick({"shot", "-o", place}), kFailure, {"cannot be written"});
    expectRefused(quick({"export", "--ply", place}), kFailure, {"cannot be written"});
  }
  for (const std::string place : {"file", "file/deeper", "/proc/out", "/proc/out/deeper"})
    expectRefused(quick({"compare", "--out", place}), kFailure, {"folder"});
  // A folder where a picture has to go: found out before anything is put in place.
  fs::create_directories(folder_.path() / "out/montage.png");
  expectRefused(quick({"compare", "--out", "out"}), kFailure, {"montage.png"});
}

TEST_F(Refusal, WherePicturesGoIsCheckedBeforeTheWork) {
  // 8192 x 8192 pixels would take minutes.
  const auto start = std::chrono::steady_clock::now();
  expectRefused({"shot", "block", "-o", "missing/a.png", "--size", "8192x8192", "--volume-size", "8x8x8"}, kFailure, {"missing/a.png"});
  expectRefused({"view", "--screenshot", "missing/a.png", "--after-ms", "3600000"}, kFailure, {"missing/a.png: cannot be written"});
  expectRefused({"export", "block", "--ply", "/proc/a.ply", "--size", "8192x8192", "--volume-size", "8x8x8"}, kFailure, {"/proc/a.ply"});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST_F(Refusal, WhatIsReadIsNotWrittenTo) {
  folder_.write("scene.json", "{}");
  folder_.write("f.json", "{}");
  for (const std::string option : {"--record", "--report"}) {
    expectRefused({"view", "scene.json", option, "./scene.json"}, kUsage, {"./scene.json is read here, and would be lost"});
    expectRefused({"view", "block", "--tf", "f.json", option, "f.json"}, kUsage, {"f.json is read here"});
  }
  expectRefused({"view", "block", "--screenshot", "a.nrrd"}, kUsage, {"--screenshot writes PNG files"});
  folder_.write("v_2x2x2_uint8.raw", "12345678");
  folder_.write("of.json", R"({"name": "a", "volume": {"file": "v_2x2x2_uint8.raw"}})");
  for (const std::string scene : {"v_2x2x2_uint8.raw", "of.json"}) {
    expectRefused({"export", scene, "--size", "8x8", "--ply", "v_2x2x2_uint8.raw"}, kUsage, {"v_2x2x2_uint8.raw is read here"});
    expectRefused({"serve", scene, "--listen", "127.0.0.1:0", "--port-file", "v_2x2x2_uint8.raw"}, kUsage, {"v_2x2x2_uint8.raw is read here"});
  }
  std::filesystem::create_symlink("v_2x2x2_uint8.raw", folder_.path() / "link.png");
  expectRefused({"shot", "of.json", "-o", "of.json", "--size", "8x8"}, kUsage, {"of.json"});
  for (const std::string scene : {"v_2x2x2_uint8.raw", "of.json"}) expectRefused({"shot", scene, "-o", "link.png", "--size", "8x8"}, kUsage, {"link.png is read here"});
  EXPECT_EQ(folder_.read("v_2x2x2_uint8.raw"), "12345678");
  folder_.write("metrics.json", R"({"name": "a", "volume": {"procedural": "block", "size": [8, 8, 8]}})");
  expectRefused({"compare", "metrics.json", "--out", ".", "--size", "8x8"}, kUsage, {"metrics.json is read here"});
  folder_.write("sweep.json", R"({"techniques": ["hold"], "angles": [0]})");
  expectRefused({"sweep", "block", "--volume-size", "8x8x8", "--plan", "sweep.json", "--out", ".", "--size", "8x8"}, kUsage, {"sweep.json is read here"});
  expectRefused({"view", "block", "--record", "a.out", "--report", "./a.out"}, kUsage, {"--report and --record are the same file"});
  EXPECT_EQ(folder_.read("scene.json"), "{}");
}

TEST_F(Refusal, PicturesOfOtherKinds) {
  for (const std::string file : {"a.bmp", "a.tiff", "a.jpg.txt"})
    expectRefused({"shot", "-o", file}, kUsage, {"--out " + file + ": pictures are written as .png or .jpg, not as " + file.substr(file.rfind('.'))});
}

TEST_F(Refusal, SceneFiles) {
  const auto refuse = [&](const std::string& file, const std::vector<std::string>& reasons) { expectRefused(shot({file}), kFailure, reasons); };
  succeed({"shot", scene("right.json", ""), "-o", "right.png", "--size", "8x8"});
  scene("type.json", ",\n  \"fovYDeg\": \"wide\"");
  refuse("type.json", {"type.json:4", "'fovYDeg'", "number", "string"});
  scene("deep.json", ",\n  \"views\": [\n    {},\n    {\"pan\": [0, true]}\n  ]");
  refuse("deep.json", {"deep.json:6", "'views.1.pan.1'", "number", "boolean"});
  scene("unknown.json", ",\n  \"fovDeg\": 30");
  refuse("unknown.json", {"unknown.json:4", "'fovDeg'", "fovYDeg"});
  scene("range.json", ",\n  \"fovYDeg\": 180");
  refuse("range.json", {"range.json:4", "'fovYDeg'", "180"});
  scene("heuristic.json", ",\n  \"march\": {\"heuristic\": \"gradiant\"}");
  refuse("heuristic.json", {"heuristic.json:4", "'march.heuristic' holds an unknown heuristic 'gradiant'; did you mean 'gradient'?"});
  scene("twice.json", ",\n  \"name\": \"b\"");
  refuse("twice.json", {"twice.json:4", "'name'", "twice"});
  scene("views.json", ",\n  \"views\": []");
  refuse("views.json", {"views.json:4", "'views'"});
  folder_.write("size.json", R"({"name": "mine", "volume": {"procedural": "block", "size": [8, 8.9, 8]}})");
  refuse("size.json", {"size.json:1", "'volume.size.1'", "whole number"});
  scene("step.json", ",\n  \"march\": {\"step\": 0.0009}");
  refuse("step.json", {"step.json:4", "'march.step'", "0.001", "1000"});
  scene("axes.json", ",\n  \"up\": [0, 0, 2], \"front\": [0, 0, -1]");
  refuse("axes.json", {"axes.json:4", "'front' and 'up' are parallel"});
  scene("up.json", ",\n  \"up\": [0, 0, 2]");
  refuse("up.json", {"up.json:4", "'up' and the direction that 'front' has by itself are parallel"});
  scene("front.json", ",\n  \"front\": [0, -3, 0]");
  refuse("front.json", {"front.json:4", "'front' and the direction that 'up' has by itself are parallel"});
  scene("empty.json", ",\n  \"mask\": {\"file\": \"\"}");
  refuse("empty.json", {"empty.json:4", "'mask.file' must not be empty"});
  scene("iso.json", ",\n  \"march\": {\"mode\": \"isosurface\", \"isovalues\": \"700\"}");
  refuse("iso.json", {"iso.json:4", "'march' cannot be", "700"});
  scene("far.json", ",\n  \"fovYDeg\": 0.001, \"views\": [{}, {\"distance\": 1000}]");
  refuse("far.json", {"far.json:4", "'views.1' cannot be"});
  folder_.write("v_2x2x2_uint8.raw", "12345678");
  folder_.write("sized.json", "{\"name\": \"a\",\n\"volume\": {\"file\": \"v_2x2x2_uint8.raw\",\n\"size\": [2, 2, 2]}}");
  refuse("sized.json", {"sized.json:3", "'volume.size' is for procedural volumes"});
  folder_.write("spaced.json", "{\"name\": \"a\",\n\"volume\": {\"procedural\": \"block\",\n\"spacing\": [2, 2, 2]}}");
  refuse("spaced.json", {"spaced.json:3", "'volume.spacing' is for raw files"});
  folder_.write("nameless.json", "{\n\"name\": \"\",\n\"volume\": {\"procedural\": \"block\"}}");
  refuse("nameless.json", {"nameless.json:2", "'name' must not be empty"});
  for (const Arguments& command : {shot({"block", "--volume", "v_2x2x2_uint8.raw"}), shot({"v_2x2x2_uint8.raw"}), shot({"right.json", "--volume", "v_2x2x2_uint8.raw"})}) {
    Arguments sized = command;
    sized.insert(sized.end(), {"--volume-size", "4x4x4"});
    expectRefused(sized, kUsage, {"--volume-size is for built-in volumes"});
  }
  folder_.write("none.json", "{\"name\": \"a\"}");
  refuse("none.json", {"none.json:1", "'volume'"});
  folder_.write("elsewhere.json", "{\"name\": \"a\", \"volume\": {\"file\": \"gone_2x2x2_uint8.raw\"}}");
  refuse("elsewhere.json", {"gone_2x2x2_uint8.raw"});
  folder_.write("empty.json", "");
  refuse("empty.json", {"empty.json"});
  folder_.write("array.json", "[]");
  refuse("array.json", {"array.json", "object"});
  folder_.write("null.json", "null");
  refuse("null.json", {"null.json", "object"});
  folder_.write("open.json", "{\"name\": \"a\",\n\"volume\": ");
  refuse("open.json", {"open.json:2"});
  folder_.write("garbage.json", garbage(5000));
  refuse("garbage.json", {"garbage.json", "JSON"});
  folder_.write("zeros.json", std::string(5000, '\0'));
  refuse("zeros.json", {"zeros.json", "JSON"});
  folder_.write("nested.json", std::string(100'000, '['));
  refuse("nested.json", {"nested.json", "64"});
  folder_.write("huge.json", "{\"name\": 1e999}");
  refuse("huge.json", {"huge.json:1"});
  fs::create_directory(folder_.path() / "folder.json");
  refuse("folder.json", {"folder.json", "irectory"});
}

TEST_F(Refusal, TransferFunctionFiles) {
  const auto refuse = [&](const std::string& text, const std::vector<std::string>& reasons) {
    folder_.write("tf.json", text);
    expectRefused(quick(shot({"--tf", "tf.json"})), kFailure, reasons);
  };
  const std::string point = "{\"value\": 1, \"color\": [1, 1, 1], \"alpha\": 0.5}";
  folder_.write("tf.json", "{\"points\": [" + point + "]}");
  succeed(quick({"shot", "--tf", "tf.json", "-o", "right.png"}, "8x8"));
  refuse("", {"tf.json"});
  refuse("{}", {"tf.json:1", "'points'"});
  refuse("{\"points\": []}", {"tf.json:1", "'points'"});
  refuse("{\"points\": [\n" + point + ",\n{\"value\": 0, \"color\": [1, 1, 1], \"alpha\": 0.5}]}", {"tf.json:3", "'points.1.value'"});
  refuse("{\"points\": [\n{\"value\": 0, \"color\": [1, 1], \"alpha\": 0.5}]}", {"tf.json:2", "'points.0.color'", "3"});
  refuse("{\"points\": [\n{\"value\": 0, \"color\": [1, 1, 1], \"alpha\": 1.5}]}", {"tf.json:2", "'points.0.alpha'", "1.5"});
  refuse("{\"points\": [\n{\"value\": 0, \"colour\": [1, 1, 1], \"alpha\": 1}]}", {"tf.json:2", "colour", "color"});
  refuse(garbage(100), {"tf.json"});
  for (const char* file : {"missing.json", ".", "/dev/null"}) expectRefused(quick(shot({"--tf", file})), kFailure, {file});
}

TEST_F(Refusal, NamesThatAreNoTextDoNotHarm) {
  const std::string name = "\xff\xfe.png";
  const ProgramResult result = succeed(quick({"shot", "-o", name, "--json"}, "8x8"));
  EXPECT_TRUE(nlohmann::json::accept(result.out)) << result.out;
  EXPECT_EQ(folder_.listing(), std::vector<std::string>{name});
  expectRefused(shot({"two\nlines.raw"}), kFailure, {"lines.raw"});
}

TEST_F(Refusal, OutputThatCannotBePrintedIsAFailure) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  for (const char* const arguments : {"info --json", "--help", "shot --help", "--version"}) {
    SCOPED_TRACE(arguments);
    const std::string command = std::string("'") + WARPSCOPE_PROGRAM + "' " + arguments + " >/dev/full 2>'" + folder_.file("err") + "'";
    const int status = std::system(command.c_str());
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), kFailure);
    EXPECT_THAT(folder_.read("err"), testing::StartsWith("warpscope: "));
  }
}

}  // namespace
}  // namespace warpscope

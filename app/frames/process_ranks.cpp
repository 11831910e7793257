// Opening the library for MPI.
// See process_ranks.h. How launchers say that they have started a process: Open MPI, MPICH's Hydra (which Intel MPI has too) and Slurm set these variables.
#include "app/frames/process_ranks.h"

#include <dlfcn.h>

#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <mutex>
#include <optional>
#include <span>
#include <sstream>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "app/frames/backend.h"
#include "app/shell/interrupt.h"
#include "app/shell/log.h"
#include "app/shell/watched_process.h"
#include "render/base/error.h"
#include "render/base/memory_limit.h"
#include "render/march/ray_relay.h"

namespace warpscope {
namespace {

struct Joined {
  RanksPtr ranks;
  VolumePtr volume;  ///< that is led
  BrickLeaderPtr leader;
};
Joined& joined() {
  static Joined& processes = *new Joined;  // never torn down: an MPI that ends a process by exit() would come to itself again
  return processes;
}

/// While it lives, the process has a moment to end by itself, and is ended then. A launcher that ends all, on Ctrl-C, tells them so and then sleeps (Open MPI's mpirun for a
/// second): MPI's own ways to end wait for it, and whoever is still there when it wakes up makes it sleep once more.
class EndAnyway {
 public:
  explicit EndAnyway(int code) : thread_([code](const std::stop_token& isNoLonger) {
    constexpr std::chrono::milliseconds kMoment(400);
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any().wait_for(lock, isNoLonger, kMoment, [] { return false; });
    if (!isNoLonger.stop_requested()) std::_Exit(code);
  }) {}

 private:
  std::jthread thread_;
};

/// Beside the program, or where packages keep a program's own libraries.
std::string libraryPath() {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  for (const std::filesystem::path& path : {folder / "warpscope_mpi.so", folder / "../lib/warpscope/warpscope_mpi.so"})
    if (std::filesystem::exists(path, error)) return path.string();
  return {};
}

/// Entries of /dev for the devices that this machine, or this container, has.
int countDevices() {
  int count = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("nvidia") && name.size() > 6 && name.find_first_not_of("0123456789", 6) == std::string::npos) ++count;
  }
  return count;
}

/// The first of these variables that is set to a number.
std::optional<int> numberOf(std::initializer_list<const char*> names) {
  for (const char* const name : names) {
    const char* const value = std::getenv(name);
    if (value == nullptr) continue;
    int number = 0;
    const std::string_view text(value);
    if (std::from_chars(text.data(), text.data() + text.size(), number).ec == std::errc{}) return number;
  }
  return {};
}

/// Each process of a machine has a CUDA device for itself, as long as there are enough: it sees no other. Of those that whoever started it lets it see, if somebody
/// has said so (CUDA C++ Programming Guide, "CUDA Environment Variables"). Before MPI is loaded, which may ask for devices.
void takeOwnDevice() {
  const std::optional<int> place = numberOf({"OMPI_COMM_WORLD_LOCAL_RANK", "MPI_LOCALRANKID", "SLURM_LOCALID"});
  if (!place || *place < 0) return;
  constexpr const char* kVisible = "CUDA_VISIBLE_DEVICES";
  std::vector<std::string> devices;
  if (const char* const visible = std::getenv(kVisible)) {
    std::istringstream list(visible);
    for (std::string device; std::getline(list, device, ',');) devices.push_back(device);
  } else {
    for (int i = 0; i < countDevices(); ++i) devices.push_back(std::to_string(i));
  }
  if (devices.empty()) return;
  const int count = static_cast<int>(devices.size()), processes = numberOf({"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS", "SLURM_NTASKS_PER_NODE"}).value_or(1);
  setDeviceSharers((processes + count - 1) / count);
  if (count > 1) setenv(kVisible, devices[static_cast<size_t>(*place % count)].c_str(), 1);
}

/// Processes that were started together.
int countLaunched() { return numberOf({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"}).value_or(1); }

}  // namespace

std::optional<int> goOnWatched() {
  const int count = countLaunched();
  if (count < 2) return {};
  const std::optional<int> rank = numberOf({"OMPI_COMM_WORLD_RANK", "PMI_RANK", "SLURM_PROCID"});
  return goOnInChild("warpscope: " + (rank ? "process " + std::to_string(*rank) : std::string("one")) + " of " + std::to_string(count) + " ");
}

RanksPtr joinProcesses() {
  const int count = countLaunched();
  if (count < 2) return nullptr;
  takeOwnDevice();
  const std::string path = libraryPath();
  if (path.empty())
    throw InputError("started as one of several processes, but its library for MPI (warpscope_mpi.so) is not beside the program: build it where Debian's libopenmpi-dev is installed");
  void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_GLOBAL);
  if (library == nullptr) throw InputError("MPI cannot be used: " + std::string(dlerror()));
  const auto make = reinterpret_cast<Ranks* (*)(std::string*)>(dlsym(library, "warpscopeMpiRanks"));
  if (make == nullptr) throw InputError(path + ": is of another version");
  std::string reason;
  joined().ranks.reset(make(&reason));
  if (!joined().ranks) throw InputError(reason);
  joined().ranks->complainBy([](const std::string& sentence) { printLine("warpscope: " + sentence); });
  if (const int known = joined().ranks->size(); known != count)
    throw InputError("the launcher started " + std::to_string(count) + " processes, but MPI knows of " + std::to_string(known) +
                     ": they are of different kinds; with Slurm, try srun --mpi=pmix");
  // What goes between them is as it is in memory.
  std::string version(WARPSCOPE_VERSION);
  for (const size_t size : {sizeof(Camera), sizeof(RenderSettings), sizeof(SampleSettings), sizeof(RelayedState), sizeof(SegmentMerger), sizeof(RelayedAgain)})
    version += " " + std::to_string(size);
  joined().ranks->requireSame(std::as_bytes(std::span<const char>(version)), "version of warpscope");
  return joined().ranks;
}

const RanksPtr& processRanks() { return joined().ranks; }

BrickLeaderPtr leaderOf(const VolumePtr& volume, Backend backend) {
  Joined& all = joined();
  if (!volume->ranks()) return nullptr;
  if (!all.leader) {
    all.leader = leadRanks(volume, kRankPatience, makePieces(backend));
    all.volume = volume;
  }
  if (all.volume != volume) throw InputError("several processes share one volume at a time");
  return all.leader;
}

void followFirst(const VolumePtr& volume, Backend backend, const std::stop_token& stop) {
  // Where it has not ended all already, whoever started this process may let the others be.
  if (!followRanks(volume, stop, makePieces(backend))) endProcesses(1);
}

void leaveProcesses(int code) {
  const std::optional<EndAnyway> limit = wasInterrupted() ? std::optional<EndAnyway>(std::in_place, code) : std::nullopt;
  Joined& all = joined();
  all.leader.reset();
  all.volume.reset();
  all.ranks.reset();
}

void endProcesses(int code) {
  const EndAnyway limit(code);
  processRanks()->abort(code);
  std::_Exit(code);  // GCC does not see that a virtual function never returns
}

}  // namespace warpscope

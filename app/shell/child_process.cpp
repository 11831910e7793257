// posix_spawn, and a pipe for what the program complains about.
// See child_process.h.
#include "app/shell/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "render/base/error.h"
#include "render/base/printable.h"

extern char** environ;

namespace warpscope {
namespace {

constexpr size_t kKept = 2000;  // bytes of what is said
constexpr int kLookMs = 100;    // between looks at the stop token
constexpr std::chrono::seconds kPatience(3);  // for a program that was asked to end

}  // namespace

bool hasProgram(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (access((std::filesystem::path(folder) / name).c_str(), X_OK) == 0) return true;
  return false;
}

void runProgram(const std::vector<std::string>& arguments, const std::stop_token& stop) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw InputError(arguments.front() + ": " + std::strerror(errno));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, ends[1], 2);
  std::vector<char*> words;
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  pid_t child = 0;
  posix_spawnattr_t attributes;  // a group of its own, so that what it starts ends with it
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  const int failed = posix_spawnp(&child, words[0], &actions, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  if (failed != 0) {
    close(ends[0]);
    throw InputError(arguments.front() + ": " + std::strerror(failed));
  }
  std::string said;
  bool isStopped = false;
  std::chrono::steady_clock::time_point stoppedAt{};
  for (;;) {
    if (!isStopped && stop.stop_requested()) {
      isStopped = true;
      kill(-child, SIGTERM);
      stoppedAt = std::chrono::steady_clock::now();
    }
    if (isStopped && std::chrono::steady_clock::now() - stoppedAt > kPatience) kill(-child, SIGKILL);
    pollfd waiting{ends[0], POLLIN, 0};
    if (poll(&waiting, 1, kLookMs) <= 0) continue;
    char bytes[1024];
    const ssize_t count = read(ends[0], bytes, sizeof bytes);
    if (count <= 0) break;
    said.append(bytes, static_cast<size_t>(count));
    if (said.size() > 2 * kKept) said.erase(0, said.size() - kKept);
  }
  close(ends[0]);
  int status = 0;
  pid_t ended = waitpid(child, &status, 0);
  while (ended < 0 && errno == EINTR) ended = waitpid(child, &status, 0);
  if (isStopped) throw OperationCancelled();
  if (ended < 0) throw InputError(arguments.front() + ": " + std::strerror(errno));
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  throw InputError(arguments.front() + " failed: " + printable(said.substr(said.size() - std::min(said.size(), kKept))));
}

}  // namespace warpscope

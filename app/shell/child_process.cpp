// posix_spawn, and a pipe for what the program complains about.
// See child_process.h.
#include "app/shell/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
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
  const int failed = posix_spawnp(&child, words[0], &actions, nullptr, words.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  if (failed != 0) {
    close(ends[0]);
    throw InputError(arguments.front() + ": " + std::strerror(failed));
  }
  std::string said;
  bool isStopped = false;
  for (;;) {
    if (!isStopped && stop.stop_requested()) {
      isStopped = true;
      kill(child, SIGTERM);
    }
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
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (isStopped) throw OperationCancelled();
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  throw InputError(arguments.front() + " failed: " + printable(said.substr(said.size() - std::min(said.size(), kKept))));
}

}  // namespace warpscope

// posix_spawn, and pipes for what the program writes.
// See child_process.h.
#include "app/shell/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
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

constexpr size_t kKept = 8000;  // bytes of what is written
constexpr int kLookMs = 100;    // between looks at the stop token
constexpr std::chrono::seconds kPatience(3);  // for a program that was asked to end

/// From a child's end to its beginning here.
class Pipe {
 public:
  Pipe() {
    if (pipe2(ends_, O_CLOEXEC) != 0) ends_[0] = ends_[1] = -1;
  }
  ~Pipe() {
    closeBegin();
    closeEnd();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  bool isOpen() const { return ends_[0] >= 0; }
  int begin() const { return ends_[0]; }
  int end() const { return ends_[1]; }
  void closeBegin() { closeOne(ends_[0]); }
  void closeEnd() { closeOne(ends_[1]); }

 private:
  static void closeOne(int& end) {
    if (end >= 0) close(end);
    end = -1;
  }

  int ends_[2] = {-1, -1};
};

}  // namespace

bool hasProgram(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (access((std::filesystem::path(folder) / name).c_str(), X_OK) == 0) return true;
  return false;
}

ProgramEnd endOfProgram(const std::vector<std::string>& arguments, const std::stop_token& stop) {
  enum Stream { kOutput, kErrors, kStreams };
  Pipe pipes[kStreams];
  for (const Pipe& pipe : pipes)
    if (!pipe.isOpen()) throw InputError(arguments.front() + ": " + std::strerror(errno));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, pipes[kOutput].end(), 1);
  posix_spawn_file_actions_adddup2(&actions, pipes[kErrors].end(), 2);
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
  for (Pipe& pipe : pipes) pipe.closeEnd();
  if (failed != 0) throw InputError(arguments.front() + ": " + std::strerror(failed));
  std::string texts[kStreams];
  bool isStopped = false;
  std::chrono::steady_clock::time_point stoppedAt{};
  int status = 0;
  pid_t ended = 0;
  // What it has started may hold its streams for longer than it lives itself: nobody waits for that.
  for (size_t open = kStreams; open > 0;) {
    if (!isStopped && stop.stop_requested()) {
      isStopped = true;
      kill(-child, SIGTERM);
      stoppedAt = std::chrono::steady_clock::now();
    }
    if (isStopped && std::chrono::steady_clock::now() - stoppedAt > kPatience) {
      kill(-child, SIGKILL);
      break;
    }
    pollfd waiting[kStreams]{{pipes[kOutput].begin(), POLLIN, 0}, {pipes[kErrors].begin(), POLLIN, 0}};  // a negative one is left out
    if (poll(waiting, kStreams, kLookMs) <= 0) {
      if (ended != 0) break;  // nothing has come since
      ended = waitpid(child, &status, WNOHANG);
      continue;
    }
    for (int i = 0; i < kStreams; ++i) {
      if (waiting[i].revents == 0) continue;
      char bytes[1024];
      const ssize_t count = read(pipes[i].begin(), bytes, sizeof bytes);
      if (count <= 0) {
        pipes[i].closeBegin();
        --open;
        continue;
      }
      std::string& text = texts[i];
      text.append(bytes, static_cast<size_t>(count));
      if (text.size() > 2 * kKept) text.erase(0, text.size() - kKept);
    }
  }
  if (ended == 0) ended = waitpid(child, &status, 0);
  while (ended < 0 && errno == EINTR) ended = waitpid(child, &status, 0);
  if (isStopped) throw OperationCancelled();
  if (ended < 0) throw InputError(arguments.front() + ": " + std::strerror(errno));
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, texts[kOutput], texts[kErrors]};
}

void runProgram(const std::vector<std::string>& arguments, const std::stop_token& stop) {
  const ProgramEnd end = endOfProgram(arguments, stop);
  if (end.exitCode != 0) throw InputError(arguments.front() + " failed: " + printable(end.said.substr(end.said.size() - std::min(end.said.size(), kKept))));
}

}  // namespace warpscope

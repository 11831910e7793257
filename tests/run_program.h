// Runs the built program as a user would and catches what it says.
// POSIX posix_spawn; output goes to files, so that no pipe can fill up. The program's path comes from CMake as WARPSCOPE_PROGRAM.
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "tests/test_folder.h"

namespace warpscope {

struct ProgramResult {
  int code = -1;    ///< exit code; minus the signal's number if a signal ended the program
  std::string out;  ///< standard output
  std::string err;  ///< standard error
  double seconds = 0.0;
  long peakKiB = 0;  ///< largest resident set
};

using Arguments = std::vector<std::string>;

/// A running program. Everything is relative to the given folder, which is the program's working directory.
class Program {
 public:
  /// `environment` holds NAME=VALUE entries that come on top of this process's own; `program` is another one to run.
  explicit Program(const Arguments& arguments, const std::filesystem::path& folder, const Arguments& environment = {},
                   const char* program = WARPSCOPE_PROGRAM) {
    std::vector<char*> argv{const_cast<char*>(program)};
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    std::vector<char*> variables;
    for (const std::string& variable : environment) variables.push_back(const_cast<char*>(variable.c_str()));
    for (char** variable = environ; *variable != nullptr; ++variable) variables.push_back(*variable);
    variables.push_back(nullptr);

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, streams_.file("out").c_str(), O_WRONLY | O_CREAT, 0600);
    posix_spawn_file_actions_addopen(&actions, 2, streams_.file("err").c_str(), O_WRONLY | O_CREAT, 0600);
    posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
    // Whatever the tests themselves were told to ignore, as by nohup.
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t signals;
    sigemptyset(&signals);
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ}) sigaddset(&signals, number);
    posix_spawnattr_setsigdefault(&attributes, &signals);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
    const int error = posix_spawn(&process_, program, &actions, &attributes, argv.data(), variables.data());
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw std::system_error(error, std::generic_category(), std::string("starting ") + program);
  }
  ~Program() {
    if (process_ > 0) {
      kill(process_, SIGKILL);
      wait();
    }
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void signal(int number) const { kill(process_, number); }

  /// What it has written to standard error, or to standard output, until now.
  std::string errSoFar() const { return streams_.read("err"); }
  std::string outSoFar() const { return streams_.read("out"); }

  /// True once the program has ended; wait() then returns at once.
  bool hasEnded() const {
    siginfo_t info{};
    waitid(P_PID, static_cast<id_t>(process_), &info, WEXITED | WNOHANG | WNOWAIT);
    return info.si_pid == process_;
  }

  ProgramResult wait() {
    int status = 0;
    rusage usage{};
    while (wait4(process_, &status, 0, &usage) < 0 && errno == EINTR) {
    }
    process_ = -1;
    ProgramResult result;
    result.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    result.peakKiB = usage.ru_maxrss;
    result.out = streams_.read("out");
    result.err = streams_.read("err");
    return result;
  }

 private:
  TestFolder streams_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  pid_t process_ = -1;
};

inline ProgramResult runProgram(const Arguments& arguments, const std::filesystem::path& folder, const Arguments& environment = {}) {
  return Program(arguments, folder, environment).wait();
}

/// Runs a line of the shell, in which "$W" is the program.
inline ProgramResult runShell(const std::string& line, const std::filesystem::path& folder) {
  return Program({"-c", line}, folder, {std::string("W=") + WARPSCOPE_PROGRAM}, "/bin/sh").wait();
}

}  // namespace warpscope

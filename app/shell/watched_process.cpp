// Waiting for signals of a child, and for others'.
// See watched_process.h.
#include "app/shell/watched_process.h"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>

#include "app/shell/log.h"

namespace warpscope {
namespace {

constexpr int kPassedOn[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2, SIGTSTP, SIGCONT};
constexpr int kEndedBySignal = 1;

bool isWishToEnd(int number) { return number == SIGINT || number == SIGTERM || number == SIGHUP; }

/// `asked`: to end, by these signals; of one of these nothing is said, since who sent it knows.
int codeOf(int status, const sigset_t& asked, const std::string& self) {
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  if (sigismember(&asked, WTERMSIG(status)) == 0) printLine(self + "was ended by signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) + ")");
  return kEndedBySignal;
}

}  // namespace

std::optional<int> goOnInChild(const std::string& self) {
  // Signals wait from here on, so that none is lost between the two.
  std::signal(SIGCHLD, SIG_DFL);  // who ignores it, and whoever he starts, is never told
  sigset_t waited{}, before{};
  sigemptyset(&waited);
  sigaddset(&waited, SIGCHLD);
  for (const int number : kPassedOn) sigaddset(&waited, number);
  sigprocmask(SIG_BLOCK, &waited, &before);
  const pid_t watcher = getpid(), child = fork();
  if (child <= 0) {
    sigprocmask(SIG_SETMASK, &before, nullptr);
    if (child < 0) return {};
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != watcher) std::_Exit(kEndedBySignal);  // it was gone before that
    return {};
  }
  setpgid(child, child);  // whichever of the two comes first
  sigset_t asked{};
  sigemptyset(&asked);
  for (;;) {
    const int number = sigwaitinfo(&waited, nullptr);
    if (number > 0 && number != SIGCHLD) {
      if (isWishToEnd(number)) sigaddset(&asked, number);
      kill(child, number);
      if (number == SIGTSTP) std::raise(SIGSTOP);  // until it is told to go on
    }
    int status = 0;
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child) return codeOf(status, asked, self);
  }
}

}  // namespace warpscope

// Setting spdlog up.
// See log.h.
#include "app/shell/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <memory>

#include "render/base/printable.h"

namespace warpscope {
namespace {

/// A logger of its own: spdlog's default one writes to standard output.
spdlog::logger& logger() {
  static const std::shared_ptr<spdlog::logger> instance = [] {
    auto made = std::make_shared<spdlog::logger>("warpscope", std::make_shared<spdlog::sinks::stderr_sink_mt>());
    made->set_pattern("%v");
    made->set_level(spdlog::level::info);
    return made;
  }();
  return *instance;
}

bool isMuted = false;

void say(spdlog::level::level_enum level, const std::string& text) { logger().log(level, spdlog::string_view_t(printable(text))); }

}  // namespace

void setUpLog(bool isQuiet, bool isVerbose) {
  if (isMuted) return;
  logger().set_level(isQuiet ? spdlog::level::off : isVerbose ? spdlog::level::debug : spdlog::level::info);
}

void muteLog() {
  logger().set_level(spdlog::level::off);
  isMuted = true;
}

void logResult(const std::string& text) { say(spdlog::level::info, text); }

void logWarning(const std::string& text) { say(spdlog::level::warn, "warning: " + text); }

void logDetail(const std::string& text) {
  if (isDetailLogged()) say(spdlog::level::debug, text);
}

void printLine(const std::string& text) { printLines(printable(text) + "\n"); }

void printLines(const std::string& text) {
  std::fputs(printableLines(text).c_str(), stderr);
  std::fflush(stderr);
}

bool isDetailLogged() { return logger().should_log(spdlog::level::debug); }

}  // namespace warpscope

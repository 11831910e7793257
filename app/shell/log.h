// What the program says about its work. Standard error only: standard output belongs to results.
// Through spdlog, behind functions that keep its headers out of the rest. All of them make texts printable: see render/base/printable.h.
#pragma once

#include <string>

namespace warpscope {

/// Decides what is said from now on: nothing if `isQuiet`, else results and warnings, and details too if `isVerbose`. Before the first call: results and warnings.
void setUpLog(bool isQuiet, bool isVerbose);

/// Nothing is said any more but what printLine() and printLines() say, whatever setUpLog() is told.
void muteLog();

/// A result that whoever gave the command waits for. One line, whatever a file's name brings with it. Safe on any thread, as logDetail.
void logResult(const std::string& text);

/// What makes a result other than it may be expected to be.
void logWarning(const std::string& text);

/// What --verbose asks for: what is used, what is read, how long it takes.
void logDetail(const std::string& text);

/// What is said even if `isQuiet`: what made a command fail, and answers for people beside a file for machines. One line; several, each with its end.
void printLine(const std::string& text);
void printLines(const std::string& text);

/// Whether logDetail says anything: to be asked before a text that takes work.
bool isDetailLogged();

}  // namespace warpscope

// Another program, run to its end.
// POSIX; nothing is looked at by a shell.
#pragma once

#include <stop_token>
#include <string>
#include <vector>

namespace warpscope {

/// Whether a program of that name is on the path.
bool hasProgram(const std::string& name);

/// How a program ended.
struct ProgramEnd {
  int exitCode = 0;     ///< -1 where a signal ended it
  std::string written;  ///< to standard output, the end of it
  std::string said;     ///< to standard error, the end of it
};

/// Runs a program that is looked for on the path, without input; ends it if `stop` is set. Throws InputError where it cannot be started, OperationCancelled if `stop`
/// is set.
ProgramEnd endOfProgram(const std::vector<std::string>& arguments, const std::stop_token& stop = {});

/// Runs a program that is looked for on the path, without input and with what it says on standard error kept; ends it if `stop` is set. Throws InputError with the end of what it said
/// where it cannot be started or fails, OperationCancelled if `stop` is set.
void runProgram(const std::vector<std::string>& arguments, const std::stop_token& stop = {});

}  // namespace warpscope

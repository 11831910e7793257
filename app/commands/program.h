// The program: finds the command that the command line names, runs it, turns failures into one sentence and an exit code.
// Exit codes: 0 success, 1 failure, 2 usage.
#pragma once

namespace warpscope {

/// What main() does. Throws nothing. To be called once, before any thread is started.
int runProgram(int argc, char** argv);

}  // namespace warpscope

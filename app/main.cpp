// The program's entry.
// What it does is in commands/program.h, so that programs with further techniques can be made of it.
#include "app/commands/program.h"

int main(int argc, char** argv) { return warpscope::runProgram(argc, argv); }

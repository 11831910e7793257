// The program with one technique more. Nothing else of it is another.
// See extended_program_test.py for what that has to bring with it.
#include "app/commands/program.h"
#include "tests/extra_technique.h"

int main(int argc, char** argv) {
  const warpscope::WarpRegistration technique(warpscope::extraTechnique());
  return warpscope::runProgram(argc, argv);
}

// Linked into test programs of the preset `traps`: an operation on floating-point numbers that is invalid, overflows or divides by zero ends them.
// glibc's feenableexcept; threads begin with what the thread has that starts them, oneTBB's with what the first loop's has.
#include <cfenv>

namespace {

// Before main, and before any thread: of static data that starts threads there is none.
[[maybe_unused]] const int kEnabled = feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);

}  // namespace

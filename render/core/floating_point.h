// Where operations on floating-point numbers may be invalid, overflow or divide by zero, because what comes of it is asked for afterwards or
// thrown away: such a place holds an ExceptionsExpected. In a build that traps them (preset `traps`) they pass there; elsewhere it is nothing.
#pragma once

#if defined(WARPSCOPE_TRAPS)
#include <cfenv>
#endif

namespace warpscope {

/// For the calling thread and its scope. The reason stands beside it.
class ExceptionsExpected {
 public:
#if defined(WARPSCOPE_TRAPS)
  ExceptionsExpected() { std::feholdexcept(&environment_); }
  ~ExceptionsExpected() { std::fesetenv(&environment_); }

 private:
  std::fenv_t environment_;

 public:
#else
  ExceptionsExpected() {}  // not trivial: no warning of a variable that is not used
#endif
  ExceptionsExpected(const ExceptionsExpected&) = delete;
  ExceptionsExpected& operator=(const ExceptionsExpected&) = delete;
};

}  // namespace warpscope

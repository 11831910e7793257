// Where operations on floating-point numbers may be invalid, overflow or divide by zero, because what comes of it is asked for afterwards or
// thrown away. In a build that traps them (preset `traps`) they pass there; elsewhere this is nothing.
#pragma once

#if defined(WARPSCOPE_TRAPS)
#include <cfenv>
#endif

namespace warpscope {

#if defined(WARPSCOPE_TRAPS)
/// Nothing of it is moved out of the call: compilers take arithmetic to be independent of the processor's settings.
template <class Body>
[[gnu::noipa]] auto called(const Body& body) {
  return body();
}
#endif

/// What `body` returns. The reason stands beside it.
template <class Body>
inline auto exceptionsExpected(const Body& body) {
#if defined(WARPSCOPE_TRAPS)
  struct Held {
    Held() { std::feholdexcept(&environment); }
    ~Held() { std::fesetenv(&environment); }
    std::fenv_t environment;
  } held;
  return called(body);
#else
  return body();
#endif
}

}  // namespace warpscope

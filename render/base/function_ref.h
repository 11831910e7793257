// Something that can be called, borrowed: two pointers wide, nothing is copied or allocated. What std::function_ref (P0792) is in C++26.
// For functions that take one and are not templates: whoever calls them is compiled without what they are made of.
#pragma once

#include <functional>
#include <memory>
#include <type_traits>
#include <utility>

namespace warpscope {

template <class Signature>
class FunctionRef;

/// Of an object that can be called and outlives it; a temporary lives as long as the call that it is an argument of. Plain functions are not taken: no pointer to data may hold one.
template <class R, class... Args>
class FunctionRef<R(Args...)> {
 public:
  template <class F>
    requires(!std::is_same_v<std::remove_cvref_t<F>, FunctionRef> && !std::is_function_v<std::remove_reference_t<F>> && std::is_invocable_r_v<R, F&, Args...>)
  FunctionRef(F&& callable)  // NOLINT: as std::function, from whatever can be called
      : callable_(const_cast<void*>(static_cast<const void*>(std::addressof(callable)))),
        call_([](void* of, Args... args) -> R {
          auto& callee = *static_cast<std::remove_reference_t<F>*>(of);
          if constexpr (std::is_void_v<R>)
            static_cast<void>(std::invoke(callee, std::forward<Args>(args)...));
          else
            return std::invoke(callee, std::forward<Args>(args)...);
        }) {}

  R operator()(Args... args) const { return call_(callable_, std::forward<Args>(args)...); }

 private:
  void* callable_;
  R (*call_)(void*, Args...);
};

}  // namespace warpscope

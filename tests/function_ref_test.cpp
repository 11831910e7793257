// What is called, with what and on whose behalf. Mirrors render/base/function_ref.h.
#include "render/base/function_ref.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <type_traits>

namespace warpscope {
namespace {

int applied(FunctionRef<int(int)> function, int to) { return function(to); }
void called(FunctionRef<void()> function) { function(); }
void plain() {}

static_assert(!std::is_constructible_v<FunctionRef<int(int)>, std::string>);
static_assert(!std::is_constructible_v<FunctionRef<int(int)>, void (*)(int)>);
static_assert(!std::is_constructible_v<FunctionRef<void()>, decltype(plain)&>);
static_assert(std::is_trivially_copyable_v<FunctionRef<void()>>);

TEST(FunctionRef, CallsWhatItIsOf) {
  const auto twice = [](int i) { return 2 * i; };
  EXPECT_EQ(applied(twice, 21), 42);
  EXPECT_EQ(applied([](int i) { return i + 1; }, 1), 2);
  const FunctionRef<int(int)> first = twice, copy = first;
  EXPECT_EQ(applied(copy, 4), 8);
}

TEST(FunctionRef, ChangesTheObjectItselfAndNoCopy) {
  auto counting = [count = 0]() mutable { return ++count; };
  called(counting);
  called(counting);
  EXPECT_EQ(counting(), 3);
}

TEST(FunctionRef, PassesAllThatAFunctionMayTakeAndGive) {
  std::string name = "a";
  const auto same = [&name](std::unique_ptr<int> number) -> std::string& {
    name += std::to_string(*number);
    return name;
  };
  const FunctionRef<std::string&(std::unique_ptr<int>)> function = same;
  EXPECT_EQ(&function(std::make_unique<int>(7)), &name);
  EXPECT_EQ(name, "a7");
  const auto length = &std::string::size;
  EXPECT_EQ(FunctionRef<size_t(const std::string&)>(length)(name), 2u);
}

}  // namespace
}  // namespace warpscope

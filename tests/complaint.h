// What is said of something wrong.
#pragma once

#include <string>

#include "render/base/error.h"

namespace warpscope {

/// The sentence of the error that `action` ends in, or nothing.
template <class Error = InputError, class Action>
std::string complaintOf(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace warpscope

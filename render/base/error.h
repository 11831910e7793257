// The two kinds of failure that a user can cause, and the end that one asked for. Everything else that throws is a defect or an exhausted machine.
// The program's exit codes follow from the type: 1 for InputError, 2 for UsageError.
#pragma once

#include <stdexcept>
#include <string>

namespace warpscope {

/// A file, a volume, a device or an output that cannot be used. The text says what, where, and what would be right.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A GPU that is not there, or that failed: what it should have done can be done on the CPU.
class DeviceError : public InputError {
 public:
  using InputError::InputError;
};

/// A command line that asks for something that does not exist or makes no sense.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Thrown by long work whose stop token was set; whatever it was making is discarded.
class OperationCancelled : public std::runtime_error {
 public:
  OperationCancelled() : std::runtime_error("cancelled") {}
};

}  // namespace warpscope

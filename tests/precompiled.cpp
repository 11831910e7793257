// What the headers of precompiled.h are compiled for: CMake wants a target, and a target a file.
#include "tests/precompiled.h"

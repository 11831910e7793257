// Every case that exists on both backends, once on each.
// See backends.h.
#include "tests/stability/backends.h"

namespace warpscope {

#define WARPSCOPE_INSTANTIATE_CASE(Suite)                      \
  INSTANTIATE_TEST_SUITE_P(                                    \
      On, Suite, testing::Values(Backend::cpu, Backend::cuda), \
      [](const testing::TestParamInfo<Backend>& info) { return std::string(nameOf(info.param)); });
WARPSCOPE_FOR_EACH_CASE_ON_BACKENDS(WARPSCOPE_INSTANTIATE_CASE)

}  // namespace warpscope

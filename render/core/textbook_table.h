// A transfer function's table as textbooks print it: entries of equal width over the range, found by a multiplication and an addition.
// Engel et al. 2006, sections 4.1 and 9.1. To be compared with transfer_table.h: steps lie between entries, what is narrower than one vanishes.
#pragma once

#include "render/core/transfer_table.h"

namespace warpscope {

/// TransferTable::kBins entries over the domain, their opacities corrected in single precision for `step` volume units.
TransferTable bakeTextbookTable(const TransferFunction& function, const TransferDomain& domain, float step);

}  // namespace warpscope

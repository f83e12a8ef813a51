// Composes two pictures into a split view or a difference image.
#pragma once

#include "output/aov.h"
#include "view/input.h"

namespace latelight::view {

// Returns a picture of the size of the left one; the right one is scaled to that size. The difference mode amplifies
// differences of color and ignores alpha.
output::Picture splitPicture(const output::Picture& left, const output::Picture& right, const SetSplit& split);

}  // namespace latelight::view

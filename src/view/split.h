// Two pictures in one.
#pragma once

#include "output/aov.h"
#include "view/input.h"

namespace latelight::view {

// As large as the left one; the right one is scaled to it where it is another size. A difference is that of colours,
// amplified, without alpha.
output::Picture splitPicture(const output::Picture& left, const output::Picture& right, const SetSplit& split);

}  // namespace latelight::view

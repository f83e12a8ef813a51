// The windows of `latelight view`.
#pragma once

#include "view/session.h"

namespace latelight::app {

// Opens one, and returns when the last is closed. Throws Error(NoDevice) where there is no display.
void showWindows(const view::Start& start);

}  // namespace latelight::app

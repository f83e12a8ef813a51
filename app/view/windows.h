// The windows of `latelight view`.
#pragma once

#include "view/session.h"

namespace latelight::app {

// Opens a window, and returns when the last one is closed. Throws Error(NoDevice) if there is no display.
void showWindows(const view::Start& start);

}  // namespace latelight::app

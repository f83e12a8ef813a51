// What a viewing session starts with, from the options of `latelight render`.
#pragma once

#include "app/render_options.h"
#include "view/session.h"

namespace latelight::app {

// Those of `latelight render`; what a session has no use for is refused in a sentence, and not listed.
void addViewOptions(CLI::App& command, RenderOptions& options);
// Throws Error(Usage) for options that a session has no use for; `command` is its name in that sentence.
view::Start viewStart(RenderOptions& options, std::string_view command);

}  // namespace latelight::app

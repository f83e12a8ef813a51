// What a viewing session starts with, from the options of `latelight render`.
#pragma once

#include "app/render_options.h"
#include "view/session.h"

namespace latelight::app {

struct ViewOptions : RenderOptions {
  std::string shaders;  // a folder
};

// Those of `latelight render`, and its own; what a session has no use for is refused in a sentence, and not listed.
void addViewOptions(CLI::App& command, ViewOptions& options);
// Throws Error(Usage) for options that a session has no use for; `command` is its name in that sentence. From here on
// the process takes its shaders from --shaders.
view::Start viewStart(ViewOptions& options, std::string_view command);

}  // namespace latelight::app

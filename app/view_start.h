// The initial state of a viewing session, from the options of `latelight render`.
#pragma once

#include "app/render_options.h"
#include "view/session.h"

namespace latelight::app {

struct ViewOptions : RenderOptions {
  std::string shaders;  // a folder with SPIR-V
};

// Adds the options of `latelight render` and those of the viewer. Options that a session does not support are hidden.
void addViewOptions(CLI::App& command, ViewOptions& options);
// Throws Error(Usage) for options that a session does not support; `command` is its name in the message. Afterwards the
// process loads its shaders from --shaders.
view::Start viewStart(ViewOptions& options, std::string_view command);

}  // namespace latelight::app

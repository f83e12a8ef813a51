// A widget for every option of options.def, by its kind.
#pragma once

#include <functional>
#include <string>

#include "render/options/options.h"
#include "view/state.h"

namespace latelight::app {

// Draws all options by group. `set` is called with the name and text of a changed option; an empty text selects the
// default.
void drawOptions(const view::Choice& choice, const std::function<void(const std::string&, const std::string&)>& set);

// Draws an editable line of text. Returns true when it is entered.
bool editText(const char* label, std::string& text);
// Shows a tooltip if the pointer rests on the last widget.
void explain(const std::string& text);

}  // namespace latelight::app

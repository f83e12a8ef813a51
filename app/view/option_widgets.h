// A widget for every option of options.def, by its kind.
#pragma once

#include <functional>
#include <string>

#include "render/settings/options.h"
#include "view/state.h"

namespace latelight::app {

// All of them by groups. `set` is called with the name and the text of what people change; an empty text is the
// default.
void drawOptions(const view::Choice& choice, const std::function<void(const std::string&, const std::string&)>& set);

// A line of text to edit. True once it is entered.
bool editText(const char* label, std::string& text);
// What it says where the pointer rests on the last widget.
void explain(const std::string& text);

}  // namespace latelight::app

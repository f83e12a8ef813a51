// Names of keys, as KeyboardEvent.key has them.
#pragma once

#include <string>

namespace latelight::app {

// Of GLFW's numbers; by the keyboard's own layout where a key has a letter. Empty: one without use.
std::string keyName(int key, int scancode);
// Whether it acts again and again while it is held, as steps do, and not once, as what it turns on and off.
bool isStep(const std::string& name);

}  // namespace latelight::app

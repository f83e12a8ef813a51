// Names of keys, as defined by KeyboardEvent.key.
#pragma once

#include <string>

namespace latelight::app {

// Maps GLFW's codes to names; keys with a letter follow the keyboard layout. Empty if the key has no use.
std::string keyName(int key, int scancode);
// Returns true if the key repeats while it is held, as steps do, and false for keys that toggle.
bool isStep(const std::string& name);

}  // namespace latelight::app

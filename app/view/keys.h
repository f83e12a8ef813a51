// Names of keys, as KeyboardEvent.key has them.
#pragma once

#include <string>

namespace latelight::app {

// Of GLFW's numbers; by the keyboard's own layout where a key has a letter. Empty: one without use.
std::string keyName(int key, int scancode);

}  // namespace latelight::app

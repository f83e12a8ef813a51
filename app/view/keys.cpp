#include "app/view/keys.h"

#include <GLFW/glfw3.h>

#include <cstring>
#include <map>

namespace latelight::app {

std::string keyName(int key, int scancode) {
  static const std::map<int, std::string> kNamed{{GLFW_KEY_LEFT, "ArrowLeft"}, {GLFW_KEY_RIGHT, "ArrowRight"},
                                                 {GLFW_KEY_UP, "ArrowUp"},     {GLFW_KEY_DOWN, "ArrowDown"},
                                                 {GLFW_KEY_HOME, "Home"},      {GLFW_KEY_ESCAPE, "Escape"},
                                                 {GLFW_KEY_PAGE_UP, "PageUp"}, {GLFW_KEY_PAGE_DOWN, "PageDown"},
                                                 {GLFW_KEY_SPACE, " "},        {GLFW_KEY_F1, "F1"},
                                                 {GLFW_KEY_F2, "F2"},          {GLFW_KEY_TAB, "Tab"},
                                                 {GLFW_KEY_ENTER, "Enter"},    {GLFW_KEY_KP_ENTER, "Enter"},
                                                 {GLFW_KEY_KP_ADD, "+"},       {GLFW_KEY_KP_SUBTRACT, "-"},
                                                 {GLFW_KEY_KP_1, "1"},         {GLFW_KEY_KP_3, "3"},
                                                 {GLFW_KEY_KP_7, "7"}};
  if (const auto named = kNamed.find(key); named != kNamed.end()) return named->second;
  const char* letter = glfwGetKeyName(key, scancode);
  return letter ? letter : "";
}

bool isStep(const std::string& name) {
  return name.starts_with("Arrow") || name.starts_with("Page") || (name.size() == 1 && std::strchr("+=-[]", name[0]));
}

}  // namespace latelight::app

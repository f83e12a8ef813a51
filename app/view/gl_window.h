// A window with OpenGL and Dear ImGui in it. OpenGL only shows pictures: whatever device renders them, in whatever
// machine, they come through the host's memory.
#pragma once

#include <GLFW/glfw3.h>
#include <imgui/imgui.h>

#include <algorithm>
#include <cfloat>
#include <functional>
#include <string>
#include <vector>

#include "view/state.h"

namespace latelight::app {

class GlWindow {
 public:
  static constexpr int kAnswers = 3;  // drawings over which ImGui answers an input

  // What people do, where the panel has no use for it. Positions in pixels of the window.
  struct Events {
    std::function<bool(double x, double y)> pointer;  // whether the window looks different by it
    std::function<void()> pointerLeft;
    std::function<void(view::Button button, bool down, bool shift)> button;
    std::function<void(double steps)> wheel;
    std::function<void(const std::string& name, bool down, int modifiers)> key;
    std::function<void()> blur;
    std::function<void(const std::string& file)> drop;
  };

  // Throws Error(NoDevice) where the display has no OpenGL 3. It is hidden at first.
  GlWindow(const std::string& title, int width, int height, Events events);
  ~GlWindow();
  GlWindow(const GlWindow&) = delete;
  GlWindow& operator=(const GlWindow&) = delete;

  GLFWwindow* get() const { return window_; }
  float scale() const { return scale_; }    // pixels that a letter grows by, on displays of high density
  ImVec2 size() const;                      // pixels; zero while it is minimised
  int redraws() const { return redraws_; }  // how often it is to be drawn until it has settled
  void redraw(int times = kAnswers) { redraws_ = std::max(redraws_, times); }

  void begin();  // until end(), ImGui's functions draw into it
  void end();
  void setPicture(const view::Frame& frame);
  ImTextureID picture() const { return reinterpret_cast<ImTextureID>(static_cast<intptr_t>(texture_)); }

 private:
  static GlWindow& current(GLFWwindow* window);
  static GlWindow& of(GLFWwindow* window);  // which is to be drawn again
  void followEvents();
  void makeCurrent() const;

  GLFWwindow* window_ = nullptr;
  ImGuiContext* context_ = nullptr;
  Events events_;
  float scale_ = 1;
  unsigned texture_ = 0;
  ImVec2 pointer_{-FLT_MAX, -FLT_MAX};  // as events have it, of which the display may know more than were taken
  // ImGui sees keys once a frame: one that is pressed and released within it is released after it.
  struct Released {
    int key, scancode, modifiers;
  };
  std::vector<Released> released_;
  int redraws_ = 3;
};

}  // namespace latelight::app

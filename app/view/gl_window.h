// A window with OpenGL and Dear ImGui. OpenGL only displays images. They arrive through host memory from any device on
// any machine.
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
  static constexpr int kAnswers = 3;  // frames until ImGui has reacted to an input

  // User input that the panel does not consume. Positions are in pixels of the window.
  struct Events {
    std::function<bool(double x, double y)> pointer;  // returns true if the window must be redrawn
    std::function<void()> pointerLeft;
    std::function<void()> settle;  // before a key is pressed: draws until ImGui has reacted to the inputs before it
    std::function<void(view::Button button, bool down, bool shift)> button;
    std::function<void(double steps)> wheel;
    std::function<void(const std::string& name, bool down, int modifiers)> key;
    std::function<void()> blur;
    std::function<void(const std::string& file)> drop;
  };

  // Throws Error(NoDevice) if the display does not support OpenGL 3. The window is hidden at first.
  GlWindow(const std::string& title, int width, int height, Events events);
  ~GlWindow();
  GlWindow(const GlWindow&) = delete;
  GlWindow& operator=(const GlWindow&) = delete;

  GLFWwindow* get() const { return window_; }
  float scale() const { return scale_; }    // factor for text and handles on high-density displays
  ImVec2 size() const;                      // pixels; zero while minimized
  int redraws() const { return redraws_; }  // number of draws until ImGui has settled
  void redraw(int times = kAnswers) { redraws_ = std::max(redraws_, times); }

  void begin();  // ImGui's functions draw into this window until end()
  void end();
  void setPicture(const view::SessionFrame& frame);
  // The type is a pointer in ImGui before 1.91.4, and an integer since.
  ImTextureID picture() const { return ImTextureID(intptr_t(texture_)); }

 private:
  static GlWindow& current(GLFWwindow* window);
  static GlWindow& of(GLFWwindow* window);  // also requests a redraw
  void followEvents();
  void makeCurrent() const;

  GLFWwindow* window_ = nullptr;
  ImGuiContext* context_ = nullptr;
  Events events_;
  float scale_ = 1;
  unsigned texture_ = 0;
  ImVec2 pointer_{-FLT_MAX, -FLT_MAX};  // as in the events that were handled; the display may be ahead
  // ImGui reads keys once per frame, so a key that is pressed and released within a frame is released after it.
  struct Released {
    int key, scancode, modifiers;
  };
  std::vector<Released> released_;
  int redraws_ = 3;
};

}  // namespace latelight::app

#include "app/view/gl_window.h"

#include <imgui/backends/imgui_impl_glfw.h>
#include <imgui/backends/imgui_impl_opengl3.h>
#include <imgui/backends/imgui_impl_opengl3_loader.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "app/view/keys.h"
#include "base/error.h"

namespace latelight::app {

namespace {

// A font that is easier to read than ImGui's own, if it is installed.
const char* const kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr float kFontSize = 15;

std::optional<view::Button> buttonOf(int button) {
  if (button == GLFW_MOUSE_BUTTON_LEFT) return view::Button::Left;
  if (button == GLFW_MOUSE_BUTTON_MIDDLE) return view::Button::Middle;
  if (button == GLFW_MOUSE_BUTTON_RIGHT) return view::Button::Right;
  return std::nullopt;
}

void style(float scale) {
  ImGui::StyleColorsDark();
  ImGuiStyle& s = ImGui::GetStyle();
  s.WindowRounding = 0, s.FrameRounding = 3, s.GrabRounding = 3;
  s.ScaleAllSizes(scale);
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // do not save settings to a file
  io.ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
  if (std::filesystem::exists(kFont))
    io.Fonts->AddFontFromFileTTF(kFont, std::round(kFontSize * scale));
  else
    io.FontGlobalScale = scale;
}

}  // namespace

GlWindow::GlWindow(const std::string& title, int width, int height, Events events) : events_(std::move(events)) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 0);
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (!window_)
    fail(ExitCode::NoDevice,
         "the display does not support OpenGL 3: use `latelight render` to write images, or `latelight serve` to show "
         "them in a browser");
  glfwGetWindowContentScale(window_, &scale_, nullptr);
  context_ = ImGui::CreateContext();
  makeCurrent();
  glfwSwapInterval(1);
  style(scale_);
  ImGui_ImplGlfw_InitForOpenGL(window_, false);
  ImGui_ImplOpenGL3_Init("#version 130");
  glGenTextures(1, &texture_);
  glfwSetWindowUserPointer(window_, this);
  followEvents();
}

GlWindow::~GlWindow() {
  makeCurrent();
  glDeleteTextures(1, &texture_);
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext(context_);
  glfwDestroyWindow(window_);
}

GlWindow& GlWindow::current(GLFWwindow* window) {
  auto& found = *static_cast<GlWindow*>(glfwGetWindowUserPointer(window));
  found.makeCurrent();
  return found;
}

GlWindow& GlWindow::of(GLFWwindow* window) {
  GlWindow& found = current(window);
  found.redraw();
  return found;
}

void GlWindow::makeCurrent() const {
  glfwMakeContextCurrent(window_);
  ImGui::SetCurrentContext(context_);
}

// Forwards events to ImGui explicitly, because its own callbacks would reach the window that was drawn last. Pointer
// events are far more frequent than rendered images. Without a graphics device for windows, drawing for each event
// would use a core that rendering needs.
void GlWindow::followEvents() {
  glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double x, double y) {
    GlWindow& self = current(w);
    self.pointer_ = {static_cast<float>(x), static_cast<float>(y)};
    int width = 1, pixels = 1;
    glfwGetWindowSize(w, &width, nullptr);
    glfwGetFramebufferSize(w, &pixels, nullptr);
    const double scale = 1.0 * pixels / std::max(width, 1);
    if (self.events_.pointer(x * scale, y * scale)) self.redraw();
  });
  glfwSetCursorEnterCallback(window_, [](GLFWwindow* w, int entered) {
    GlWindow& self = of(w);
    ImGui_ImplGlfw_CursorEnterCallback(w, entered);
    if (!entered) self.events_.pointerLeft();
  });
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int modifiers) {
    GlWindow& self = of(w);
    ImGui_ImplGlfw_MouseButtonCallback(w, button, action, modifiers);
    if (const auto known = buttonOf(button))
      self.events_.button(*known, action == GLFW_PRESS, modifiers & GLFW_MOD_SHIFT);
  });
  glfwSetScrollCallback(window_, [](GLFWwindow* w, double x, double y) {
    GlWindow& self = of(w);
    ImGui_ImplGlfw_ScrollCallback(w, x, y);
    self.events_.wheel(y);
  });
  glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int scancode, int action, int modifiers) {
    if (action == GLFW_PRESS) current(w).events_.settle();
    GlWindow& self = of(w);
    if (action == GLFW_RELEASE)
      self.released_.push_back({key, scancode, modifiers});
    else
      ImGui_ImplGlfw_KeyCallback(w, key, scancode, action, modifiers);
    const std::string name = keyName(key, scancode);
    if (action != GLFW_REPEAT || isStep(name)) self.events_.key(name, action != GLFW_RELEASE, modifiers);
  });
  glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned letter) {
    of(w);
    ImGui_ImplGlfw_CharCallback(w, letter);
  });
  glfwSetWindowFocusCallback(window_, [](GLFWwindow* w, int focused) {
    GlWindow& self = of(w);
    ImGui_ImplGlfw_WindowFocusCallback(w, focused);
    if (!focused) self.events_.blur();
  });
  glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** files) {
    GlWindow& self = of(w);
    if (count > 0) self.events_.drop(files[0]);
  });
  for (const auto set : {glfwSetWindowSizeCallback, glfwSetFramebufferSizeCallback})
    set(window_, [](GLFWwindow* w, int, int) { of(w); });
  glfwSetWindowRefreshCallback(window_, [](GLFWwindow* w) { of(w); });
  glfwSetWindowCloseCallback(window_, [](GLFWwindow* w) { of(w); });
}

ImVec2 GlWindow::size() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  if (glfwGetWindowAttrib(window_, GLFW_ICONIFIED)) return {0, 0};
  return {static_cast<float>(width), static_cast<float>(height)};
}

void GlWindow::begin() {
  makeCurrent();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  if (ImGui::IsMousePosValid()) ImGui::GetIO().MousePos = pointer_;
  ImGui::NewFrame();
}

void GlWindow::end() {
  ImGui::Render();
  const ImVec2 pixels = size();
  glViewport(0, 0, static_cast<int>(pixels.x), static_cast<int>(pixels.y));
  glClearColor(0.11f, 0.11f, 0.12f, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  glfwSwapBuffers(window_);
  for (const Released& key : std::exchange(released_, {}))
    ImGui_ImplGlfw_KeyCallback(window_, key.key, key.scancode, GLFW_RELEASE, key.modifiers);
  if (redraws_ > 0) --redraws_;
}

// Both the bytes and the window are sRGB, so no conversion is needed.
void GlWindow::setPicture(const view::SessionFrame& frame) {
  makeCurrent();
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, static_cast<int>(frame.width), static_cast<int>(frame.height), 0, GL_RGBA,
               GL_UNSIGNED_BYTE, frame.rgba.data());
}

}  // namespace latelight::app

#include "app/view/window.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/view/gl_window.h"
#include "app/view/overlay.h"
#include "app/view/panel.h"
#include "app/view/sun_dial.h"
#include "base/log.h"
#include "base/lowercase.h"
#include "view/session_thread.h"

namespace latelight::app {

namespace {

constexpr float kPanelWidth = 380;

bool isEnvironment(const std::string& file) {
  const std::string extension = lowercaseExtension(file);
  return extension == ".hdr" || extension == ".exr";
}

std::string titleOf(const std::string& scene) {
  return "latelight: " + printable(scene);
}

// Returns true if a list is open or a value is being edited in the panel; Escape ends these first.
bool isBusyWithKeys() {
  return ImGui::IsAnyItemActive() ||
         ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
}

}  // namespace

struct Window::Impl {
  explicit Impl(const view::Start& start);

  GlWindow::Events events();
  float panelWidth() const { return memory.shown ? std::round(kPanelWidth * gl.scale()) : 0; }
  PictureArea area() const;
  void fit();
  void takeNews();
  void drawPicture() const;
  void draw();
  void settle();
  bool overPicture();
  bool movePointer(double x, double y);
  void press(view::Button button, bool down, bool shift);
  bool takesPress();
  void pressKey(const std::string& name, bool down, int modifiers);
  bool command(const std::string& name);
  bool windowKey(const std::string& name, bool shift);
  bool globalKey(const std::string& name);
  void copyCommand();
  std::string sun() const;

  GlWindow gl;
  view::SessionThread session;
  std::shared_ptr<const view::State> state;
  std::shared_ptr<const view::SessionFrame> frame;
  PanelMemory memory;
  Overlay overlay;
  SunDial sunDial;
  const Send send = [this](view::Input input) { session.send(std::move(input)); };
  const SunDial::Set setSun = [this](const std::string& text) { send(view::SetOption{"sun", text, memory.side}); };
  ImVec2 pointer{-1, -1}, drawn{-1, -1}, fitted{0, 0};  // `drawn`: the pointer at the last draw
  bool another = false, fresh = true;
};

// The window has the size of the image plus the panel.
Window::Impl::Impl(const view::Start& start)
    : gl(titleOf(start.scene), static_cast<int>(start.width + kPanelWidth), static_cast<int>(start.height), events()),
      session(start, [] { glfwPostEmptyEvent(); }) {
  const view::SessionThread::News news = session.take();
  state = news.state ? news.state : std::make_shared<view::State>();
  frame = std::make_shared<view::SessionFrame>();
  memory.scene = start.scene, memory.environment = start.environment;
  glfwShowWindow(gl.get());
}

GlWindow::Events Window::Impl::events() {
  return {.pointer = [this](double x, double y) { return movePointer(x, y); },
          .pointerLeft = [this] { session.send(view::PointerLeave{}); },
          .settle = [this] { settle(); },
          .button = [this](view::Button button, bool down, bool shift) { press(button, down, shift); },
          .wheel =
              [this](double steps) {
                if (overPicture()) session.send(view::Wheel{steps});
              },
          .key = [this](const std::string& name, bool down, int modifiers) { pressKey(name, down, modifiers); },
          .blur = [this] { session.send(view::Blur{}); },
          .drop =
              [this](const std::string& file) {
                if (!isEnvironment(file)) return session.send(view::OpenScene{memory.scene = file});
                session.send(view::UseEnvironment{memory.environment = file});
              }};
}

PictureArea Window::Impl::area() const {
  const ImVec2 size = gl.size();
  return {{0, 0}, {std::max(size.x - panelWidth(), 0.0f), size.y}, gl.scale()};
}

void Window::Impl::fit() {
  const ImVec2 size = area().size;
  if (size.x == fitted.x && size.y == fitted.y) return;
  fitted = size;
  session.send(view::Resize{static_cast<uint32_t>(size.x), static_cast<uint32_t>(size.y)});
}

void Window::Impl::takeNews() {
  const view::SessionThread::News news = session.take();
  if (news.state) {
    if (state && news.state->scene != state->scene) glfwSetWindowTitle(gl.get(), titleOf(news.state->scene).c_str());
    state = news.state;
    gl.redraw(news.frame && !news.frame->final ? 1 : GlWindow::kAnswers);  // another image follows a draft
  }
  if (!news.frame) return;
  frame = news.frame;
  gl.setPicture(*frame);
  if (frame->final) memory.times.add(*frame);
}

// An image with the window's aspect ratio fills its area, regardless of resolution; others are centered.
void Window::Impl::drawPicture() const {
  if (frame->width == 0) return;
  const PictureArea whole = area();
  const float fits =
      std::min(whole.size.x / static_cast<float>(frame->width), whole.size.y / static_cast<float>(frame->height));
  ImVec2 size{static_cast<float>(frame->width) * fits, static_cast<float>(frame->height) * fits};
  if (std::abs(size.x - whole.size.x) < 0.02f * whole.size.x && std::abs(size.y - whole.size.y) < 0.02f * whole.size.y)
    size = whole.size;
  const ImVec2 from{std::round((whole.size.x - size.x) / 2), std::round((whole.size.y - size.y) / 2)};
  ImGui::GetBackgroundDrawList()->AddImage(gl.picture(), from, {from.x + size.x, from.y + size.y});
}

void Window::Impl::draw() {
  drawn = pointer;
  gl.begin();
  drawPicture();
  overlay.draw(*state, area(), memory.handles);
  if (memory.handles) sunDial.draw(sun(), area());
  if (memory.shown) drawPanel(*state, *frame, memory, send, {area().size.x, 0}, {panelWidth(), gl.size().y});
  drawHelp(memory);
  if (std::exchange(fresh, false)) ImGui::SetWindowFocus(nullptr);  // keys control the image at first
  gl.end();
  if (std::exchange(memory.copies, false)) copyCommand();
}

// --- pointer and keys -----------------------------------------------------------------------------------------------

// Returns true if a press at the pointer is meant for the image. ImGui knows what is under the pointer only after a
// draw.
bool Window::Impl::overPicture() {
  if (pointer.x != drawn.x || pointer.y != drawn.y) draw();
  return pointer.x < area().size.x && !ImGui::GetIO().WantCaptureMouse;
}

// Returns true if the window must be redrawn. Over the image only a new image changes the window.
bool Window::Impl::movePointer(double x, double y) {
  const bool wasBeside = pointer.x >= area().size.x;
  pointer = {static_cast<float>(x), static_cast<float>(y)};
  if (!sunDial.move(sun(), area(), pointer, setSun) && !overlay.move(*state, area(), pointer, send))
    send(view::PointerMove{x, y});
  return wasBeside || pointer.x >= area().size.x || memory.handles || memory.help || ImGui::GetIO().WantCaptureMouse;
}

// ImGui receives button events by drawing, so this draws at once, before the pointer moves on.
void Window::Impl::press(view::Button button, bool down, bool shift) {
  draw();
  if (!down && (overlay.release() || sunDial.release())) return;
  if (down && !overPicture()) return;
  if (down) ImGui::SetWindowFocus(nullptr);
  if (down && button == view::Button::Left && takesPress()) return;
  session.send(view::PointerButton{button, down, shift});
}

bool Window::Impl::takesPress() {
  if (memory.handles && sunDial.press(sun(), area(), pointer, setSun)) return true;
  return overlay.press(*state, area(), pointer, memory.handles);
}

bool Window::Impl::command(const std::string& name) {
  if (name == "s") session.send(view::Screenshot{memory.file, memory.side});
  if (name == "c") copyCommand();
  if (name == "r") session.send(view::Reload{});
  if (name == "n") another = true;
  if (name == "w" || name == "q") glfwSetWindowShouldClose(gl.get(), GLFW_TRUE);
  return true;
}

// Handles the keys of the window itself, which also work while the panel has the focus.
bool Window::Impl::globalKey(const std::string& name) {
  if (name == "F1") return memory.help = !memory.help, true;
  if (name == "F2") return memory.shown = memory.focuses = true;
  return false;
}

// Handles keys while the image has the focus.
bool Window::Impl::windowKey(const std::string& name, bool shift) {
  if (memory.handles && overlay.key(*state, area(), name, shift, send)) return true;
  if (name == "h") return memory.shown = !memory.shown, true;
  if (name == "l") return memory.handles = !memory.handles, true;
  return false;
}

// Where several keys arrive at once, because the machine is busy, each must find what the one before it did: ImGui
// reads keys once per frame, and says only in the next frame that a text field takes them.
void Window::Impl::settle() {
  while (gl.redraws() > 0 && gl.size().x > 0) draw();
}

void Window::Impl::pressKey(const std::string& name, bool down, int modifiers) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput) return;
  if (modifiers & GLFW_MOD_CONTROL) {
    if (down) command(name);
    return;
  }
  if (down && globalKey(name)) return;
  if (io.WantCaptureKeyboard) {
    if (down && name == "Escape" && !isBusyWithKeys()) ImGui::SetWindowFocus(nullptr);
    return;
  }
  const bool shift = modifiers & GLFW_MOD_SHIFT;
  if (!(down && windowKey(name, shift))) session.send(view::Key{name, down, shift});
}

// Returns the option sun of the side whose options are shown.
std::string Window::Impl::sun() const {
  const auto& options = state->choices[static_cast<int>(memory.side)].options;
  const auto found = options.find("sun");
  return found == options.end() ? "" : found->second;
}

void Window::Impl::copyCommand() {
  glfwSetClipboardString(gl.get(), commandOf(*state, memory).c_str());
}

// --- public interface ------------------------------------------------------------------------------------------------

Window::Window(const view::Start& start) : impl_(std::make_unique<Impl>(start)) {}
Window::~Window() = default;

bool Window::wantsDrawing() const {
  return impl_->gl.redraws() > 0 && impl_->gl.size().x > 0;  // not while minimized
}

bool Window::show() {
  Impl& i = *impl_;
  i.takeNews();
  i.fit();
  if (wantsDrawing()) i.draw();
  return std::exchange(i.another, false);
}

bool Window::isClosed() const {
  return glfwWindowShouldClose(impl_->gl.get());
}

}  // namespace latelight::app

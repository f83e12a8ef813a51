// A window: a session's images, the panel next to them, and the meaning of pointer and keys there.
#pragma once

#include <memory>

#include "view/session.h"

namespace latelight::app {

class Window {
 public:
  // Throws Error if the display does not support OpenGL 3, or if the scene cannot be shown.
  explicit Window(const view::Start& start);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool wantsDrawing() const;
  // Draws the window if anything is new. Returns true if the user requested another window.
  bool show();
  bool isClosed() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace latelight::app

// A window: a session's pictures, the panel beside them, and what pointer and keys mean there.
#pragma once

#include <memory>

#include "view/session.h"

namespace latelight::app {

class Window {
 public:
  // Throws Error where the display has no OpenGL 3, or the scene can't be shown.
  explicit Window(const view::Start& start);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool wantsDrawing() const;
  // Draws it if anything is new. True: people want another window.
  bool show();
  bool isClosed() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace latelight::app

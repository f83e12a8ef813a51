// One page's session, on a thread of its own: takes its messages, makes its pictures, and sends them as fast as they
// are shown.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "serve/messages.h"
#include "view/session.h"

namespace latelight::serve {

class Viewer {
 public:
  // Called in the viewer's thread.
  struct Calls {
    std::function<void(std::string message)> send;
    std::function<void(std::string sentence)> fail;  // the session can't be, or can't go on
    std::function<void()> ended;                     // the last one: the thread may be joined
  };
  // `ready`: a session that was made before; null: it makes its own.
  Viewer(std::unique_ptr<view::ViewSession> ready, const view::Start& start, Calls calls);
  ~Viewer();  // waits for the picture that is being made

  void take(Order order);  // throws BadMessage where there are more than pictures are made for
  void stop();
  // What the validation layers said; once it has ended.
  const std::vector<std::string>& validationMessages() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace latelight::serve

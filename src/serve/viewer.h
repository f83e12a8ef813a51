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
    std::function<void(Message message)> send;
    std::function<void(std::string sentence)> fail;  // the session can't begin or continue
    std::function<void()> ended;                     // the last one: the thread may be joined
  };
  // `ready`: a session that was made before; null: it makes its own.
  Viewer(std::unique_ptr<view::ViewSession> ready, const view::Start& start, Calls calls);
  ~Viewer();  // waits for the picture that is being made

  void take(Order order);  // throws BadMessage if too many orders wait
  void dropFile();         // one that still waits
  void wrote();            // the oldest message that send() got has been written
  void stop();
  // The validation layers' messages, once the thread has ended.
  const std::vector<std::string>& validationMessages() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace latelight::serve

// The session of one page, on its own thread: handles the page's messages, renders its pictures, and sends them as fast
// as the page shows them.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "serve/messages.h"
#include "view/session.h"

namespace latelight::serve {

// Why a session cannot start or continue.
struct Failure {
  std::string sentence;
  bool mayPass = false;  // a new session may succeed later: a file could not be read, maybe because it is being written
};

class Viewer {
 public:
  // Called in the viewer's thread.
  struct Calls {
    std::function<void(Message message)> send;
    std::function<void(Failure failure)> fail;  // the session cannot start or continue
    std::function<void()> ended;                // the last call: the thread may be joined
  };
  // `ready`: an existing session; null: the viewer creates its own.
  Viewer(std::unique_ptr<view::ViewSession> ready, const view::Start& start, Calls calls);
  ~Viewer();  // waits for the picture in progress

  void take(Order order);  // throws BadMessage if too many orders wait
  void dropFile();         // drops a file that is still waiting
  void wrote();            // the oldest message passed to send() has been written
  void stop();
  // Returns the validation layers' messages, once the thread has ended.
  const std::vector<std::string>& validationMessages() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace latelight::serve

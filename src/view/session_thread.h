// A viewing session on its own thread, so that windows and connections never wait for a device.
#pragma once

#include <functional>
#include <memory>

#include "view/session.h"

namespace latelight::view {

class SessionThread {
 public:
  // The newest state and picture. Newer ones replace those that nobody has taken.
  struct News {
    std::shared_ptr<const State> state;         // null: unchanged
    std::shared_ptr<const SessionFrame> frame;  // null: unchanged
  };

  // Returns when the scene is loaded, and throws like ViewSession. The session's thread calls `wake` whenever take()
  // has news.
  SessionThread(const Start& start, std::function<void()> wake);
  ~SessionThread();  // waits for the picture in progress

  void send(Input input);
  News take();
  bool busy() const;  // a picture is in progress or pending

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace latelight::view

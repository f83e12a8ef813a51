// A viewing session on a thread of its own, so that windows and connections never wait for a device.
#pragma once

#include <functional>
#include <memory>

#include "view/session.h"

namespace latelight::view {

class SessionThread {
 public:
  // What there is to show after something happened. Pictures and states that nobody took are replaced by newer ones.
  struct News {
    std::shared_ptr<const State> state;  // null: as it was
    std::shared_ptr<const Frame> frame;  // null: as it was
  };

  // Returns when the scene is loaded; throws as ViewSession does. `wake` is called in the session's thread whenever
  // there are news.
  SessionThread(const Start& start, std::function<void()> wake);
  ~SessionThread();  // waits for the picture that is being made

  void send(Input input);
  News take();
  bool busy() const;  // a picture is being made, or will be

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace latelight::view

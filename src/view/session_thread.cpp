#include "view/session_thread.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "base/fatal_signals.h"

namespace latelight::view {

struct SessionThread::Impl {
  Impl(const Start& start, std::function<void()> wake) : session(start), wake(std::move(wake)) {}

  void run();
  bool waitForWork();
  void publish(const SessionFrame* made);

  ViewSession session;
  std::function<void()> wake;
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Input> work;
  News news;
  bool stops = false, busy = true;
  uint64_t shown = 0;
  std::string told;  // the error that was published
  std::thread thread;
};

// Handles all pending input, so that many pointer moves result in one picture. Returns false if the thread must stop.
bool SessionThread::Impl::waitForWork() {
  std::deque<Input> taken;
  {
    std::unique_lock lock(mutex);
    changed.wait_for(lock, std::chrono::duration<double>(session.secondsUntilStep()),
                     [&] { return stops || !work.empty(); });
    if (stops) return false;
    taken.swap(work);
  }
  for (const Input& input : taken) session.input(input);
  const auto isMove = [](const Input& input) { return std::holds_alternative<PointerMove>(input); };
  if (!std::ranges::all_of(taken, isMove)) publish(nullptr);  // changes by a move arrive with its picture
  return true;
}

void SessionThread::Impl::publish(const SessionFrame* made) {
  auto state = std::make_shared<const State>(session.state());
  told = state->error;
  const bool isNew = made && made->number != std::exchange(shown, made->number);
  auto frame = isNew ? std::make_shared<const SessionFrame>(*made) : nullptr;
  {
    std::lock_guard lock(mutex);
    news.state = std::move(state);
    if (frame) news.frame = std::move(frame);
  }
  wake();
}

void SessionThread::Impl::run() {
  publish(nullptr);
  while (waitForWork()) {
    const bool wants = session.wantsFrame();
    {
      std::lock_guard lock(mutex);
      busy = wants || !work.empty();
    }
    if (wants)
      publish(&session.next());
    else if (session.state().error != told)  // a changed file that cannot be read
      publish(nullptr);
  }
}

SessionThread::SessionThread(const Start& start, std::function<void()> wake)
    : impl_(std::make_unique<Impl>(start, std::move(wake))) {
  impl_->thread = std::thread([impl = impl_.get()] {
    const SignalStack stack;
    impl->run();
  });
}

SessionThread::~SessionThread() {
  {
    std::lock_guard lock(impl_->mutex);
    impl_->stops = true;
  }
  impl_->changed.notify_all();
  impl_->thread.join();
}

void SessionThread::send(Input input) {
  std::lock_guard lock(impl_->mutex);
  impl_->busy = true;
  impl_->work.push_back(std::move(input));
  impl_->changed.notify_all();
}

SessionThread::News SessionThread::take() {
  std::lock_guard lock(impl_->mutex);
  return std::exchange(impl_->news, {});
}

bool SessionThread::busy() const {
  std::lock_guard lock(impl_->mutex);
  return impl_->busy;
}

}  // namespace latelight::view

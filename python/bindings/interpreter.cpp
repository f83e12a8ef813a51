#include "interpreter.h"

#include <latelight/latelight.h>
#include <pthread.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <new>

namespace latelight::python {

namespace nb = nanobind;

namespace {

// Never destroyed, because threads use it until the process ends.
struct Ending {
  std::mutex mutex;  // guards the rest
  std::condition_variable idle;
  size_t atWork = 0;  // AtWork objects of all threads
  bool begun = false;
  pthread_t by{};  // the thread that ends the interpreter, which itself continues
};
Ending& ending() {
  static Ending* const only = new Ending;
  return *only;
}

thread_local size_t ownWork = 0;  // AtWork objects of this thread

bool isOverFor(const Ending& e) {
  return e.begun && !pthread_equal(e.by, pthread_self());
}

// Blocks this thread forever, so that its work does not delay the end of the interpreter.
[[noreturn]] void sleepForever(std::unique_lock<std::mutex>&& lock, Ending& e) {
  e.atWork -= ownWork;
  e.idle.notify_all();
  lock.unlock();
  for (;;) pause();
}

void (*finishDevices)() = nullptr;

// Checks signals while waiting, so that Ctrl-C ends a program whose thread loads a scene for an hour.
void waitUntilIdle(Ending& e) {
  for (;;) {
    {
      const nb::gil_scoped_release others;
      std::unique_lock lock(e.mutex);
      constexpr auto kInterval = std::chrono::milliseconds(50);
      if (e.idle.wait_for(lock, kInterval, [&] { return e.atWork == ownWork; })) return;
    }
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
  }
}

void endInterpreter() {
  Ending& e = ending();
  {
    const std::lock_guard lock(e.mutex);
    e.begun = true;
    e.by = pthread_self();
  }
  // The frames of threads that sleep from this point on keep objects alive.
  if (nb::cast<int>(nb::module_::import_("threading").attr("active_count")()) > 1) nb::set_leak_warnings(false);
  waitUntilIdle(e);
  finishDevices();
}

// Threads that were at work do not exist in the forked process.
void forgetOtherThreads() {
  Ending& e = *new (&ending()) Ending;
  e.atWork = ownWork;
}

}  // namespace

AtWork::AtWork() {
  Ending& e = ending();
  std::unique_lock lock(e.mutex);
  if (isOverFor(e)) {
    lock.unlock();
    PyEval_SaveThread();
    lock.lock();
    sleepForever(std::move(lock), e);
  }
  ++e.atWork;
  ++ownWork;
}

AtWork::~AtWork() {
  Ending& e = ending();
  const std::lock_guard lock(e.mutex);
  --ownWork;
  --e.atWork;
  if (e.begun) e.idle.notify_all();
}

WithoutGil::WithoutGil() : thread_(PyEval_SaveThread()) {}

// This thread counts as at work until it holds the GIL. Either the interpreter's end waits for it, or it has begun
// already, and the thread sleeps.
WithoutGil::~WithoutGil() {
  {
    Ending& e = ending();
    std::unique_lock lock(e.mutex);
    if (isOverFor(e)) sleepForever(std::move(lock), e);
  }
  PyEval_RestoreThread(thread_);
}

void raiseSignals() {
  {
    Ending& e = ending();
    const std::lock_guard lock(e.mutex);
    if (isOverFor(e)) throw Error(ExitCode::Internal, "Python ends");  // the stack unwinds up to ~WithoutGil()
  }
  const nb::gil_scoped_acquire gil;
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

void bindInterpreter(nb::module_& module, void (*finish)()) {
  finishDevices = finish;
  static const int registered = pthread_atfork(nullptr, nullptr, forgetOtherThreads);
  static_cast<void>(registered);
  module.def("_end", &endInterpreter);
  nb::module_::import_("atexit").attr("register")(module.attr("_end"));
}

}  // namespace latelight::python

// Python's global lock (GIL), and how the interpreter ends while threads are at work.
//
// CPython up to 3.13 ends a thread that asks for the GIL once the interpreter is finalizing by unwinding its stack,
// which std::terminate() stops at the first noexcept function. So a function that runs at exit, before that, waits
// until no thread has C++ functions on its stack that still need the GIL, and until the devices have finished. Threads
// that come later sleep until the process ends, as they do from CPython 3.14 on.
#pragma once

#include <nanobind/nanobind.h>

namespace latelight::python {

// Counts this thread as one that the end of the interpreter waits for; once that has begun, the thread stays here.
class AtWork {
 public:
  AtWork();
  ~AtWork();
  AtWork(const AtWork&) = delete;
  AtWork& operator=(const AtWork&) = delete;
};

// Whatever may run Python code, such as an argument's __array__, does so while one of these lives: Python code can
// release the GIL at any time. The GIL is held.
using RunningPython = AtWork;

// Releases the GIL for work without Python objects.
class WithoutGil {
 public:
  WithoutGil();
  ~WithoutGil();
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;

 private:
  AtWork atWork_;
  PyThreadState* thread_;
};

// For waits without the GIL: throws what a signal's handler raises, KeyboardInterrupt among others, and ends the wait
// of a thread once the interpreter ends.
void raiseSignals();

// `finishDevices` is called at exit, with the GIL, when no thread is at work.
void bindInterpreter(nanobind::module_& module, void (*finishDevices)());

}  // namespace latelight::python

// Python's global interpreter lock (GIL), and how the interpreter ends while threads are at work.
//
// CPython up to 3.13 ends a thread that requests the GIL while the interpreter is finalizing by unwinding its stack,
// which calls std::terminate() at the first noexcept function. Therefore a function that runs at exit, before
// finalization, waits until no thread has C++ functions on its stack that still need the GIL, and until the devices
// have finished. Threads that request the GIL later sleep until the process ends, as they do from CPython 3.14 on.
#pragma once

#include <nanobind/nanobind.h>

namespace latelight::python {

// Makes the end of the interpreter wait for this thread. If another thread has begun the end, the constructor blocks
// forever.
class AtWork {
 public:
  AtWork();
  ~AtWork();
  AtWork(const AtWork&) = delete;
  AtWork& operator=(const AtWork&) = delete;
};

// Must exist while Python code may run, such as an argument's __array__, because Python code can release the GIL at any
// time. The caller holds the GIL.
using RunningPython = AtWork;

// Releases the GIL for work that uses no Python objects.
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

// For waits without the GIL. Throws the exception of a signal handler, such as KeyboardInterrupt, and ends the wait of
// a thread once the interpreter ends.
void raiseSignals();

// `finishDevices` is called at exit with the GIL held, after all threads have finished their work.
void bindInterpreter(nanobind::module_& module, void (*finishDevices)());

}  // namespace latelight::python

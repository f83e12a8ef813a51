#include "base/fatal_signals.h"

#include <execinfo.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstring>
#include <new>
#include <optional>
#include <utility>

#include "base/program_symbols.h"
#include "base/temporary_file.h"

namespace latelight {
namespace {

constexpr size_t kSignalStackBytes = 64 << 10;  // the registers of processors with wide vectors use 11 KiB of it

std::atomic<bool> handled = false;

// Returns the name of a signal that reports a crash, and null for another. (sigabbrev_np() requires glibc 2.32.)
const char* crashName(int signal) {
  constexpr std::pair<int, const char*> kCrashes[] = {{SIGSEGV, "SIGSEGV"}, {SIGBUS, "SIGBUS"},   {SIGILL, "SIGILL"},
                                                      {SIGFPE, "SIGFPE"},   {SIGABRT, "SIGABRT"}, {SIGTRAP, "SIGTRAP"},
                                                      {SIGSYS, "SIGSYS"}};
  for (const auto& [crash, name] : kCrashes) {
    if (crash == signal) return name;
  }
  return nullptr;
}

// All functions here are safe in a signal handler: backtrace() allocates only on its first call, in
// handleFatalSignals().
void print(const char* text) {
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text, std::strlen(text));
}

void printBacktrace(const char* signal) {
  print("latelight: crashed by ");
  print(signal);
  print("; this is a bug in the program or in a driver: please report it with these lines\n");
  std::array<void*, 64> frames{};
  const int count = backtrace(frames.data(), static_cast<int>(frames.size()));
  const ProgramSymbols symbols;
  for (int i = 0; i < count; ++i) {
    void** const frame = frames.data() + i;
    if (const char* function = symbols.find(*frame)) {
      print(function);
      print(" in ");
    }
    backtrace_symbols_fd(frame, 1, STDERR_FILENO);
  }
}

std::atomic_flag ending;

void endBy(int signal) {
  // Threads that do the same work may crash at the same time. They wait for the first one, because ending the process
  // would cut off its report.
  while (ending.test_and_set()) pause();
  removeTemporaryFiles();  // first: a crash may have left too little intact for the rest
  if (const char* crash = crashName(signal)) printBacktrace(crash);
  std::signal(signal, SIG_DFL);
  raise(signal);  // ends the process once this returns
}

}  // namespace

void handleFatalSignals() {
  void* frame = nullptr;
  backtrace(&frame, 1);  // loads its library before any crash
  handled = true;
  static std::optional<SignalStack> mainStack;
  mainStack.emplace();
  struct sigaction action {};
  action.sa_handler = endBy;
  action.sa_flags = SA_ONSTACK;
  sigfillset(&action.sa_mask);
  for (int signal = 1; signal <= SIGRTMAX; ++signal) {
    constexpr int kHarmless[] = {SIGKILL, SIGSTOP, SIGTSTP, SIGTTIN, SIGTTOU, SIGCHLD, SIGCONT, SIGURG, SIGWINCH};
    if (std::find(std::begin(kHarmless), std::end(kHarmless), signal) != std::end(kHarmless)) continue;
    struct sigaction before {};
    const bool ends = sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_DFL;
    if (ends) sigaction(signal, &action, nullptr);
  }
}

SignalStack::SignalStack() {
  stack_t now{};
  if (!handled || sigaltstack(nullptr, &now) != 0 || !(now.ss_flags & SS_DISABLE)) return;
  memory_.reset(new (std::nothrow) std::byte[kSignalStackBytes]);
  if (!memory_) return;  // handlers then run on the thread's own stack; an exception would end the process
  const stack_t own{.ss_sp = memory_.get(), .ss_flags = 0, .ss_size = kSignalStackBytes};
  if (sigaltstack(&own, nullptr) != 0) memory_.reset();
}

SignalStack::~SignalStack() {
  if (!memory_) return;
  const stack_t none{.ss_sp = nullptr, .ss_flags = SS_DISABLE, .ss_size = 0};
  sigaltstack(&none, nullptr);
}

}  // namespace latelight

#include "data/stop.h"

#include <atomic>
#include <csignal>

namespace latelight::data {

namespace {

std::atomic<int> askedBy = 0;
struct sigaction beforeTerm {
}, beforeInt{};

void askToStop(int signal) {
  if (askedBy.exchange(signal) == 0) return;
  sigaction(signal, signal == SIGTERM ? &beforeTerm : &beforeInt, nullptr);
  raise(signal);
}

}  // namespace

void stopOnSignals() {
  struct sigaction action {};
  action.sa_handler = askToStop;
  action.sa_flags = SA_RESTART;
  sigaction(SIGTERM, &action, &beforeTerm);
  sigaction(SIGINT, &action, &beforeInt);
}

int stopSignal() {
  return askedBy;
}

void throwIfStopped() {
  if (const int signal = askedBy) throw Stopped{signal};
}

}  // namespace latelight::data

#include "data/stop.h"

#include <atomic>
#include <csignal>

namespace latelight::data {

namespace {

std::atomic<int> receivedSignal = 0;
struct sigaction beforeTerm {
}, beforeInt{};

void requestStop(int signal) {
  if (receivedSignal.exchange(signal) == 0) return;
  sigaction(signal, signal == SIGTERM ? &beforeTerm : &beforeInt, nullptr);
  raise(signal);
}

}  // namespace

void stopOnSignals() {
  struct sigaction action {};
  action.sa_handler = requestStop;
  action.sa_flags = SA_RESTART;
  sigaction(SIGTERM, &action, &beforeTerm);
  sigaction(SIGINT, &action, &beforeInt);
}

int stopSignal() {
  return receivedSignal;
}

void throwIfStopped() {
  if (const int signal = receivedSignal) throw Stopped{signal};
}

}  // namespace latelight::data

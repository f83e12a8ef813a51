#include "base/threads.h"

#include <exception>

#include "base/fatal_signals.h"

namespace latelight {

std::vector<std::thread> startThreads(size_t count, const std::function<void(size_t i)>& body) {
  std::vector<std::thread> threads;
  try {
    threads.reserve(count);
    for (size_t i = 0; i < count; ++i)
      threads.emplace_back([body, i] {
        const SignalStack stack;
        body(i);
      });
  } catch (const std::exception&) {
    if (threads.empty()) throw;
  }
  return threads;
}

}  // namespace latelight

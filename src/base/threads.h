// Starts threads, as many as memory and the limits of the process permit.
#pragma once

#include <cstddef>
#include <functional>
#include <thread>
#include <vector>

namespace latelight {

// Starts threads that call body(i) for i from 0 on: `count` threads, or as many as can be started. Throws
// std::bad_alloc or std::system_error if none can be started. `body` must not throw.
std::vector<std::thread> startThreads(size_t count, const std::function<void(size_t i)>& body);

}  // namespace latelight

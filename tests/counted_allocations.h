// Counts a thread's allocations and makes one of them fail. Programs that use it replace operator new
// (counted_allocations.cpp).
#pragma once

#include <functional>

namespace latelight::test {

// Returns the number of allocations of a call by this thread. `failing`: the number of the one that throws
// std::bad_alloc, from 1 on; 0: none.
int allocationsOf(const std::function<void()>& call, int failing = 0);

}  // namespace latelight::test

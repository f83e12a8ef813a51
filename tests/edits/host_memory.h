// What a renderer keeps in the host's heap, for tests that look for leaks.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

namespace latelight::render::test {

// Returns the least number of bytes in the heap after each of eight frames: now and then a frame leaves the driver a
// command buffer more until the next.
size_t leastHostBytes(const std::function<void()>& frame);

// Returns the median difference between one number of bytes and the next. A leak adds to each; something that the
// driver or a thread of the process makes once adds to one alone.
double medianGrowth(std::span<const size_t> bytes);

}  // namespace latelight::render::test

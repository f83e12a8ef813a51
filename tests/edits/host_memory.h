// The host's heap that a renderer uses, for tests that search for leaks.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

namespace latelight::render::test {

// Returns the minimum number of allocated bytes after each of eight frames, because the driver occasionally keeps one
// more command buffer until the next frame.
size_t leastHostBytes(const std::function<void()>& frame);

// Returns the median difference between successive numbers of bytes. A leak adds to every difference, a one-time
// allocation of the driver or of a thread only to one.
double medianGrowth(std::span<const size_t> bytes);

}  // namespace latelight::render::test

// The host's heap that a renderer uses, for tests that search for leaks.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

namespace latelight::render::test {

// Returns the minimum number of allocated bytes after each of eight frames, because the driver occasionally keeps one
// more command buffer until the next frame.
size_t leastHostBytes(const std::function<void()>& frame);

// Returns the lower quartile of the differences between successive numbers of bytes. A leak adds to every difference,
// an allocation that a driver keeps only to one. On a busy machine, most differences have such an allocation: more
// frames are then in flight at once, and lavapipe's heap grows in steps of 64 KiB.
double steadyGrowth(std::span<const size_t> bytes);

}  // namespace latelight::render::test

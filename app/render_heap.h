// The heaps of commands that render and end.
#pragma once

namespace latelight::app {

// Lets the heap reuse freed memory, in huge pages, instead of returning it to the kernel. Textures are decoded, copied
// and freed one after the other, and a CPU driver's images come from the same heap; otherwise the kernel clears and
// maps each of their pages of 4 KiB again, which is a quarter of the time of an image with large textures. Call it
// before other threads start. Unused memory costs nothing. Does nothing if the process's address space is limited, or
// with another C library than glibc.
void reuseFreedMemory();

// Lets the heaps of all threads keep freed memory, for a command whose threads free images of the same sizes again and
// again. The same conditions apply.
void keepFreedMemory();

}  // namespace latelight::app

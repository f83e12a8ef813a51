// Reserves disk space for the cache in which Mesa's drivers store compiled shaders.
#pragma once

namespace latelight::vk {

// Mesa finds cached shaders by an index file that it maps into memory and that is sparse at first. If the disk is full,
// a write into a hole kills the process with SIGBUS inside the driver, and no handler can recover from that. This
// function therefore allocates the holes in advance; it returns false if the disk has no space for them.
bool reserveDriverCache();

// If there is no space, disables the cache through the environment (MESA_SHADER_CACHE_DISABLE=true) and warns once. A
// program must call this before it starts threads and before the driver is loaded.
void avoidFullDriverCache();

}  // namespace latelight::vk

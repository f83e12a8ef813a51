// Disk space for the cache in which Mesa's drivers keep compiled shaders.
#pragma once

namespace latelight::vk {

// Mesa finds cached shaders by an index that it maps into memory and that is a sparse file at first. Where the disk is
// full, writing into a hole kills the process with SIGBUS, within the driver, and no handler can recover from that. So
// the holes are filled beforehand; false where there is no space for that.
bool reserveDriverCache();

// Where there is no space, turns the cache off through the environment (MESA_SHADER_CACHE_DISABLE=true), and warns
// once. To be called by a program before it starts threads and before the driver is loaded.
void avoidFullDriverCache();

}  // namespace latelight::vk

// Room for the cache in which Mesa's drivers keep compiled shaders.
#pragma once

namespace latelight::vk {

// Mesa finds cached shaders by an index that it maps into memory and that has holes at first. Where the disk is full,
// writing into a hole ends the process by SIGBUS, within the driver, and no handler can repair that. So the holes are
// filled beforehand; false where there is no room for that.
bool reserveDriverCache();

// Where there is no room, turns the cache off by the environment (MESA_SHADER_CACHE_DISABLE=true), and says so once. To
// be called by a program before it starts threads and before the driver is loaded.
void avoidFullDriverCache();

}  // namespace latelight::vk

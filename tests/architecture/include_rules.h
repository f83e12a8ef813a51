// Which folders may include which: base <- vk <- graph <- render <- study <- app; shared <- scene <- render; output
// next to render.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace latelight {

// What is wrong with the includes of one source text. `folder`: "base", "vk", ..., "app", or "include" for the public
// headers. `isGenerated` knows the files that the build writes, which belong to no folder.
std::vector<std::string> wrongIncludes(std::string_view folder, std::string_view text,
                                       const std::function<bool(const std::string&)>& isGenerated);

// Inside render/ files stand in layers, and include none from above: what any part uses; the scene on the device; what
// a frame is, and its techniques; requests; the renderer. `path` is from src/. What comes from above it.
std::vector<std::string> includesFromAbove(std::string_view path, std::string_view text);

// The includes by which a file comes to a Vulkan header, that header last; empty where none does. `textOf` gives the
// text of what is included by a path from src/, empty for others'.
std::vector<std::string> wayToVulkan(const std::string& text,
                                     const std::function<std::string(const std::string&)>& textOf);

}  // namespace latelight

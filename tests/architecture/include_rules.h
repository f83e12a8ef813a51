// What the includes of a file have to keep to, besides the walls between modules, which the build enforces
// (cmake/modules.cmake).
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace latelight {

// Returns what is wrong with the includes of one source text: Vulkan headers in a folder that does not use them, and
// names that are not clear: those that are no path from src/. `folder`: "base", "vk", ..., "app", or "include" for the
// public headers. `isGenerated` knows the files that the build writes, which belong to no folder.
std::vector<std::string> wrongIncludes(std::string_view folder, std::string_view text,
                                       const std::function<bool(const std::string&)>& isGenerated);

// The includes by which a file comes to a Vulkan header, that header last; empty where none does. `textOf` gives the
// text of what is included by a path from src/, empty for others'.
std::vector<std::string> wayToVulkan(const std::string& text,
                                     const std::function<std::string(const std::string&)>& textOf);

}  // namespace latelight

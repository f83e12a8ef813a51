// Who may include whom: base <- vk <- graph <- render <- study <- app; shared <- scene <- render; output beside render.
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

}  // namespace latelight

// The files of the page, web/serve, which are embedded in the program.
#pragma once

#include <span>
#include <string_view>

namespace latelight::serve {

struct PageFile {
  std::string_view path, type, text;  // "style.css", "text/css", ...
};
std::span<const PageFile> pageFiles();
// Finds a file by the path after the token, "" for the page itself. Returns null if there is none.
const PageFile* findPageFile(std::string_view path);

}  // namespace latelight::serve

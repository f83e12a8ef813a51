// The files of the page, web/serve, which are part of the program.
#pragma once

#include <span>
#include <string_view>

namespace latelight::serve {

struct PageFile {
  std::string_view path, type, text;  // "style.css", "text/css", ...
};
std::span<const PageFile> pageFiles();
// By what follows the token, "" for the page itself; null: there is none.
const PageFile* findPageFile(std::string_view path);

}  // namespace latelight::serve

#include "serve/page.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace latelight::serve {

namespace {

struct Embedded {
  std::string_view path, text;
};
constexpr Embedded kEmbedded[] = {
#include "serve_files.inc"
};

std::string_view typeOf(std::string_view path) {
  constexpr std::pair<std::string_view, std::string_view> kTypes[] = {{".html", "text/html; charset=utf-8"},
                                                                      {".css", "text/css; charset=utf-8"},
                                                                      {".js", "text/javascript; charset=utf-8"},
                                                                      {".svg", "image/svg+xml"}};
  for (const auto& [ending, type] : kTypes)
    if (path.ends_with(ending)) return type;
  return "application/octet-stream";
}

}  // namespace

std::span<const PageFile> pageFiles() {
  static const std::vector<PageFile> files = [] {
    std::vector<PageFile> made;
    for (const Embedded& file : kEmbedded) made.push_back({file.path, typeOf(file.path), file.text});
    return made;
  }();
  return files;
}

const PageFile* findPageFile(std::string_view path) {
  const auto found = std::ranges::find(pageFiles(), path.empty() ? "index.html" : path, &PageFile::path);
  return found != pageFiles().end() ? &*found : nullptr;
}

}  // namespace latelight::serve

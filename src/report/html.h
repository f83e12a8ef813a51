// Pages in a single file: style, script, images and values are embedded, and nothing is loaded from elsewhere.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

#include "output/aov.h"
#include "study/svg.h"

namespace latelight::report {

using study::escaped;

std::string_view webFile(std::string_view name);  // a file of web/report
std::string base64(std::span<const std::byte> bytes);

// Returns an image with a text alternative and a caption in HTML. `id` is that of the <img>.
std::string figure(const std::string& id, const output::Picture& picture, std::string_view words,
                   const std::string& caption);

struct Section {
  const char* id;  // target of the heading's link
  std::string title, html;
};

struct Page {
  std::string title;
  std::string introduction;  // HTML below the title
  std::vector<Section> sections;
  nlohmann::ordered_json data;  // for web/report/report.js
  std::string values;           // Planes::toHtml()
};
std::string toHtml(const Page& page);

}  // namespace latelight::report

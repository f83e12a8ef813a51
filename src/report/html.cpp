#include "report/html.h"

#include <fmt/format.h>
#include <webp/encode.h>

#include <algorithm>
#include <array>
#include <memory>
#include <new>

#include "base/text.h"

namespace latelight::report {

namespace {

struct WebFile {
  std::string_view name, text;
};
constexpr WebFile kWebFiles[] = {
#include "report_files.inc"
};

std::string headOf(const Page& page) {
  std::string links;
  for (const Section& section : page.sections)
    links += fmt::format("<li><a href=\"#{}\">{}</a></li>\n", section.id, escaped(section.title));
  return fmt::format("<header>\n<h1>{}</h1>\n{}<nav aria-label=\"Contents\"><ul>\n{}</ul></nav>\n</header>\n",
                     escaped(page.title), page.introduction, links);
}

// Inside a script element only its end tag is special.
std::string inScript(const nlohmann::ordered_json& data) {
  std::string text = data.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  replaceAll(text, "</", "<\\/");
  return text;
}

// Encodes losslessly, in little more than half of the size of PNG.
std::string webp(const output::Picture& picture) {
  uint8_t* encoded = nullptr;
  const size_t size =
      WebPEncodeLosslessRGBA(picture.rgba.data(), static_cast<int>(picture.width), static_cast<int>(picture.height),
                             static_cast<int>(picture.width * 4), &encoded);
  const std::unique_ptr<uint8_t, decltype(&WebPFree)> kept(encoded, WebPFree);
  if (size == 0) throw std::bad_alloc();
  return base64(std::as_bytes(std::span(encoded, size)));
}

}  // namespace

std::string_view webFile(std::string_view name) {
  return std::ranges::find(kWebFiles, name, &WebFile::name)->text;
}

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t j = i; j < i + 3; ++j)
      group = group << 8 | (j < bytes.size() ? std::to_integer<uint32_t>(bytes[j]) : 0);
    for (size_t digit = 0; digit < 4; ++digit)
      text += i + digit <= bytes.size() ? kDigits[group >> (18 - 6 * digit) & 63] : '=';
  }
  return text;
}

std::string figure(const std::string& id, const output::Picture& picture, std::string_view words,
                   const std::string& caption) {
  return fmt::format(
      "<figure><img id=\"{}\" src=\"data:image/webp;base64,{}\" width=\"{}\" height=\"{}\" alt=\"{}\" "
      "decoding=\"async\">"
      "<figcaption>{}</figcaption></figure>\n",
      id, webp(picture), picture.width, picture.height, escaped(words), caption);
}

std::string toHtml(const Page& page) {
  std::string main;
  for (const Section& section : page.sections)
    main += fmt::format("<section aria-labelledby=\"{0}\">\n<h2 id=\"{0}\">{1}</h2>\n{2}</section>\n", section.id,
                        escaped(section.title), section.html);
  const std::array<std::pair<std::string_view, std::string>, 7> parts{
      {{"{title}", escaped(page.title)},
       {"{style}", std::string(webFile("style.css"))},
       {"{header}", headOf(page)},
       {"{main}", std::move(main)},
       {"{values}", page.values},
       {"{data}", inScript(page.data)},
       {"{script}", std::string(webFile("script.js"))}}};
  std::string_view rest = webFile("page.html");
  std::string html;
  for (const auto& [name, text] : parts) {
    const size_t at = rest.find(name);
    html.append(rest.substr(0, at)).append(text);
    rest.remove_prefix(at + name.size());
  }
  return html.append(rest);
}

}  // namespace latelight::report

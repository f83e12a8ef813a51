// The bytes of bufferViews and images, from the binary chunk, data URIs (RFC 2397), and external files.
#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "base/allowed_folders.h"
#include "base/error.h"
#include "base/lowercase.h"
#include "scene/gltf/document.h"
#include "scene/gltf/json.h"

namespace latelight::scene::gltf {
using nlohmann::json;
namespace {

std::optional<int> hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return std::nullopt;
}

// Decodes percent encoding (RFC 3986, 2.1). A '%' without two digits is preserved, because some exporters forget to
// encode it.
std::string percentDecode(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    std::optional<int> high, low;
    if (text[i] == '%' && i + 2 < text.size()) high = hexDigit(text[i + 1]), low = hexDigit(text[i + 2]);
    if (high && low) {
      out += char(*high * 16 + *low);
      i += 2;
    } else {
      out += text[i];
    }
  }
  return out;
}

// Decodes Base64 (RFC 4648, 4) as browsers do (WHATWG, "Infra Standard", forgiving-base64 decode): padding may be
// missing, and white space is skipped.
std::vector<std::byte> base64Decode(std::string_view text, const std::string& name) {
  constexpr std::string_view kWhiteSpace = "\t\n\f\r ";
  if (text.find_first_of(kWhiteSpace) != std::string_view::npos) {
    std::string dense(text);
    std::erase_if(dense, [=](char c) { return kWhiteSpace.find(c) != std::string_view::npos; });
    return base64Decode(dense, name);
  }
  static const auto digits = [] {
    std::array<uint8_t, 256> table;
    table.fill(255);
    std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < alphabet.size(); ++i) table[uint8_t(alphabet[i])] = uint8_t(i);
    return table;
  }();
  while (text.ends_with('=')) text.remove_suffix(1);
  if (text.size() % 4 == 1) badInput("{} ends within a base64 group", name);
  std::vector<std::byte> out;
  out.reserve(text.size() / 4 * 3 + 3);
  uint32_t bits = 0;
  int held = 0;
  for (char c : text) {
    uint8_t digit = digits[uint8_t(c)];
    if (digit == 255) badInput("{} has a character that base64 does not have", name);
    bits = bits << 6 | digit;
    if ((held += 6) >= 8) out.push_back(std::byte(bits >> (held -= 8)));
  }
  return out;
}

// Schemes of URIs are case-insensitive (RFC 3986, 3.1).
bool isDataUri(std::string_view uri) {
  return lowercase(std::string(uri.substr(0, 5))) == "data:";
}

std::vector<std::byte> readDataUri(std::string_view uri, const std::string& name) {
  size_t comma = uri.find(',');
  if (comma == std::string_view::npos) badInput("{} is a data URI without data", name);
  std::string_view head = uri.substr(0, comma), body = uri.substr(comma + 1);
  const bool isEncoded = body.find('%') != std::string_view::npos;  // base64 usually is not
  const std::string decoded = isEncoded ? percentDecode(body) : std::string();
  if (isEncoded) body = decoded;
  if (lowercase(std::string(head)).ends_with(";base64")) return base64Decode(body, name);
  auto* begin = reinterpret_cast<const std::byte*>(body.data());
  return {begin, begin + body.size()};
}

std::vector<std::byte> readExternal(const AllowedFolders& enclosure, std::string_view uri, const std::string& name) {
  if (uri.find("://") != std::string_view::npos || uri.starts_with("file:"))
    badInput("{} is at {}; only local files are read: put it next to the scene, and use a relative path", name, uri);
  std::string decoded = percentDecode(uri);
  if (decoded.empty() || decoded.find('\0') != std::string::npos) badInput("{} has no usable file name", name);
  try {
    return enclosure.read(decoded);
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{} {}", name, error.what()));
  }
}

Bytes readUri(Document& document, const AllowedFolders& enclosure, std::string_view uri, const std::string& name) {
  document.files.push_back(isDataUri(uri) ? readDataUri(uri, name) : readExternal(enclosure, uri, name));
  document.inputBytes += document.files.back().size();
  return document.files.back();
}

const json::json_pointer kCompressedView("/extensions/EXT_meshopt_compression");

bool isFallback(const json& buffer) {
  json::json_pointer pointer("/extensions/EXT_meshopt_compression/fallback");
  return buffer.contains(pointer) && buffer.at(pointer).get<bool>();
}

// Returns which buffers are read: those of uncompressed views, and those with the bytes of compressed views.
std::vector<bool> findRead(const json& buffers, const json& views) {
  std::vector<bool> read(buffers.size());
  for (const json& view : views)
    read[(view.contains(kCompressedView) ? view.at(kCompressedView) : view)["buffer"].get<size_t>()] = true;
  return read;
}

// A fallback buffer has bytes only for readers without EXT_meshopt_compression, so it stays empty here. Files that
// require the extension may omit its bytes, whether or not they declare it as a fallback; it is then a buffer without
// bytes that no view reads.
Bytes readBuffer(Document& document, const json& buffer, size_t index, bool isRead, const AllowedFolders& enclosure,
                 Bytes binary) {
  std::string name = fmt::format("buffers[{}]", index);
  size_t length = buffer["byteLength"].get<size_t>();
  const bool isEmpty = !buffer.contains("uri") && (index > 0 || binary.empty());
  if (isFallback(buffer) || (isEmpty && !isRead)) return {};
  Bytes bytes;
  if (buffer.contains("uri"))
    bytes = readUri(document, enclosure, buffer["uri"].get_ref<const std::string&>(), name);
  else if (index == 0 && !binary.empty())
    bytes = binary;
  else
    badInput("{} has neither a uri nor the .glb file's binary chunk", name);
  if (bytes.size() < length) badInput("{} should have {} bytes but has {}", name, length, bytes.size());
  return bytes.first(length);
}

size_t strideOf(const json& view, size_t index) {
  const size_t stride = view.value("byteStride", size_t{0});
  if (stride % 4 != 0) badInput("bufferViews[{}].byteStride is {}, which is not a multiple of 4", index, stride);
  return stride;
}

Bytes slice(const std::vector<Bytes>& buffers, const json& view, size_t index) {
  Bytes buffer = buffers[view["buffer"].get<size_t>()];
  size_t offset = view.value("byteOffset", size_t{0}), length = view["byteLength"].get<size_t>();
  if (offset + length > buffer.size())
    badInput("bufferViews[{}] reaches to byte {} of buffers[{}], which has {}", index, offset + length,
             view["buffer"].get<size_t>(), buffer.size());
  return buffer.subspan(offset, length);
}

// A missing image is an error only if a material uses it.
ImageSource readImage(Document& document, const json& image, size_t index, const AllowedFolders& enclosure) {
  ImageSource source;
  std::string label = image.value("name", std::string());
  bool embedded = image.contains("bufferView");
  if (label.empty() && image.contains("uri")) {
    const auto& uri = image["uri"].get_ref<const std::string&>();
    if (!isDataUri(uri)) label = percentDecode(uri);
  }
  source.name = label.empty() ? fmt::format("images[{}]", index) : fmt::format("images[{}] ({})", index, label);
  if (embedded) {
    source.encoded = document.views[image["bufferView"].get<size_t>()].bytes;
  } else if (image.contains("uri")) {
    try {
      source.encoded = readUri(document, enclosure, image["uri"].get_ref<const std::string&>(), source.name);
      if (source.encoded.empty()) source.problem = source.name + " has 0 bytes: save it again";
    } catch (const Error& error) {
      source.problem = error.what();
    }
  }
  if (source.encoded.empty() && source.problem.empty())
    source.problem = source.name + " has neither a uri nor a bufferView with bytes";
  return source;
}

}  // namespace

std::vector<std::filesystem::path> externalFiles(const json& root) {
  std::vector<std::filesystem::path> files;
  for (const char* key : {"buffers", "images"})
    for (const json& entry : arrayIn(root, key)) {
      const json* uri = findProperty(entry, "uri");
      const std::string_view text = uri ? uri->get_ref<const std::string&>() : std::string_view();
      if (!text.empty() && !isDataUri(text)) files.emplace_back(percentDecode(text));
    }
  return files;
}

void Budget::charge(size_t bytes, std::string_view what) const {
  size_t left = left_.load();
  do {
    if (bytes > left)
      badInput("{} requests {} MiB, which together with the rest is far more than a file of this size can contain",
               what, bytes >> 20);
  } while (!left_.compare_exchange_weak(left, left - bytes));
  memory_.grow(bytes, what);
}

void readBuffers(Document& document, const json& root, const AllowedFolders& enclosure, Bytes binary) {
  std::vector<Bytes> buffers;
  const std::vector<bool> read = findRead(arrayIn(root, "buffers"), arrayIn(root, "bufferViews"));
  for (const json& buffer : arrayIn(root, "buffers")) {
    const size_t index = buffers.size();
    buffers.push_back(readBuffer(document, buffer, index, read[index], enclosure, binary));
  }
  document.budget.setInput(document.inputBytes);
  for (const json& view : arrayIn(root, "bufferViews")) {
    const size_t index = document.views.size();
    document.views.push_back({.bytes = view.contains(kCompressedView) ? Bytes() : slice(buffers, view, index),
                              .byteStride = strideOf(view, index)});
  }
  decodeMeshopt(document, root, buffers);
  for (const json& image : arrayIn(root, "images"))
    document.images.push_back(readImage(document, image, document.images.size(), enclosure));
}

}  // namespace latelight::scene::gltf

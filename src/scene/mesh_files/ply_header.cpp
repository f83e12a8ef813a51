#include "scene/mesh_files/ply_header.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "scene/mesh_files/text.h"

namespace latelight::scene::mesh_files {
namespace {

constexpr size_t kMaxHeaderBytes = 1u << 20;

constexpr std::pair<std::string_view, PlyType> kTypeNames[] = {
    {"char", PlyType::Int8},   {"int8", PlyType::Int8},     {"uchar", PlyType::Uint8},   {"uint8", PlyType::Uint8},
    {"short", PlyType::Int16}, {"int16", PlyType::Int16},   {"ushort", PlyType::Uint16}, {"uint16", PlyType::Uint16},
    {"int", PlyType::Int32},   {"int32", PlyType::Int32},   {"uint", PlyType::Uint32},   {"uint32", PlyType::Uint32},
    {"float", PlyType::Float}, {"float32", PlyType::Float}, {"double", PlyType::Double}, {"float64", PlyType::Double}};

// Reads the header line by line.
class HeaderReader {
 public:
  explicit HeaderReader(std::string_view text) : text_(text.substr(0, kMaxHeaderBytes)) {}

  PlyHeader run() {
    if (nextLine() != "ply") badInput("it does not begin with the line \"ply\", as PLY files do");
    while (true) {
      if (at_ >= text_.size()) badInput("its header has no line \"end_header\": copy it again");
      Words words(nextLine());
      const std::string_view key = words.word();
      if (key == "end_header") break;
      read(key, words);
    }
    if (!hasFormat_) badInput("its header has no line \"format\"");
    header_.bytes = at_;
    return std::move(header_);
  }

 private:
  // Lines end with LF, CR LF or, in files of old systems, CR.
  std::string_view nextLine() {
    begin_ = at_;
    const size_t end = std::min(text_.find_first_of("\r\n", at_), text_.size());
    at_ = end + 1;
    if (end < text_.size() && text_[end] == '\r' && at_ < text_.size() && text_[at_] == '\n') ++at_;
    return text_.substr(begin_, end - begin_);
  }

  [[noreturn]] void wrong(std::string_view problem) const {
    const std::string_view before = text_.substr(0, begin_);
    const bool onlyCr = before.find('\n') == std::string_view::npos;
    badInput("line {} of its header {}", std::ranges::count(before, onlyCr ? '\r' : '\n') + 1, problem);
  }

  // Other lines are ignored: some writers break their comments into lines.
  void read(std::string_view key, Words& words) {
    if (key == "format") return readFormat(words);
    if (key == "element") return readElement(words);
    if (key == "property") return readProperty(words);
    if (key == "comment" && equalsIgnoringCase(words.word(), "texturefile"))
      header_.textures.emplace_back(words.rest());
  }

  void readFormat(Words& words) {
    const std::string_view name = words.word();
    if (name == "ascii")
      header_.encoding = PlyEncoding::Ascii;
    else if (name == "binary_little_endian")
      header_.encoding = PlyEncoding::LittleEndian;
    else if (name == "binary_big_endian")
      header_.encoding = PlyEncoding::BigEndian;
    else
      wrong("names an unknown format: it must be ascii, binary_little_endian or binary_big_endian");
    hasFormat_ = true;
  }

  void readElement(Words& words) {
    PlyElement element{.name = std::string(words.word())};
    int64_t count = 0;
    if (element.name.empty() || !words.number(count) || count < 0) wrong("requires a name and a count of elements");
    element.count = static_cast<uint64_t>(count);
    header_.elements.push_back(std::move(element));
  }

  void readProperty(Words& words) {
    if (header_.elements.empty()) wrong("is a property before the first element");
    PlyProperty property;
    std::string_view type = words.word();
    if (type == "list") {
      property.countType = typeOf(words.word());
      if (!isInteger(property.countType)) wrong("counts the entries of a list with a type that is not an integer");
      type = words.word();
    }
    property.type = typeOf(type);
    property.name = std::string(words.word());
    if (property.name.empty()) wrong("is a property without a name");
    header_.elements.back().properties.push_back(std::move(property));
  }

  PlyType typeOf(std::string_view name) const {
    const auto* const type = std::ranges::find(kTypeNames, name, &std::pair<std::string_view, PlyType>::first);
    if (type == std::end(kTypeNames))
      wrong("names an unknown type: it must be char, uchar, short, ushort, int, uint, float or double");
    return type->second;
  }

  const std::string_view text_;
  size_t at_ = 0, begin_ = 0;  // the next line, and the current one
  PlyHeader header_;
  bool hasFormat_ = false;
};

}  // namespace

size_t sizeOf(PlyType type) {
  constexpr std::array<size_t, 9> kSizes = {0, 1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<size_t>(type)];
}

int PlyElement::find(std::initializer_list<std::string_view> names) const {
  for (const std::string_view name : names)
    for (size_t i = 0; i < properties.size(); ++i)
      if (properties[i].name == name) return static_cast<int>(i);
  return -1;
}

PlyHeader readPlyHeader(std::string_view text) {
  return HeaderReader(text).run();
}

}  // namespace latelight::scene::mesh_files

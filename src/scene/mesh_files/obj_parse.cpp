// Parses OBJ files in blocks of about 4 MiB, each by one thread. A negative index counts backwards from the statement,
// so it is known only after the blocks before have been counted; until then it is stored relative to its block.
#include "scene/mesh_files/obj_parse.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "base/parallel.h"
#include "base/utf8.h"
#include "scene/mesh_files/text.h"

namespace latelight::scene::mesh_files {
namespace {

constexpr size_t kBlockBytes = 4u << 20;
constexpr int32_t kMaxIndex = 1 << 29;     // of vertices; also limits negative indices
constexpr int32_t kRelative = -(1 << 30);  // a corner's index relative to its block is stored with this offset

// True if the line that ends before `end` continues in the next one.
bool isContinued(std::string_view text, size_t end) {
  if (end > 0 && text[end - 1] == '\r') --end;
  return end > 0 && text[end - 1] == '\\';
}

// Returns the end of the line that contains the byte `at`, including lines that continue it.
size_t endOfLine(std::string_view text, size_t at) {
  size_t end = std::min(text.find('\n', at), text.size());
  while (end < text.size() && isContinued(text, end)) end = std::min(text.find('\n', end + 1), text.size());
  return end;
}

class BlockParser {
 public:
  BlockParser(std::string_view file, ObjBlock& block) : file_(file), block_(block) {}

  void run() {
    const std::string_view text = block_.text;
    for (size_t at = 0; at < text.size();) {
      const size_t end = endOfLine(text, at);
      line_ = text.substr(at, end - at);
      parse(line_.find('\\') == std::string_view::npos ? line_ : join(line_));
      at = end + 1;
    }
    if (!block_.colors.empty()) block_.colors.resize(block_.positions.size(), vec3(1));
  }

 private:
  [[noreturn]] void wrong(std::string_view problem) const {
    badInput("line {} {}: \"{}\"", lineAt(file_, static_cast<size_t>(line_.data() - file_.data())), problem,
             printable(line_.substr(0, 60)));
  }

  // Replaces the ends of continued lines by blanks.
  std::string_view join(std::string_view line) {
    std::string& text = block_.owned.emplace_back(line);
    for (size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', end)) {
      size_t slash = text.rfind('\\', end);
      std::fill(text.begin() + static_cast<ptrdiff_t>(slash), text.begin() + static_cast<ptrdiff_t>(end) + 1, ' ');
    }
    return text;
  }

  // Reserves space for values of the current line and of the rest of the block, as if its lines were like this one, so
  // that values are rarely moved.
  template <typename T>
  void reserve(std::vector<T>& values, size_t perLine) const {
    if (values.size() + perLine <= values.capacity()) return;
    const auto rest = static_cast<size_t>(block_.text.data() + block_.text.size() - line_.data());
    values.reserve(values.size() + perLine * (rest / (line_.size() + 1) + 1));
  }

  void parse(std::string_view line) {
    Words words(line);
    const std::string_view key = words.word();
    if (key.empty() || key[0] == '#') return;
    if (key == "v") return readPosition(words);
    if (key == "f" || key == "fo") return readFace(words);
    if (key == "vn") {
      reserve(block_.normals, 1);
      block_.normals.push_back(numbers<3>(words, 3, "requires three numbers"));
    } else if (key == "vt") {
      const vec2 uv = numbers<2>(words, 1, "requires one or two numbers");
      reserve(block_.uv, 1);
      block_.uv.push_back(std::isfinite(uv.x) && std::isfinite(uv.y) ? vec2(uv.x, 1 - uv.y) : vec2(0));
    } else {
      readState(key, words);
    }
  }

  void readState(std::string_view key, Words& words) {
    if (key == "o") return add(ObjKey::Object, words.rest());
    if (key == "g") return add(ObjKey::Group, words.rest());
    if (key == "usemtl") return add(ObjKey::Material, words.rest());
    if (key == "s") return add(ObjKey::Smoothing, words.word());
    if (key == "mtllib") block_.materialLibraries.push_back(words.rest());
    if (key == "p" || key == "l") block_.hasPoints = true;
    if (key == "curv" || key == "curv2" || key == "surf") block_.hasCurves = true;
  }

  void add(ObjKey key, std::string_view value) {
    if (!isUtf8(value)) value = block_.owned.emplace_back(utf8OrLatin1(value));
    block_.statements.push_back({key, value, block_.faceSizes.size()});
  }

  template <int N>
  glm::vec<N, float> numbers(Words& words, int required, std::string_view problem) const {
    glm::vec<N, float> values(0);
    for (int i = 0; i < N; ++i)
      if (!words.number(values[i])) {
        if (i < required || !isEnd(words)) wrong(problem);
        break;
      }
    return values;
  }

  static bool isEnd(Words& words) { return words.isAtEnd() || *words.position() == '#'; }

  // Positions may be followed by w, which is ignored, or by a color, as several scanning programs write it.
  void readPosition(Words& words) {
    std::array<float, 7> values{};
    size_t count = 0;
    while (count < values.size() && words.number(values[count])) ++count;
    if (count < 3 || (count < values.size() && !isEnd(words))) wrong("requires three numbers");
    reserve(block_.positions, 1);
    block_.positions.emplace_back(values[0], values[1], values[2]);
    if (count < 6) return;
    vec3 color(values[3], values[4], values[5]);
    for (int i = 0; i < 3; ++i) color[i] = std::isfinite(color[i]) ? std::clamp(color[i], 0.0f, 1.0f) : 1;
    block_.colors.resize(block_.positions.size() - 1, vec3(1));
    block_.colors.push_back(color);
  }

  void readFace(Words& words) {
    const size_t first = block_.corners.size();
    reserve(block_.corners, 3);
    reserve(block_.faceSizes, 1);
    while (!isEnd(words)) block_.corners.push_back(readCorner(words.word()));
    const size_t count = block_.corners.size() - first;
    if (count < 3) wrong("is a face of fewer than three corners");
    block_.faceSizes.push_back(static_cast<uint32_t>(count));
  }

  ObjCorner readCorner(std::string_view word) const {
    const std::array<size_t, 3> counts{block_.positions.size(), block_.uv.size(), block_.normals.size()};
    std::array<int32_t, 3> stored{};  // 0: absent
    const char *at = word.data(), *const end = at + word.size();
    for (size_t i = 0; i < 3; ++i) {
      int32_t index = 0;
      const auto [after, error] = std::from_chars(at, end, index);
      if (error != std::errc() && (i == 0 || error == std::errc::result_out_of_range)) wrong("has a malformed corner");
      if (error == std::errc()) stored[i] = store(index, counts[i]);
      at = after;
      if (at == end) break;
      if (*at != '/' || i == 2) wrong("has a malformed corner");
      ++at;
    }
    return {stored[0], stored[1], stored[2]};
  }

  int32_t store(int32_t index, size_t count) const {
    if (index == 0) wrong("refers to index 0, but OBJ counts from 1");
    if (index >= kMaxIndex || index <= -kMaxIndex) wrong("refers to a vertex that does not exist");
    return index > 0 ? index : kRelative + static_cast<int32_t>(count) + index;
  }

  const std::string_view file_;
  ObjBlock& block_;
  std::string_view line_;
};

std::vector<ObjBlock> split(std::string_view text) {
  std::vector<ObjBlock> blocks;
  for (size_t at = 0; at < text.size();) {
    const size_t end = endOfLine(text, std::min(at + kBlockBytes, text.size()));
    blocks.emplace_back().text = text.substr(at, end - at);
    at = end + 1;
  }
  return blocks;
}

// Returns the line of a block's face, for messages.
size_t lineOfFace(std::string_view file, const ObjBlock& block, size_t face) {
  for (size_t at = 0; at < block.text.size();) {
    const size_t end = endOfLine(block.text, at);
    const std::string_view key = Words(block.text.substr(at, end - at)).word();
    if ((key == "f" || key == "fo") && face-- == 0)
      return lineAt(file, static_cast<size_t>(block.text.data() - file.data()) + at);
    at = end + 1;
  }
  return 0;
}

// Makes the stored indices of a block absolute. `before` are the counts of the blocks before it, `total` those of the
// file. Returns true if it dropped indices of texture coordinates or normals.
bool resolve(std::string_view file, ObjBlock& block, const std::array<size_t, 3>& before,
             const std::array<size_t, 3>& total) {
  bool dropped = false;
  const auto absolute = [&](int32_t stored, size_t i) -> int64_t {
    return stored > 0 ? stored - 1 : stored == 0 ? -1 : int64_t(before[i]) + stored - kRelative;
  };
  size_t at = 0;
  for (size_t face = 0; face < block.faceSizes.size(); ++face)
    for (const size_t end = at + block.faceSizes[face]; at < end; ++at) {
      ObjCorner& corner = block.corners[at];
      const int64_t position = absolute(corner.position, 0);
      if (position < 0 || position >= int64_t(total[0]))
        badInput("line {} refers to a vertex that does not exist: the file has {}", lineOfFace(file, block, face),
                 total[0]);
      corner.position = static_cast<int32_t>(position);
      for (const auto& [index, i] : {std::pair(&corner.uv, size_t{1}), {&corner.normal, size_t{2}}}) {
        const int64_t value = *index == 0 ? -1 : absolute(*index, i);
        const bool exists = value >= 0 && value < int64_t(total[i]);
        dropped |= *index != 0 && !exists;
        *index = exists ? static_cast<int32_t>(value) : -1;
      }
    }
  return dropped;
}

template <typename T>
void gather(std::vector<ObjBlock>& blocks, std::vector<T> ObjBlock::*member, std::vector<T>& all) {
  size_t count = 0;
  for (const ObjBlock& block : blocks) count += (block.*member).size();
  all.reserve(count);
  for (ObjBlock& block : blocks) {
    all.insert(all.end(), (block.*member).begin(), (block.*member).end());
    std::vector<T>().swap(block.*member);
  }
}

}  // namespace

ObjFile parseObj(std::string_view text) {
  ObjFile file{.blocks = split(text)};
  std::vector<ObjBlock>& blocks = file.blocks;
  parallelFor(blocks.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) BlockParser(text, blocks[i]).run();
  });
  std::vector<std::array<size_t, 3>> counts(blocks.size() + 1);
  for (size_t i = 0; i < blocks.size(); ++i)
    counts[i + 1] = {counts[i][0] + blocks[i].positions.size(), counts[i][1] + blocks[i].uv.size(),
                     counts[i][2] + blocks[i].normals.size()};
  if (std::ranges::any_of(counts.back(), [](size_t count) { return count >= size_t{kMaxIndex}; }))
    badInput("it has more than {} vertices: split it", kMaxIndex);
  std::atomic<bool> dropped = false;
  parallelFor(blocks.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      if (resolve(text, blocks[i], counts[i], counts.back())) dropped = true;
  });
  file.hasDroppedIndices = dropped;
  if (std::ranges::any_of(blocks, [](const ObjBlock& block) { return !block.colors.empty(); }))
    for (ObjBlock& block : blocks) block.colors.resize(block.positions.size(), vec3(1));
  gather(blocks, &ObjBlock::positions, file.positions);
  gather(blocks, &ObjBlock::normals, file.normals);
  gather(blocks, &ObjBlock::uv, file.uv);
  gather(blocks, &ObjBlock::colors, file.colors);
  return file;
}

}  // namespace latelight::scene::mesh_files

// Reads STL files, binary and ASCII (3D Systems, "StereoLithography Interface Specification", 1989). The normals of
// facets follow from their corners, because many writers store zeros. The colors that some writers put into the
// attribute bytes of binary files are ignored.
#include <cstring>

#include "base/error.h"
#include "base/log.h"
#include "base/parallel.h"
#include "base/utf8.h"
#include "scene/mesh_files/polygon.h"
#include "scene/mesh_files/source.h"
#include "scene/mesh_files/text.h"

namespace latelight::scene::mesh_files {
namespace {

constexpr size_t kHeaderBytes = 80, kCountBytes = 4, kFacetBytes = 50;
constexpr size_t kStart = kHeaderBytes + kCountBytes;
constexpr size_t kCornerBytes = sizeof(vec3) + sizeof(shared::VertexAttributes) + sizeof(uint32_t);
constexpr uint64_t kMaxFacets = UINT32_MAX / 3;

uint32_t facetCount(std::span<const std::byte> bytes) {  // binary STL is little-endian
  uint32_t count = 0;
  for (size_t i = 0; i < kCountBytes; ++i) count |= uint32_t(bytes[kHeaderBytes + i]) << (8 * i);
  return count;
}

// Binary files may also begin with "solid", so a size that matches the count of facets is decisive.
bool isBinary(const Source& source) {
  const std::string_view text = source.text();
  if (text.size() >= kStart && text.size() == kStart + kFacetBytes * uint64_t{facetCount(source.bytes)}) return true;
  Words words(text.substr(0, 4096));
  if (!equalsIgnoringCase(words.word(), "solid")) return true;
  for (std::string_view word = words.word(); !word.empty(); word = words.word())
    if (equalsIgnoringCase(word, "facet") || equalsIgnoringCase(word, "endsolid")) return false;
  return text.substr(0, 4096).find('\0') != std::string_view::npos;
}

void fillFlat(Mesh& mesh) {
  mesh.attributes.resize(mesh.positions.size());
  mesh.indices.resize(mesh.positions.size());
  parallelFor(mesh.positions.size() / 3, 16384, [&](size_t begin, size_t end) {
    for (size_t facet = begin; facet < end; ++facet) {
      const glm::dvec3 area = polygonNormal(std::span(mesh.positions).subspan(3 * facet, 3));
      const double length = glm::length(area);
      const vec3 normal = length > 0 && std::isfinite(length) ? vec3(area / length) : vec3(0, 0, 1);
      for (size_t v = 3 * facet; v < 3 * facet + 3; ++v) {
        mesh.attributes[v] = {normal, vec4(0), vec2(0)};
        mesh.indices[v] = static_cast<uint32_t>(v);
      }
    }
  });
}

void readBinary(Source& source) {
  const size_t size = source.bytes.size();
  if (size < kStart) badInput("the file has {} bytes, fewer than the header of an STL file: copy it again", size);
  const uint64_t count = facetCount(source.bytes), needed = kStart + kFacetBytes * count;
  if (size < needed)
    badInput("it is a binary STL file of {} facets, which should have {} bytes but has {}: copy it again", count,
             needed, size);
  if (count > kMaxFacets) badInput("it has {} facets, more than the limit of {}: split it", count, kMaxFacets);
  if (count == 0) badInput("it has no facets: export it again with its triangles");
  if (size > needed)
    warn("{} has {} bytes after its last facet, which are ignored", source.path.string(), size - needed);
  source.claim(count * 3 * kCornerBytes);
  Mesh mesh;
  mesh.positions.resize(3 * count);
  parallelFor(count, 16384, [&](size_t begin, size_t end) {
    for (size_t facet = begin; facet < end; ++facet)  // a normal, three corners and two attribute bytes
      std::memcpy(&mesh.positions[3 * facet], source.bytes.data() + kStart + kFacetBytes * facet + sizeof(vec3),
                  3 * sizeof(vec3));
  });
  fillFlat(mesh);
  dropBrokenTriangles(mesh, source.path.string());
  std::vector<Primitive> primitives(1);
  primitives[0].mesh = std::move(mesh);
  source.addNode("", SceneBuilder::kRoot, std::move(primitives));
}

// --- ASCII ----------------------------------------------------------------------------------------------------------

// Reads the solids of an ASCII file. Statements may share lines, and may be split across lines. Only the names of
// solids depend on line ends, because a name may contain blanks. Only "solid", "vertex" and "endfacet" matter. Facets
// of more than three corners, which some writers produce, are triangulated.
class AsciiReader {
 public:
  explicit AsciiReader(Source& source) : source_(source), text_(source.text()), words_(text_) {}

  void run() {
    source_.claim(text_.size());  // a corner has fewer bytes than its statement
    for (std::string_view key = words_.word(); !key.empty(); key = words_.word()) readStatement(key);
    const bool hasEnd = !isInSolid_;
    finishSolid();
    if (!any_) badInput("it has no facets: export it again with its triangles");
    if (!hasEnd)
      warn("{} ends without \"endsolid\", so facets may be missing: compare it with the original, or export it again",
           source_.path.string());
  }

 private:
  void readStatement(std::string_view key) {
    const auto at = static_cast<size_t>(key.data() - text_.data());
    if (equalsIgnoringCase(key, "vertex")) {
      vec3 p;
      for (int i = 0; i < 3; ++i)
        if (!words_.number(p[i])) wrong(at, "requires three numbers after \"vertex\"");
      corners_.push_back(p);
      isInFacet_ = true;
    } else if (equalsIgnoringCase(key, "endfacet")) {
      finishFacet(at);
    } else if (equalsIgnoringCase(key, "facet")) {
      if (isInFacet_) wrong(at, "begins a facet before the last one has ended with \"endfacet\"");
      isInFacet_ = isInSolid_ = true;
      skipNormal();
    } else if (equalsIgnoringCase(key, "solid")) {
      finishSolid();
      isInSolid_ = true;
      name_ = utf8OrLatin1(readName());
    } else if (equalsIgnoringCase(key, "endsolid")) {
      isInSolid_ = false;
      skipEndName();
    } else if (!equalsIgnoringCase(key, "outer") && !equalsIgnoringCase(key, "loop") &&
               !equalsIgnoringCase(key, "endloop")) {
      wrong(at, fmt::format("contains \"{}\", which ASCII STL does not define there: export the file again",
                            printableStart(key)));
    }
  }

  // Skips "normal" and three words, which need not be numbers: some writers store "-nan(ind)".
  void skipNormal() {
    Words after = words_;
    if (!equalsIgnoringCase(after.word(), "normal")) return;
    for (int i = 0; i < 3; ++i) after.word();
    words_ = after;
  }

  // Returns the rest of the line. In files on one line, the first facet ends the name.
  std::string_view readName() {
    std::string_view name;
    Words after = words_;
    for (std::string_view word = after.wordOnLine(); !word.empty(); word = after.wordOnLine()) {
      if (equalsIgnoringCase(word, "facet") && equalsIgnoringCase(Words(after).wordOnLine(), "normal")) break;
      if (name.empty()) name = word;
      name = {name.data(), static_cast<size_t>(word.data() + word.size() - name.data())};
      words_ = after;
    }
    return name;
  }

  // Skips the name after "endsolid". In files on one line, the next "solid" ends the name.
  void skipEndName() {
    Words after = words_;
    for (std::string_view word = after.wordOnLine(); !word.empty(); word = after.wordOnLine()) {
      if (equalsIgnoringCase(word, "solid")) break;
      words_ = after;
    }
  }

  static std::string printableStart(std::string_view word) { return printable(word.substr(0, 40)); }

  [[noreturn]] void wrong(size_t at, const std::string& problem) const {
    badInput("line {} {}", lineAt(text_, at), problem);
  }

  void finishFacet(size_t at) {
    if (corners_.size() < 3) wrong(at, fmt::format("ends a facet with {} corners instead of 3", corners_.size()));
    triangles_.clear();
    triangulate(corners_, triangles_);
    for (const auto& triangle : triangles_)
      for (const uint32_t corner : triangle) positions_.push_back(corners_[corner]);
    corners_.clear();
    isInFacet_ = false;
  }

  void finishSolid() {
    if (isInFacet_) badInput("the file ends within a facet: copy it again");
    if (positions_.empty()) return;
    if (positions_.size() / 3 > kMaxFacets) badInput("it has more than {} facets: split it", kMaxFacets);
    source_.claim(positions_.size() * kCornerBytes);
    std::vector<Primitive> primitives(1);
    Mesh& mesh = primitives[0].mesh;
    mesh.positions = std::move(positions_);
    fillFlat(mesh);
    dropBrokenTriangles(mesh, source_.path.string());
    source_.addNode(name_.empty() ? "solid" : name_, SceneBuilder::kRoot, std::move(primitives));
    positions_.clear();
    any_ = true;
  }

  Source& source_;
  const std::string_view text_;
  Words words_;
  std::string name_;
  std::vector<vec3> positions_, corners_;
  std::vector<std::array<uint32_t, 3>> triangles_;
  bool any_ = false, isInFacet_ = false, isInSolid_ = false;
};

}  // namespace

void readStl(Source& source) {
  source.builder.scene.materials.push_back(plainMaterial("default", vec3(0.8f), 0, 0.5f));
  if (isBinary(source))
    readBinary(source);
  else
    AsciiReader(source).run();
}

}  // namespace latelight::scene::mesh_files

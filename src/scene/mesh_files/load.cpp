#include "scene/mesh_files/load.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <new>
#include <span>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "base/log.h"
#include "base/parallel.h"
#include "base/utf8.h"
#include "scene/ids.h"
#include "scene/mesh_files/source.h"

namespace latelight::scene {
namespace mesh_files {
namespace {

struct Unit {
  std::string_view name;
  double meters;
};
constexpr std::array kUnits = {Unit{"mm", 0.001}, Unit{"cm", 0.01}, Unit{"m", 1}, Unit{"in", 0.0254},
                               Unit{"ft", 0.3048}};

double metersPerUnit(const std::string& name) {
  if (name.empty()) return 1;
  const auto* const unit = std::ranges::find(kUnits, name, &Unit::name);
  if (unit == kUnits.end()) badUsage("'{}' is not a unit of length: set --unit to mm, cm, m, in or ft", name);
  return unit->meters;
}

// The paths of all groups begin with that of their object, so they may be far longer than the file.
constexpr size_t kMaxPathBytes = size_t{256} << 20;

bool isFinite(const vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

uint64_t geometryBytes(const Scene& scene) {
  uint64_t bytes = scene.instances.size() * sizeof(Instance) + scene.nodes.size() * sizeof(Node);
  for (const Mesh& mesh : scene.meshes) bytes += mesh.bytes();
  return bytes;
}

Scene import(const std::filesystem::path& path, MeshFormat format, const LoadOptions& options,
             const FileObserver& observer) {
  if (!options.variant.empty()) badUsage("it has no material variants: omit the variant '{}'", options.variant);
  const std::optional<float> radius = options.pointRadius;
  if (radius && !(*radius > 0 && std::isfinite(*radius))) badUsage("--point-radius requires a length above 0");
  Source source(path, format, options, observer);
  source.claim(source.bytes.size());
  if (format == MeshFormat::Obj) readObj(source);
  if (format == MeshFormat::Ply) readPly(source);
  if (format == MeshFormat::Stl) readStl(source);
  if (radius && !source.hasPoints)
    warn("{} has faces, so --point-radius has no effect: it is for PLY files without faces", path.string());
  Scene& scene = source.builder.scene;
  source.working = {};
  scene.memory.grow(geometryBytes(scene), "its meshes");
  identifyMaterials(scene);
  scene.name = path.stem().string();
  scene.source = path.string();
  scene.files.insert(scene.files.begin(), path);
  return std::move(scene);
}

}  // namespace

Frame frameOf(MeshFormat format, const LoadOptions& options) {
  if (!options.upAxis.empty() && options.upAxis != "y" && options.upAxis != "z")
    badUsage("'{}' is not an up axis: set --up-axis to y or z", options.upAxis);
  const bool yUp = options.upAxis.empty() ? format == MeshFormat::Obj : options.upAxis == "y";
  return {yUp, metersPerUnit(options.unit)};
}

Source::Source(const std::filesystem::path& file, MeshFormat format, const LoadOptions& loadOptions,
               const FileObserver& observer)
    : path(file),
      options(loadOptions),
      frame(frameOf(format, loadOptions)),
      bytes(readLargeFile(file)),
      folders(file, loadOptions.allowOutside, observer),
      builder(utf8OrLatin1(file.stem().string()), frame.yUp, dmat4(glm::dmat3(frame.metersPerUnit))) {}

uint32_t Source::addNode(const std::string& name, uint32_t parent, std::vector<Primitive> primitives) {
  std::erase_if(primitives, [](const Primitive& primitive) { return primitive.mesh.indices.empty(); });
  const uint32_t node = name.empty() ? parent : builder.addNode(name, parent);
  Scene& scene = builder.scene;
  if ((pathBytes_ += scene.nodes[node].path.size()) > kMaxPathBytes)
    badInput("the names of its objects and groups are too long: shorten them");
  const std::string meshName = scene.nodes[node].name;
  if (!primitives.empty()) scene.nodes[node].mesh = meshName;
  const bool several = primitives.size() > 1;
  for (uint32_t i = 0; i < primitives.size(); ++i) {
    Mesh& mesh = scene.meshes.emplace_back(std::move(primitives[i].mesh));
    findBounds(mesh);
    mesh.name = several ? fmt::format("{}/primitive{}", meshName, i) : meshName;
    builder.addPrimitive(node, static_cast<uint32_t>(scene.meshes.size() - 1), primitives[i].material, i, several);
  }
  return node;
}

void dropBrokenTriangles(Mesh& mesh, const std::string& name) {
  std::atomic<bool> areFinite = true;
  parallelFor(mesh.positions.size(), size_t{1} << 16, [&](size_t begin, size_t end) {
    if (!std::ranges::all_of(std::span(mesh.positions).subspan(begin, end - begin), isFinite)) areFinite = false;
  });
  if (areFinite) return;
  warn("{} has positions that are not finite numbers: triangles with such corners are left out", name);
  size_t kept = 0;
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const std::array corners{mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]};
    if (!std::ranges::all_of(corners, [&](uint32_t v) { return isFinite(mesh.positions[v]); })) continue;
    std::ranges::copy(corners, mesh.indices.begin() + static_cast<ptrdiff_t>(kept));
    kept += 3;
  }
  if (kept == 0) badInput("{} has no triangle whose positions are finite numbers", name);
  mesh.indices.resize(kept);
  const vec3 usable = mesh.positions[mesh.indices[0]];
  for (vec3& p : mesh.positions)
    if (!isFinite(p)) p = usable;
}

}  // namespace mesh_files

Scene loadMeshFile(const std::filesystem::path& path, MeshFormat format, const LoadOptions& options,
                   const FileObserver& observer) {
  try {
    return mesh_files::import(path, format, options, observer);
  } catch (const Error& error) {
    const std::string sentence = error.what();
    if (sentence.find(path.string()) != std::string::npos) throw;
    throw Error(error.code(), fmt::format("{}: {}", path.string(), sentence));
  } catch (const std::bad_alloc&) {
    failWithoutMemory(fmt::format("the scene {}", path.string()));
  }
}

}  // namespace latelight::scene

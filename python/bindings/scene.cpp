// Binds the class Scene.
#include <fmt/ranges.h>

#include <cctype>
#include <filesystem>

#include "scene.h"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "interpreter.h"
#include "values.h"

namespace latelight::python {

namespace {

using Class = nb::class_<SharedScene>;

// --- arguments ------------------------------------------------------------------------------------------------------

template <typename Element>
Handle<Element> handleOf(nb::handle value, const char* name) {
  return objectOf<Handle<Element>>(value, name, fmt::format("the handle of {}", name));
}

Transform transformOf(nb::handle value) {
  if (value.is_none()) return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  return matrixOf<4, 4>(value, "transform");
}

std::vector<uint32_t> indicesOf(nb::handle value, size_t positions) {
  if (value.is_none()) return {};
  const nb::object array = arrayOf(value, "indices", Elements::Integers, {-1, 3}, "int64");
  std::vector<uint32_t> indices(3 * lengthOf(array, 0));
  if (indices.empty()) badValue("indices must have a triangle: leave it out for one each three positions");
  const auto view = viewOf<int64_t>(array);
  for (size_t i = 0; i < indices.size(); ++i) {
    const int64_t index = view.data()[i];
    if (index < 0 || index >= static_cast<int64_t>(positions))
      badValue("indices must lie from 0 to {}, since there are {} positions, and one is {}",
               static_cast<int64_t>(positions) - 1, positions, index);
    indices[i] = static_cast<uint32_t>(index);
  }
  return indices;
}

template <size_t N>
std::vector<std::array<float, N>> attributeOf(nb::handle value, const char* name, size_t positions, Integers integers) {
  if (value.is_none()) return {};
  std::vector<std::array<float, N>> rows = rowsOf<N>(value, name, integers);
  if (rows.size() != positions)
    badValue("{} must have a row for each of the {} positions, not {}", name, positions, rows.size());
  return rows;
}

// Rejects colors outside [0, 1], because floats or wide integers from 0 to 255 are a mistake.
void requireFactors(const std::vector<std::array<float, 4>>& colors) {
  for (const std::array<float, 4>& color : colors)
    for (const float channel : color)
      if (!(channel >= 0 && channel <= 1))
        badValue("colors must lie from 0 to 1, or be uint8 or uint16, and one is {}", channel);
}

MeshData meshDataOf(nb::handle positions, nb::handle indices, nb::handle normals, nb::handle tangents, nb::handle uv,
                    nb::handle uv1, nb::handle colors, nb::handle name, nb::handle targets, nb::handle skin,
                    nb::handle joints, nb::handle jointWeights) {
  MeshData mesh;
  mesh.name = textOf(name, "name");
  mesh.positions = rowsOf<3>(positions, "positions");
  const size_t count = mesh.positions.size();
  mesh.indices = indicesOf(indices, count);
  mesh.normals = attributeOf<3>(normals, "normals", count, Integers::SignedNormalized);
  mesh.tangents = attributeOf<4>(tangents, "tangents", count, Integers::SignedNormalized);
  mesh.uv = attributeOf<2>(uv, "uv", count, Integers::Normalized);
  mesh.uv1 = attributeOf<2>(uv1, "uv1", count, Integers::Normalized);
  mesh.colors = attributeOf<4>(colors, "colors", count, Integers::Normalized);
  requireFactors(mesh.colors);
  deformationOf(targets, skin, joints, jointWeights, mesh);
  return mesh;
}

// Converts pixels of one to four channels (gray, gray and alpha, RGB, RGBA) to RGBA.
TextureData textureDataOf(nb::handle pixels, bool srgb, nb::handle name) {
  const nb::object given = arrayOf(pixels, "pixels", Elements::Uint8, {kHeightLength, kWidthLength, kChannelLength});
  TextureData data{textOf(name, "name"),
                   static_cast<uint32_t>(lengthOf(given, 1)),
                   static_cast<uint32_t>(lengthOf(given, 0)),
                   srgb,
                   {}};
  const size_t channels = lengthOf(given, 2), count = size_t{data.width} * data.height;
  if (channels < 1 || channels > 4) badValue("pixels must have 1 to 4 channels, not {}", channels);
  if (count == 0) badValue("pixels must not be empty");
  const bool grey = channels < 3;
  const uint8_t* from = viewOf<uint8_t>(given).data();
  data.rgba.resize(4 * count);
  for (size_t i = 0; i < count; ++i, from += channels) {
    for (size_t c = 0; c < 3; ++c) data.rgba[4 * i + c] = from[grey ? 0 : c];
    data.rgba[4 * i + 3] = channels % 2 == 0 ? from[channels - 1] : 255;
  }
  return data;
}

constexpr const char* kSlots[] = {  // in the order of TextureSlot
    "base_color",
    "metallic_roughness",
    "normal",
    "occlusion",
    "emissive",
    "specular",
    "specular_color",
    "clearcoat",
    "clearcoat_roughness",
    "clearcoat_normal",
    "sheen_color",
    "sheen_roughness",
    "anisotropy",
    "iridescence",
    "iridescence_thickness",
    "transmission",
    "thickness",
    "diffuse_transmission",
    "diffuse_transmission_color"};
constexpr const char* kWraps[] = {"repeat", "mirror", "clamp"};  // in the order of Wrap

template <typename Enum, size_t N>
Enum enumOf(nb::handle value, const char* name, const char* const (&names)[N]) {
  const std::string text = textOf(value, name);
  std::string all;
  for (size_t i = 0; i < N; ++i) {
    if (text == names[i]) return static_cast<Enum>(i);
    all += (i ? ", " : "") + std::string(names[i]);
  }
  badValue("{} must be one of {}, not \"{}\"", name, all, text);
}

// --- the parts of the class -----------------------------------------------------------------------------------------

// Returns the package's function that converts a file which C++ does not read, or null.
const char* converterOf(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension == ".urdf") return "from_urdf";
  for (const char* usd : {".usd", ".usda", ".usdc", ".usdz"})
    if (extension == usd) return "from_usd";
  return nullptr;
}

// Returns true if options are given that converters do not have.
bool hasOptionsOfFiles(const SceneOptions& o) {
  return !o.materialVariant.empty() || o.idDepth || !o.idNodes.empty() || !o.unit.empty() || !o.upAxis.empty() ||
         o.pointRadius;
}

void convert(SharedScene* self, const char* function, const std::string& path,
             const std::vector<std::string>& allowOutside) {
  const RunningPython section;
  nb::list folders;
  for (const std::string& folder : allowOutside) folders.append(nb::str(folder.c_str()));
  const nb::object made =
      nb::module_::import_("latelight").attr(function)(path, nb::arg("allow_outside") = nb::tuple(folders));
  new (self) SharedScene(nb::cast<SharedScene&>(made).edit([](Scene& scene) { return std::move(scene); }));
}

void load(SharedScene* self, nb::handle source, nb::handle variant, nb::handle allowOutside, nb::handle idDepth,
          nb::handle idNodes, nb::handle unit, nb::handle upAxis, nb::handle pointRadius) {
  SceneOptions options{.materialVariant = textOf(variant, "material_variant"),
                       .allowOutside = pathsOf(allowOutside, "allow_outside")};
  if (!idDepth.is_none()) options.idDepth = static_cast<uint32_t>(integerOf(idDepth, "id_depth", 0, UINT32_MAX));
  options.idNodes = textsOf(idNodes, "id_nodes");
  options.unit = textOf(unit, "unit");
  options.upAxis = textOf(upAxis, "up_axis");
  if (!pointRadius.is_none()) options.pointRadius = static_cast<float>(numberOf(pointRadius, "point_radius"));
  const std::string path = source.is_none() ? "" : pathOf(source, "source");
  if (const char* converter = converterOf(path)) {
    if (hasOptionsOfFiles(options))
      badValue("Scene() has no options for '{}': call latelight.{}() with those that it has", path, converter);
    return convert(self, converter, path, options.allowOutside);
  }
  const WithoutGil others;
  new (self) SharedScene(source.is_none() ? Scene() : Scene(path, options));
}

void defineWhole(Class& type) {
  type.def("__init__", &load, argument("source") = nb::none(), argument("material_variant") = "",
           argument("allow_outside") = nb::make_tuple(), argument("id_depth") = nb::none(),
           argument("id_nodes") = nb::make_tuple(), argument("unit") = "", argument("up_axis") = "",
           argument("point_radius") = nb::none(),
           nb::sig("def __init__(self, source: str | os.PathLike[str] | None = None, material_variant: str = \"\", "
                   "allow_outside: collections.abc.Sequence[str] = (), id_depth: int | None = None, "
                   "id_nodes: collections.abc.Sequence[str] = (), unit: str = \"\", up_axis: str = \"\", "
                   "point_radius: float | None = None) -> None"),
           "Loads a .gltf, .glb, .obj, .ply or .stl file, or \"builtin:hall\", \"builtin:spheres\", \"builtin:boxes\"; "
           "converts a .usd, .usda, .usdc, .usdz or .urdf file by from_usd() or from_urdf(); without a source it is "
           "empty.\n\nmaterial_variant: of KHR_materials_variants, by name\nallow_outside: "
           "folders that it may read "
           "files from, besides its own with its subfolders\nid_depth, id_nodes: whole subtrees of nodes under one "
           "id (docs/conventions.md)\nunit, up_axis: of OBJ, PLY and STL files: mm, cm, m, in or ft, and y or z\n"
           "point_radius: in meters, of the spheres that stand for the points of a PLY file\n\nRaises InputError for a "
           "file that is missing or broken.");
  type.def(
      "export",
      [](const SharedScene& s, nb::handle file) {
        const std::string path = pathOf(file, "file");
        s.read([&](const Scene& s) { s.exportTo(path); });
      },
      argument("file"), nb::sig("def export(self, file: str | os.PathLike[str]) -> None"),
      "Writes the scene as it is, with its edits, to a .glb file, or its geometry to an .obj or .ply file.");
  type.def(
      "set_environment",
      [](SharedScene& s, nb::handle environment) {
        const EnvironmentData data = environmentOf(environment);
        s.edit([&](Scene& s) { s.setEnvironment(data); });
      },
      argument("environment"), nb::sig("def set_environment(self, environment: numpy.typing.ArrayLike) -> None"),
      "The environment of renderers that are made afterward without one of their own: linear radiance (H, W, 3), W = "
      "2 H,\nwith the center column at +X of the glTF frame and the zenith in the top row. It is not exported.");
  type.def_prop_ro("triangle_count",
                   [](const SharedScene& s) { return s.read([](const Scene& s) { return s.triangleCount(); }); });
  type.def(
      "id_manifest",
      [](const SharedScene& s) {
        const std::string text = s.read([](const Scene& s) { return s.idManifest(); });
        const RunningPython section;
        return nb::module_::import_("json").attr("loads")(text);
      },
      nb::sig("def id_manifest(self) -> dict[str, typing.Any]"),
      "What the numbers in the outputs id, part and material stand for (docs/conventions.md).");
  type.def_prop_ro("nodes", [](const SharedScene& s) { return s.read([](const Scene& s) { return s.nodes(); }); });
  type.def(
      "joints",
      [](const SharedScene& s, nb::handle instance) {
        const auto handle = objectOf<Handle<Instance>>(instance, "instance", "an InstanceHandle");
        return s.read([&](const Scene& s) { return s.joints(handle); });
      },
      argument("instance"), nb::sig("def joints(self, instance: InstanceHandle) -> list[str]"),
      "Paths of the nodes that are the joints of an instance's skin, in the skin's order; none if it has no skin.");
  type.def_prop_ro("animations",
                   [](const SharedScene& s) { return s.read([](const Scene& s) { return s.animations(); }); });
  type.def_prop_ro(
      "bounds",
      [](const SharedScene& s) -> nb::object {
        const auto bounds = s.read([](const Scene& s) { return s.bounds(); });
        return bounds ? nb::object(nb::make_tuple(tupleOf(bounds->min), tupleOf(bounds->max))) : nb::none();
      },
      nb::sig("def bounds(self) -> tuple[tuple[float, ...], tuple[float, ...]] | None"),
      "Smallest and largest corner of the smallest box around the vertices of all visible instances at rest, meters, "
      "in the scene file's frame; None: it is empty.");
}

void defineCameras(Class& type) {
  type.def_prop_ro(
      "cameras", [](const SharedScene& s) { return s.read([](const Scene& s) { return s.cameras(); }); },
      "The scene's own, at rest.");
  type.def(
      "add_camera",
      [](SharedScene& s, nb::handle camera, nb::handle node) {
        const Camera added = objectOf<Camera>(camera, "camera", "a Camera");
        if (node.is_none()) return s.edit([&](Scene& s) { s.addCamera(added); });
        const std::string path = textOf(node, "node");
        s.edit([&](Scene& s) { s.addCamera(added, path); });
      },
      argument("camera"), argument("node") = nb::none(),
      nb::sig("def add_camera(self, camera: Camera, node: str | None = None) -> None"),
      "Adds it after the scene's own.\n\nnode: path of the node that it follows, at the node's origin and along its "
      "-Z axis, in place of its own pose");
  type.def(
      "cameras_at",
      [](const SharedScene& s, nb::handle time, nb::handle animation, nb::handle loop) {
        const double at = numberOf(time, "time");
        const std::string name = textOf(animation, "animation");
        const bool repeats = boolOf(loop, "loop");
        return s.read([&](const Scene& s) { return s.camerasAt(at, name, repeats); });
      },
      argument("time"), argument("animation") = "", argument("loop") = false,
      nb::sig("def cameras_at(self, time: float, animation: str = \"\", loop: bool = False) -> list[Camera]"),
      "The scene's own cameras where they are at a time, in seconds; as the options time, animation and loop say.");
  type.def(
      "default_camera",
      [](const SharedScene& s, nb::handle aspect, nb::handle time, nb::handle animation, nb::handle loop) {
        const float ratio = floatOf(aspect, "aspect");
        const std::optional<double> at = time.is_none() ? std::nullopt : std::optional(numberOf(time, "time"));
        const std::string name = textOf(animation, "animation");
        const bool repeats = boolOf(loop, "loop");
        return s.read([&](const Scene& s) { return s.defaultCamera(ratio, at, name, repeats); });
      },
      argument("aspect") = 16.0 / 9, argument("time") = nb::none(), argument("animation") = "",
      argument("loop") = false,
      nb::sig("def default_camera(self, aspect: float = 16 / 9, time: float | None = None, animation: str = \"\", "
              "loop: bool = False) -> Camera"),
      "The first of the scene's own cameras, or a view that shows the whole scene in a picture of this aspect, width / "
      "height.\n\nThe camera is where it is at `time`, in seconds, as in `cameras_at`; without a time, at rest.");
  type.def(
      "look_at",
      [](const SharedScene& s, nb::handle eye, nb::handle target, nb::handle fov) {
        const auto from = numbersOf<double, 3>(eye, "eye"), to = numbersOf<double, 3>(target, "target");
        const float angle = floatOf(fov, "vertical_fov");
        return s.read([&](const Scene& s) { return s.lookAt(from, to, angle); });
      },
      argument("eye"), argument("target"), argument("vertical_fov") = 40.0,
      nb::sig("def look_at(self, eye: numpy.typing.ArrayLike, target: numpy.typing.ArrayLike, vertical_fov: float = "
              "40) -> Camera"),
      "A camera at `eye` that looks at `target`, both (3,), meters, with the scene's up.");
}

void defineInstances(Class& type) {
  type.def(
      "instances",
      [](const SharedScene& s, nb::handle node) {
        if (node.is_none()) return s.read([](const Scene& s) { return s.instances(); });
        const std::string path = textOf(node, "node");
        return s.read([&](const Scene& s) { return s.instancesOf(path); });
      },
      argument("node") = nb::none(), nb::sig("def instances(self, node: str | None = None) -> list[InstanceHandle]"),
      "All, or those of a node by its path: one a primitive of its mesh.");
  type.def(
      "instance",
      [](const SharedScene& s, nb::handle instance) {
        const auto handle = handleOf<Instance>(instance, "instance");
        return s.read([&](const Scene& s) { return s.instance(handle); });
      },
      argument("instance"), nb::sig("def instance(self, instance: InstanceHandle) -> Instance"), "Its properties.");
  type.def(
      "set_transform",
      [](SharedScene& s, nb::handle instance, nb::handle transform) {
        const auto handle = handleOf<Instance>(instance, "instance");
        const Transform matrix = matrixOf<4, 4>(transform, "transform");
        s.edit([&](Scene& s) { s.setTransform(handle, matrix); });
      },
      argument("instance"), argument("transform"),
      nb::sig("def set_transform(self, instance: InstanceHandle, transform: numpy.typing.ArrayLike) -> None"),
      "(4, 4), last row 0 0 0 1: object space to the scene file's frame. No animation moves it from then on.");
  type.def(
      "assign_material",
      [](SharedScene& s, nb::handle instance, nb::handle material) {
        const auto to = handleOf<Instance>(instance, "instance");
        const auto handle = handleOf<Material>(material, "material");
        s.edit([&](Scene& s) { s.assignMaterial(to, handle); });
      },
      argument("instance"), argument("material"),
      nb::sig("def assign_material(self, instance: InstanceHandle, material: MaterialHandle) -> None"));
  type.def(
      "add_instance",
      [](SharedScene& s, nb::handle mesh, nb::handle material, nb::handle transform, nb::handle name) {
        const auto meshHandle = handleOf<Mesh>(mesh, "mesh");
        const auto materialHandle = handleOf<Material>(material, "material");
        const Transform matrix = transformOf(transform);
        const std::string text = textOf(name, "name");
        return s.edit([&](Scene& s) { return s.addInstance(meshHandle, materialHandle, matrix, text); });
      },
      argument("mesh"), argument("material"), argument("transform") = nb::none(), argument("name") = "",
      nb::sig("def add_instance(self, mesh: MeshHandle, material: MaterialHandle, "
              "transform: numpy.typing.ArrayLike | None = None, name: str = \"\") -> InstanceHandle"),
      "Shows the mesh under a root node of its own, \"/name\", or \"/name#2\" and so on where that is taken.");
  type.def(
      "remove_instance",
      [](SharedScene& s, nb::handle instance) {
        const auto handle = handleOf<Instance>(instance, "instance");
        s.edit([&](Scene& s) { s.removeInstance(handle); });
      },
      argument("instance"), nb::sig("def remove_instance(self, instance: InstanceHandle) -> None"));
}

void defineMaterials(Class& type) {
  type.def("materials", [](const SharedScene& s) { return s.read([](const Scene& s) { return s.materials(); }); });
  type.def(
      "material",
      [](const SharedScene& s, nb::handle material) {
        const auto handle = handleOf<Material>(material, "material");
        return s.read([&](const Scene& s) { return s.material(handle); });
      },
      argument("material"), nb::sig("def material(self, material: MaterialHandle) -> Material"),
      "Its properties, a copy.");
  type.def(
      "set_material",
      [](SharedScene& s, nb::handle material, nb::handle values) {
        const auto handle = handleOf<Material>(material, "material");
        const Material to = objectOf<Material>(values, "values", "a Material");
        s.edit([&](Scene& s) { s.setMaterial(handle, to); });
      },
      argument("material"), argument("values"),
      nb::sig("def set_material(self, material: MaterialHandle, values: Material) -> None"), "Its textures stay.");
  type.def(
      "add_material",
      [](SharedScene& s, nb::handle values, nb::handle texturesOf) {
        const Material added = objectOf<Material>(values, "values", "a Material");
        std::optional<Handle<Material>> like;
        if (!texturesOf.is_none()) like = handleOf<Material>(texturesOf, "textures_of");
        return s.edit([&](Scene& s) { return s.addMaterial(added, like); });
      },
      argument("values"), argument("textures_of") = nb::none(),
      nb::sig("def add_material(self, values: Material, textures_of: MaterialHandle | None = None) -> MaterialHandle"),
      "Without textures, or with those of another material.");
  type.def(
      "remove_material",
      [](SharedScene& s, nb::handle material) {
        const auto handle = handleOf<Material>(material, "material");
        s.edit([&](Scene& s) { s.removeMaterial(handle); });
      },
      argument("material"), nb::sig("def remove_material(self, material: MaterialHandle) -> None"),
      "Raises UsageError while an instance shows it.");
}

void defineTextures(Class& type) {
  type.def("textures", [](const SharedScene& s) { return s.read([](const Scene& s) { return s.textures(); }); });
  type.def(
      "texture",
      [](const SharedScene& s, nb::handle texture) {
        const auto handle = handleOf<Texture>(texture, "texture");
        return s.read([&](const Scene& s) { return s.texture(handle); });
      },
      argument("texture"), nb::sig("def texture(self, texture: TextureHandle) -> Texture"), "Its name and size.");
  type.def(
      "texture_pixels",
      [](const SharedScene& s, nb::handle texture) {
        const auto handle = handleOf<Texture>(texture, "texture");
        TextureData data = s.read([&](const Scene& s) { return s.textureData(handle); });
        return owned(std::move(data.rgba), {data.height, data.width, 4});
      },
      argument("texture"), nb::sig("def texture_pixels(self, texture: TextureHandle) -> numpy.ndarray"),
      "(H, W, 4) uint8: RGBA, straight alpha, rows from the top.");
  type.def(
      "add_texture",
      [](SharedScene& s, nb::handle pixels, nb::handle srgb, nb::handle name) {
        const TextureData data = textureDataOf(pixels, boolOf(srgb, "srgb"), name);
        return s.edit([&](Scene& s) { return s.addTexture(data); });
      },
      argument("pixels"), argument("srgb") = true, argument("name") = "",
      nb::sig("def add_texture(self, pixels: numpy.typing.ArrayLike, srgb: bool = True, name: str = \"\") -> "
              "TextureHandle"),
      "pixels: (H, W, C) uint8, rows from the top; 1 channel is gray, 2 gray and alpha, 3 RGB, 4 RGBA. srgb: as base "
      "colors\n"
      "and emitted light are stored; False for normals, roughness and other data.");
  type.def(
      "set_texture_pixels",
      [](SharedScene& s, nb::handle texture, nb::handle pixels, nb::handle srgb, nb::handle name) {
        const auto handle = handleOf<Texture>(texture, "texture");
        TextureData data = textureDataOf(pixels, !srgb.is_none() && boolOf(srgb, "srgb"), name);
        const bool keepsEncoding = srgb.is_none();
        s.edit([&](Scene& s) {
          if (keepsEncoding) data.srgb = s.texture(handle).srgb;
          s.setTextureData(handle, data);
        });
      },
      argument("texture"), argument("pixels"), argument("srgb") = nb::none(), argument("name") = "",
      nb::sig("def set_texture_pixels(self, texture: TextureHandle, pixels: numpy.typing.ArrayLike, "
              "srgb: bool | None = None, name: str = \"\") -> None"),
      "Replaces the pixels, as add_texture() takes them; the size may change. All materials that sample the texture "
      "change\nwith it. Without srgb and name it keeps its own.");
  type.def(
      "remove_texture",
      [](SharedScene& s, nb::handle texture) {
        const auto handle = handleOf<Texture>(texture, "texture");
        s.edit([&](Scene& s) { s.removeTexture(handle); });
      },
      argument("texture"), nb::sig("def remove_texture(self, texture: TextureHandle) -> None"),
      "Raises UsageError while a material samples it.");
}

void defineMaterialTextures(Class& type) {
  const std::string signature = fmt::format(
      "def set_texture(self, material: MaterialHandle, slot: typing.Literal[\"{}\"], texture: TextureHandle | None, "
      "wrap: typing.Literal[\"repeat\", \"mirror\", \"clamp\"] = \"repeat\", smooth: bool = True, uv_set: int = 0) "
      "-> None",
      fmt::join(kSlots, "\", \""));
  type.def(
      "set_texture",
      [](SharedScene& s, nb::handle material, nb::handle slot, nb::handle texture, nb::handle wrap, nb::handle smooth,
         nb::handle uvSet) {
        const auto handle = handleOf<Material>(material, "material");
        const auto place = enumOf<TextureSlot>(slot, "slot", kSlots);
        std::optional<TextureUse> use;
        if (!texture.is_none()) {
          const auto wraps = enumOf<Wrap>(wrap, "wrap", kWraps);
          use = TextureUse{handleOf<Texture>(texture, "texture"), wraps, wraps, boolOf(smooth, "smooth"),
                           static_cast<uint32_t>(integerOf(uvSet, "uv_set", 0, 1))};
        }
        s.edit([&](Scene& s) { s.setTexture(handle, place, use); });
      },
      argument("material"), argument("slot"), argument("texture"), argument("wrap") = "repeat",
      argument("smooth") = true, argument("uv_set") = 0, nb::sig(signature.c_str()),
      "The texture that the material samples in that slot; None: none. Channels are glTF's: roughness is green, "
      "metalness\nblue. smooth: linear filters and mip levels; else the nearest texel. uv_set: 0 or 1.");
  type.def(
      "texture_of",
      [](const SharedScene& s, nb::handle material, nb::handle slot) -> nb::object {
        const auto handle = handleOf<Material>(material, "material");
        const auto place = enumOf<TextureSlot>(slot, "slot", kSlots);
        const auto use = s.read([&](const Scene& s) { return s.textureOf(handle, place); });
        return use ? nb::cast(use->texture) : nb::none();
      },
      argument("material"), argument("slot"),
      nb::sig("def texture_of(self, material: MaterialHandle, slot: str) -> TextureHandle | None"),
      "The texture that the material samples in that slot.");
}

void defineLights(Class& type) {
  type.def("lights", [](const SharedScene& s) { return s.read([](const Scene& s) { return s.lights(); }); });
  type.def(
      "light",
      [](const SharedScene& s, nb::handle light) {
        const auto handle = handleOf<Light>(light, "light");
        return s.read([&](const Scene& s) { return s.light(handle); });
      },
      argument("light"), nb::sig("def light(self, light: LightHandle) -> Light"), "Its properties, a copy.");
  type.def(
      "set_light",
      [](SharedScene& s, nb::handle light, nb::handle values) {
        const auto handle = handleOf<Light>(light, "light");
        const Light to = objectOf<Light>(values, "values", "a Light");
        s.edit([&](Scene& s) { s.setLight(handle, to); });
      },
      argument("light"), argument("values"), nb::sig("def set_light(self, light: LightHandle, values: Light) -> None"),
      "A light that is moved or turned follows its node no longer.");
  type.def(
      "add_light",
      [](SharedScene& s, nb::handle values, nb::handle node) {
        const Light added = objectOf<Light>(values, "values", "a Light");
        if (node.is_none()) return s.edit([&](Scene& s) { return s.addLight(added); });
        const std::string path = textOf(node, "node");
        return s.edit([&](Scene& s) { return s.addLight(added, path); });
      },
      argument("values"), argument("node") = nb::none(),
      nb::sig("def add_light(self, values: Light, node: str | None = None) -> LightHandle"),
      "node: path of the node that it follows, at the node's origin and along its -Z axis, in place of its own "
      "position and direction");
  type.def(
      "remove_light",
      [](SharedScene& s, nb::handle light) {
        const auto handle = handleOf<Light>(light, "light");
        s.edit([&](Scene& s) { s.removeLight(handle); });
      },
      argument("light"), nb::sig("def remove_light(self, light: LightHandle) -> None"));
}

nb::object meshArrays(const SharedScene& s, nb::handle mesh) {
  const auto handle = handleOf<Mesh>(mesh, "mesh");
  const MeshData data = s.read([&](const Scene& s) { return s.meshData(handle); });
  nb::dict arrays;
  arrays["positions"] = ownedRows(data.positions);
  arrays["indices"] = owned(std::vector(data.indices), {data.indices.size() / 3, 3});
  arrays["normals"] = ownedRows(data.normals);
  if (!data.tangents.empty()) arrays["tangents"] = ownedRows(data.tangents);
  if (!data.uv.empty()) arrays["uv"] = ownedRows(data.uv);
  if (!data.uv1.empty()) arrays["uv1"] = ownedRows(data.uv1);
  if (!data.colors.empty()) arrays["colors"] = ownedRows(data.colors);
  return arrays;
}

#define MESH_PARAMETERS                                                                             \
  "positions: numpy.typing.ArrayLike, indices: numpy.typing.ArrayLike | None = None, "              \
  "normals: numpy.typing.ArrayLike | None = None, tangents: numpy.typing.ArrayLike | None = None, " \
  "uv: numpy.typing.ArrayLike | None = None, uv1: numpy.typing.ArrayLike | None = None, "           \
  "colors: numpy.typing.ArrayLike | None = None, name: str = \"\", "                                \
  "targets: collections.abc.Sequence[collections.abc.Mapping[str, numpy.typing.ArrayLike]] = (), "  \
  "skin: SkinHandle | None = None, joints: numpy.typing.ArrayLike | None = None, "                  \
  "joint_weights: numpy.typing.ArrayLike | None = None"
#define MESH_DOC                                                                                                   \
  "Object space, meters; V vertices and T triangles.\n\npositions: (V, 3)\nindices: (T, 3) whole numbers, fronts " \
  "counter-clockwise; without them each three positions are a triangle\nnormals: (V, 3); without them flat\n"      \
  "tangents: (V, 4), and the bitangent's sign; without them made from uv\nuv, uv1: (V, 2), v down\n"               \
  "colors: (V, 4), linear, 0 to 1; multiply the base color\n"                                                      \
  "targets: morph targets, dicts of positions, normals and tangents, each (V, 3): what they add times a weight;\n" \
  "normals and tangents require those of the mesh\n"                                                               \
  "skin, joints, joint_weights: (V, N) indices into the joints of the skin, and their weights\n\n"                 \
  "Integers are normalized as in glTF: uv and colors of uint8 / 255 and uint16 / 65535, normals and tangents of\n" \
  "int8 / 127 and int16 / 32767."
#define MESH_ARGUMENTS                                                                                                 \
  argument("positions"), argument("indices") = nb::none(), argument("normals") = nb::none(),                           \
                         argument("tangents") = nb::none(), argument("uv") = nb::none(), argument("uv1") = nb::none(), \
                         argument("colors") = nb::none(), argument("name") = "",                                       \
                         argument("targets") = nb::make_tuple(), argument("skin") = nb::none(),                        \
                         argument("joints") = nb::none(), argument("joint_weights") = nb::none()

void defineMeshes(Class& type) {
  type.def("meshes", [](const SharedScene& s) { return s.read([](const Scene& s) { return s.meshes(); }); });
  type.def(
      "mesh",
      [](const SharedScene& s, nb::handle mesh) {
        const auto handle = handleOf<Mesh>(mesh, "mesh");
        return s.read([&](const Scene& s) { return s.mesh(handle); });
      },
      argument("mesh"), nb::sig("def mesh(self, mesh: MeshHandle) -> Mesh"), "Its name, size and bounds.");
  type.def("mesh_arrays", &meshArrays, argument("mesh"),
           nb::sig("def mesh_arrays(self, mesh: MeshHandle) -> dict[str, numpy.ndarray]"),
           "Its arrays at rest, by the names of add_mesh()'s arguments; those that it has, without skin and targets.");
  type.def(
      "add_mesh",
      [](SharedScene& s, nb::handle positions, nb::handle indices, nb::handle normals, nb::handle tangents,
         nb::handle uv, nb::handle uv1, nb::handle colors, nb::handle name, nb::handle targets, nb::handle skin,
         nb::handle joints, nb::handle jointWeights) {
        const MeshData data = meshDataOf(positions, indices, normals, tangents, uv, uv1, colors, name, targets, skin,
                                         joints, jointWeights);
        return s.edit([&](Scene& s) { return s.addMesh(data); });
      },
      MESH_ARGUMENTS, nb::sig("def add_mesh(self, " MESH_PARAMETERS ") -> MeshHandle"), MESH_DOC);
  type.def(
      "set_mesh",
      [](SharedScene& s, nb::handle mesh, nb::handle positions, nb::handle indices, nb::handle normals,
         nb::handle tangents, nb::handle uv, nb::handle uv1, nb::handle colors, nb::handle name, nb::handle targets,
         nb::handle skin, nb::handle joints, nb::handle jointWeights) {
        const auto handle = handleOf<Mesh>(mesh, "mesh");
        const MeshData data = meshDataOf(positions, indices, normals, tangents, uv, uv1, colors, name, targets, skin,
                                         joints, jointWeights);
        s.edit([&](Scene& s) { s.setMesh(handle, data); });
      },
      argument("mesh"), MESH_ARGUMENTS, nb::sig("def set_mesh(self, mesh: MeshHandle, " MESH_PARAMETERS ") -> None"),
      "All instances of the mesh change with it; only the given skin and targets deform it from then on. " MESH_DOC);
  type.def(
      "remove_mesh",
      [](SharedScene& s, nb::handle mesh) {
        const auto handle = handleOf<Mesh>(mesh, "mesh");
        s.edit([&](Scene& s) { s.removeMesh(handle); });
      },
      argument("mesh"), nb::sig("def remove_mesh(self, mesh: MeshHandle) -> None"),
      "Raises UsageError while an instance shows it.");
}

}  // namespace

EnvironmentData environmentOf(nb::handle value) {
  const FloatArray array = floatsOf(value, "environment", {kHeightLength, kWidthLength, 3}, Integers::Rejected);
  EnvironmentData data{static_cast<uint32_t>(array.shape[1]), static_cast<uint32_t>(array.shape[0]), {}};
  data.radiance.resize(size_t{data.width} * data.height);
  if (data.radiance.empty()) badValue("environment must not be empty");
  std::memcpy(data.radiance.data(), array.values.data(), sizeof(float) * array.values.size());
  return data;
}

void bindScene(nb::module_& module) {
  Class type(module, "Scene", nb::is_weak_referenceable(),
             "What is rendered: a file, a built-in scene, or what a program adds. It may be edited between frames.\n\n"
             "Lists are in the scene's order. An invalid edit raises UsageError and changes nothing.");
  defineWhole(type);
  defineCameras(type);
  defineInstances(type);
  defineMaterials(type);
  defineTextures(type);
  defineMaterialTextures(type);
  defineLights(type);
  defineMeshes(type);
  defineAnimation(module, type);
}

}  // namespace latelight::python

#include "worlds.h"

#include <algorithm>
#include <iterator>

#include "cameras.h"
#include "values.h"

namespace latelight::python {

namespace {

enum class Kind { Numbers, Mask, Integers };

// Reads arguments as arrays of worlds, without a copy where possible: arrays in CUDA's memory stay there.
class ArrayReader {
 public:
  ArrayReader(GivenWorlds& to, uintptr_t stream) : to_(to), stream_(stream) {}

  // Reads one or several numbers per world, or per world and element. Returns the shape.
  std::vector<int64_t> read(nb::handle value, const char* name, Kind kind, const std::vector<int64_t>& shape,
                            WorldArray& array) {
    if (value.is_none()) return shape;
    if (isTensor(value)) return tensor(value, name, shape, kind, array);
    if (kind == Kind::Mask) return flags(value, name, shape, array);
    if (kind == Kind::Integers) return indices(value, name, shape, array);
    return numbers(value, name, shape, array);
  }

 private:
  static Kind kindOf(WorldArray::Element element) {
    using enum WorldArray::Element;
    return element == Uint8 ? Kind::Mask : element == Int32 || element == Int64 ? Kind::Integers : Kind::Numbers;
  }
  std::vector<int64_t> numbers(nb::handle value, const char* name, const std::vector<int64_t>& shape,
                               WorldArray& array) {
    const nb::object given = arrayOf(value, name, Elements::Numbers, shape);
    const bool floats = shown(given.attr("dtype")) == "float32";
    array.element = floats ? WorldArray::Element::Float32 : WorldArray::Element::Float64;
    keep(floats ? given : arrayOf(given, name, Elements::Numbers, shape, "float64"), array);
    std::vector<int64_t> lengths;
    for (size_t axis = 0; axis < shape.size(); ++axis) lengths.push_back(static_cast<int64_t>(lengthOf(given, axis)));
    return lengths;
  }
  std::vector<int64_t> flags(nb::handle value, const char* name, const std::vector<int64_t>& shape, WorldArray& array) {
    const nb::object given = anyArrayOf(value, name, shape);
    if (shown(given.attr("dtype")) != "bool")
      badType("{} must be an array of bool, not of {}", name, shown(given.attr("dtype")));
    array.element = WorldArray::Element::Uint8;
    keep(arrayOf(given.attr("astype")("uint8"), name, Elements::Uint8, shape, "uint8"), array);
    return shape;
  }
  std::vector<int64_t> indices(nb::handle value, const char* name, const std::vector<int64_t>& shape,
                               WorldArray& array) {
    array.element = WorldArray::Element::Int64;
    keep(arrayOf(value, name, Elements::Integers, shape, "int64"), array);
    return shape;
  }
  std::vector<int64_t> tensor(nb::handle value, const char* name, const std::vector<int64_t>& shape, Kind kind,
                              WorldArray& array) {
    Tensor given = tensorOf(value, name, stream_);
    const bool fits =
        std::ranges::equal(given.shape, shape, [](int64_t has, int64_t wanted) { return wanted < 0 || has == wanted; });
    if (!fits) badValue("{} must be an array of shape {}, not {}", name, shapeText(shape), shapeText(given.shape));
    constexpr const char* kElements[] = {"float32 or float64", "bool", "int32 or int64"};
    if (kindOf(given.element) != kind) badType("{} must be an array of {}", name, kElements[static_cast<size_t>(kind)]);
    array.element = given.element;
    to_.tensors.push_back({&array, name, std::move(given)});
    return to_.tensors.back().tensor.shape;
  }
  void keep(const nb::object& numpy, WorldArray& array) {
    array.host = nb::cast<nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>>(numpy).data();
    to_.kept.push_back(numpy);
  }

  GivenWorlds& to_;
  uintptr_t stream_;
};

template <typename Element>
std::vector<Handle<Element>> handlesOf(nb::handle value, const char* name, const char* one) {
  std::vector<Handle<Element>> handles;
  if (value.is_none()) return handles;
  for (const nb::handle item : itemsOf(value, name, "a list of handles"))
    handles.push_back(objectOf<Handle<Element>>(item, fmt::format("each of {}", name), one));
  return handles;
}

std::vector<std::optional<Handle<Instance>>> mountsOf(nb::handle value, const char* name) {
  std::vector<std::optional<Handle<Instance>>> mounts;
  if (value.is_none()) return mounts;
  for (const nb::handle item : itemsOf(value, name, "a list of InstanceHandle or None")) {
    auto& mount = mounts.emplace_back();
    if (!item.is_none())
      mount = objectOf<Handle<Instance>>(item, fmt::format("each of {}", name), "an InstanceHandle or None");
  }
  return mounts;
}

constexpr const char* kTensor = "typing.Any | None = None";  // an array, or an array in CUDA's memory

struct WorldArgument {
  const char* name;
  const char* type;
  const char* docs;
};
constexpr WorldArgument kArguments[] = {
    {"instances", "collections.abc.Sequence[InstanceHandle] | None = None",
     "the I instances that the arguments with (N, I) describe; required by them"},
    {"transforms", kTensor, "(N, I, 4, 4) or (N, I, 3, 4): as Scene.set_transform()"},
    {"previous_transforms", kTensor, "the same in the previous frame, for the output motion"},
    {"next_transforms", kTensor, "the same in the next frame"},
    {"exists", kTensor, "(N, I) bool: whether a world has an instance"},
    {"materials", "collections.abc.Sequence[MaterialHandle] | None = None", "those that material_choice refers to"},
    {"material_choice", kTensor, "(N, I) integers: the material of each instance, as an index in `materials`"},
    {"base_color", kTensor, "(N, I, 4): linear Rec.709 and alpha, in place of the material's factor"},
    {"metallic", kTensor, "(N, I), likewise"},
    {"roughness", kTensor, "(N, I), likewise"},
    {"emissive", kTensor, "(N, I, 3), likewise"},
    {"lights", "collections.abc.Sequence[LightHandle] | None = None",
     "the L lights that the next four describe; required by them"},
    {"light_position", kTensor, "(N, L, 3), meters"},
    {"light_direction", kTensor, "(N, L, 3): from the light, of any length above 0"},
    {"light_color", kTensor, "(N, L, 3)"},
    {"light_intensity", kTensor, "(N, L): candela; lux for directional lights, nits for area lights"},
    {"joints", "collections.abc.Sequence[str] | None = None",
     "paths of the J nodes, joints of skins, that joint_transforms describes: Scene.joints()"},
    {"joint_transforms", kTensor,
     "(N, J, 4, 4) or (N, J, 3, 4): from the frame of each joint to the scene file's. The skins' inverse bind matrices "
     "are the scene's"},
    {"previous_joint_transforms", kTensor, "the same in the previous frame"},
    {"next_joint_transforms", kTensor, "the same in the next frame"},
    {"meshes", "collections.abc.Sequence[MeshHandle] | None = None", "those that vertices describes"},
    {"vertices", kTensor,
     "(N, V, 3): positions of all vertices of these meshes, mesh by mesh, in object space and in the order of "
     "Scene.mesh_arrays(). Normals follow the triangles"},
    {"previous_vertices", kTensor, "the same in the previous frame"},
    {"next_vertices", kTensor, "the same in the next frame"},
    {"environment_rotation", kTensor, "(N,) degrees, in place of the option"},
    {"environment_intensity", kTensor, "(N,), in place of the option"},
    {"environments", "collections.abc.Sequence[str | os.PathLike[str]] | None = None",
     "in place of the renderer's environment: .hdr or .exr files, or \"studio\". The renderer filters each once"},
    {"environment_index", kTensor, "(N,) integers: the environment of each world, as an index in `environments`"},
    {"camera_to_world", kTensor, "(N, C, 4, 4) or (N, C, 3, 4): in place of the cameras' own poses"},
    {"previous_camera_to_world", kTensor, "the same in the previous frame"},
    {"next_camera_to_world", kTensor, "the same in the next frame"},
    {"k", kTensor,
     "(N, C, 3, 3): camera matrices for images of this size, in place of the fields of view and of the focal lengths "
     "and principal points of lenses, which keep their model and distortion"},
    {"camera_instances", "collections.abc.Sequence[InstanceHandle | None] | None = None",
     "the instance that each camera rides on; its pose is relative to that instance"},
};

// An argument with one or several numbers per world, or per world and element of a list.
struct ArrayArgument {
  const char* name;
  WorldArray& array;
  std::vector<int64_t> shape;  // of four lengths for matrices
  const char* list = nullptr;  // the argument with the list of elements that it requires, of `elements`
  int64_t elements = 0;
  Kind kind = Kind::Numbers;
  bool isRequiredByList = false;
  nb::object value{};
};

// Returns these arguments, for worlds with their lists and cameras. `v`: the number of vertices of the meshes.
std::vector<ArrayArgument> arrayArguments(Worlds& worlds, int64_t v) {
  const auto count = [](const auto& list) { return static_cast<int64_t>(list.size()); };
  const int64_t n = worlds.count, i = count(worlds.instances), c = count(worlds.cameras), l = count(worlds.lights);
  const int64_t j = count(worlds.joints), m = count(worlds.meshes), p = count(worlds.palette);
  const int64_t e = count(worlds.environments);
  const std::vector<int64_t> ofInstances{n, i, kRowLength, 4}, ofCameras{n, c, kRowLength, 4};
  const std::vector<int64_t> ofJoints{n, j, kRowLength, 4};
  WorldArrays& a = worlds.arrays;
  return {{"transforms", a.transforms, ofInstances, "instances", i},
          {"previous_transforms", a.previousTransforms, ofInstances, "instances", i},
          {"next_transforms", a.nextTransforms, ofInstances, "instances", i},
          {"exists", a.exists, {n, i}, "instances", i, Kind::Mask},
          {"camera_to_world", a.cameraToWorld, ofCameras},
          {"previous_camera_to_world", a.previousCameraToWorld, ofCameras},
          {"next_camera_to_world", a.nextCameraToWorld, ofCameras},
          {"k", a.intrinsics, {n, c, 3, 3}},
          {"base_color", a.baseColor, {n, i, 4}, "instances", i},
          {"metallic", a.metallic, {n, i}, "instances", i},
          {"roughness", a.roughness, {n, i}, "instances", i},
          {"emissive", a.emissive, {n, i, 3}, "instances", i},
          {"light_position", a.lightPosition, {n, l, 3}, "lights", l},
          {"light_direction", a.lightDirection, {n, l, 3}, "lights", l},
          {"light_color", a.lightColor, {n, l, 3}, "lights", l},
          {"light_intensity", a.lightIntensity, {n, l}, "lights", l},
          {"environment_rotation", a.environmentRotation, {n}},
          {"environment_intensity", a.environmentIntensity, {n}},
          {"environment_index", a.environmentIndex, {n}, "environments", e, Kind::Integers, true},
          {"joint_transforms", a.jointTransforms, ofJoints, "joints", j, Kind::Numbers, true},
          {"previous_joint_transforms", a.previousJointTransforms, ofJoints, "joints", j},
          {"next_joint_transforms", a.nextJointTransforms, ofJoints, "joints", j},
          {"vertices", a.vertices, {n, v, 3}, "meshes", m, Kind::Numbers, true},
          {"previous_vertices", a.previousVertices, {n, v, 3}, "meshes", m},
          {"next_vertices", a.nextVertices, {n, v, 3}, "meshes", m},
          {"material_choice", a.materialChoice, {n, i}, "materials", p, Kind::Integers, true}};
}

void readArgument(ArrayReader& reader, const ArrayArgument& argument) {
  const auto& [name, array, shape, list, elements, kind, isRequiredByList, value] = argument;
  if (isRequiredByList && value.is_none() != (elements == 0)) badValue("{} and {} require each other", list, name);
  if (value.is_none()) return;
  if (list && elements == 0) badValue("{} requires the list of {} that it describes: {}", name, list, list);
  const std::vector<int64_t> lengths = reader.read(value, name, kind, shape, array);
  if (lengths.size() < 4) return;
  if (lengths[2] != 3 && lengths[2] != 4) badValue("{} must have matrices of 3 or 4 rows, not of {}", name, lengths[2]);
  array.rows = static_cast<uint32_t>(lengths[2]);
}

}  // namespace

namespace {

// The lists of elements, and the arrays with an axis for these.
struct ListedArrays {
  const char* list;
  std::vector<const char*> arrays;
};

std::vector<ListedArrays> listedArrays() {
  return {{"instances",
           {"transforms", "previous_transforms", "next_transforms", "exists", "material_choice", "base_color",
            "metallic", "roughness", "emissive"}},
          {"lights", {"light_position", "light_direction", "light_color", "light_intensity"}},
          {"joints", {"joint_transforms", "previous_joint_transforms", "next_joint_transforms"}},
          {"meshes", {"vertices", "previous_vertices", "next_vertices"}}};
}

// Removes arrays without elements if the list of their elements is empty, such as those of a scene without instances.
void dropEmptyArrays(int64_t worlds, nb::dict& keywords) {
  const nb::object shapeOf = nb::module_::import_("numpy").attr("shape");
  const auto drop = [&](const char* name) { return nb::object(keywords.attr("pop")(name, nb::none())); };
  for (const auto& [list, arrays] : listedArrays()) {
    const nb::object elements = keywords.attr("get")(list);
    const bool isList = nb::isinstance<nb::list>(elements) || nb::isinstance<nb::tuple>(elements);
    if (!isList || nb::len(elements) > 0) continue;
    for (const char* name : arrays) {
      const nb::object value = drop(name);
      if (value.is_none()) continue;
      const nb::tuple shape(shapeOf(value));
      if (nb::len(shape) < 2 || !shape[0].equal(nb::int_(worlds)) || !shape[1].equal(nb::int_(0)))
        badValue("{} must have the shape ({}, 0, ...), not {}, because {} is empty", name, worlds, shown(shape), list);
      if (std::string_view(name) == "material_choice") drop("materials");
    }
  }
}

}  // namespace

std::unique_ptr<GivenWorlds> worldsOf(nb::handle count, nb::handle cameras, nb::dict& keywords,
                                      const std::function<uintptr_t()>& stream,
                                      const std::function<uint64_t(Handle<Mesh>)>& vertices) {
  auto given = std::make_unique<GivenWorlds>();
  Worlds& worlds = given->worlds;
  worlds.count = static_cast<uint32_t>(integerOf(count, "count", 1, INT32_MAX));
  worlds.cameras = camerasOf(cameras, "cameras");
  if (worlds.cameras.empty()) badValue("cameras must have at least one");
  dropEmptyArrays(worlds.count, keywords);
  const auto take = [&](const char* name) { return nb::object(keywords.attr("pop")(name, nb::none())); };
  worlds.instances = handlesOf<Instance>(take("instances"), "instances", "an InstanceHandle");
  worlds.cameraInstances = mountsOf(take("camera_instances"), "camera_instances");
  worlds.palette = handlesOf<Material>(take("materials"), "materials", "a MaterialHandle");
  worlds.lights = handlesOf<Light>(take("lights"), "lights", "a LightHandle");
  if (const nb::object joints = take("joints"); !joints.is_none()) worlds.joints = textsOf(joints, "joints");
  worlds.meshes = handlesOf<Mesh>(take("meshes"), "meshes", "a MeshHandle");
  if (const nb::object names = take("environments"); !names.is_none())
    worlds.environments = pathsOf(names, "environments");
  int64_t vertexCount = 0;
  for (const Handle<Mesh> mesh : worlds.meshes) vertexCount += static_cast<int64_t>(vertices(mesh));
  std::vector<ArrayArgument> arguments = arrayArguments(worlds, vertexCount);
  for (ArrayArgument& argument : arguments) argument.value = take(argument.name);
  const bool anyTensor =
      std::ranges::any_of(arguments, [](const ArrayArgument& argument) { return isTensor(argument.value); });
  ArrayReader reader(*given, anyTensor ? stream() : 0);
  for (const ArrayArgument& argument : arguments) readArgument(reader, argument);
  return given;
}

void readRays(GivenWorlds& given, nb::handle origins, nb::handle directions, bool perWorld, uintptr_t stream) {
  ArrayReader reader(given, stream);
  const auto read = [&](nb::handle value, const char* name, int64_t rays, WorldArray& array) {
    std::vector<int64_t> shape{rays, 3};
    if (perWorld) shape.insert(shape.begin(), given.worlds.count);
    return static_cast<uint64_t>(reader.read(value, name, Kind::Numbers, shape, array)[perWorld ? 1 : 0]);
  };
  given.rays.count = read(origins, "origins", -1, given.rays.origins);
  read(directions, "directions", static_cast<int64_t>(given.rays.count), given.rays.directions);
  if (given.rays.origins.element != given.rays.directions.element)
    badType("origins and directions must have the same type, float32 or float64");
}

bool isWorldArgument(std::string_view name) {
  return std::ranges::find(kArguments, name, &WorldArgument::name) != std::end(kArguments);
}

std::string worldParameters() {
  std::string text;
  for (const WorldArgument& argument : kArguments) text += fmt::format(", {}: {}", argument.name, argument.type);
  return text;
}

std::string worldDocs() {
  std::string text;
  for (const WorldArgument& argument : kArguments) text += fmt::format("\n{}: {}", argument.name, argument.docs);
  return text;
}

}  // namespace latelight::python

#include "worlds.h"

#include <algorithm>
#include <iterator>

#include "cameras.h"
#include "values.h"

namespace latelight::python {

namespace {

// Reads arguments as arrays of worlds, without a copy where possible: arrays in CUDA's memory stay there.
class ArrayReader {
 public:
  ArrayReader(GivenWorlds& to, uintptr_t stream) : to_(to), stream_(stream) {}

  // Matrices of 3 or 4 rows and 4 columns, one per world and element.
  void transforms(nb::handle value, const char* name, int64_t each, WorldArray& array) {
    if (value.is_none()) return;
    const int64_t n = to_.worlds.count;
    const std::vector<int64_t> shape = read(value, name, {n, each, kRowLength, 4}, array);
    if (shape[2] != 3 && shape[2] != 4) badValue("{} must have matrices of 3 or 4 rows, not of {}", name, shape[2]);
    array.rows = static_cast<uint32_t>(shape[2]);
  }
  void intrinsics(nb::handle value, const char* name, int64_t each, WorldArray& array) {
    if (value.is_none()) return;
    read(value, name, {to_.worlds.count, each, 3, 3}, array);
    array.rows = 3;
  }
  // One or several numbers per world, or per world and element. Returns the shape.
  std::vector<int64_t> numbers(nb::handle value, const char* name, const std::vector<int64_t>& shape,
                               WorldArray& array) {
    return value.is_none() ? shape : read(value, name, shape, array);
  }
  void flags(nb::handle value, const char* name, int64_t each, WorldArray& array) {
    if (value.is_none()) return;
    const std::vector<int64_t> shape{to_.worlds.count, each};
    if (isTensor(value)) return tensor(value, name, shape, Kind::Mask, array), void();
    const nb::object given = anyArrayOf(value, name, shape);
    if (shown(given.attr("dtype")) != "bool")
      badType("{} must be an array of bool, not of {}", name, shown(given.attr("dtype")));
    array.element = WorldArray::Element::Uint8;
    keep(arrayOf(given.attr("astype")("uint8"), name, Elements::Uint8, shape, "uint8"), array);
  }

  void indices(nb::handle value, const char* name, const std::vector<int64_t>& shape, WorldArray& array) {
    if (value.is_none()) return;
    if (isTensor(value)) return tensor(value, name, shape, Kind::Integers, array), void();
    array.element = WorldArray::Element::Int64;
    keep(arrayOf(value, name, Elements::Integers, shape, "int64"), array);
  }

 private:
  enum class Kind { Numbers, Mask, Integers };
  static Kind kindOf(WorldArray::Element element) {
    using enum WorldArray::Element;
    return element == Uint8 ? Kind::Mask : element == Int32 || element == Int64 ? Kind::Integers : Kind::Numbers;
  }
  // Returns the shape.
  std::vector<int64_t> read(nb::handle value, const char* name, const std::vector<int64_t>& shape, WorldArray& array) {
    if (isTensor(value)) return tensor(value, name, shape, Kind::Numbers, array);
    const nb::object given = arrayOf(value, name, Elements::Numbers, shape);
    const bool floats = shown(given.attr("dtype")) == "float32";
    array.element = floats ? WorldArray::Element::Float32 : WorldArray::Element::Float64;
    keep(floats ? given : arrayOf(given, name, Elements::Numbers, shape, "float64"), array);
    std::vector<int64_t> lengths;
    for (size_t axis = 0; axis < shape.size(); ++axis) lengths.push_back(static_cast<int64_t>(lengthOf(given, axis)));
    return lengths;
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

}  // namespace

std::unique_ptr<GivenWorlds> worldsOf(nb::handle count, nb::handle cameras, nb::dict& keywords,
                                      const std::function<uintptr_t()>& stream,
                                      const std::function<uint64_t(Handle<Mesh>)>& vertices) {
  auto given = std::make_unique<GivenWorlds>();
  Worlds& worlds = given->worlds;
  const int64_t n = integerOf(count, "count", 1, INT32_MAX);
  worlds.count = static_cast<uint32_t>(n);
  worlds.cameras = camerasOf(cameras, "cameras");
  if (worlds.cameras.empty()) badValue("cameras must have at least one");
  const auto take = [&](const char* name) { return nb::object(keywords.attr("pop")(name, nb::none())); };
  worlds.instances = handlesOf<Instance>(take("instances"), "instances", "an InstanceHandle");
  worlds.cameraInstances = mountsOf(take("camera_instances"), "camera_instances");
  const auto i = static_cast<int64_t>(worlds.instances.size()), c = static_cast<int64_t>(worlds.cameras.size());
  const std::pair<const char*, WorldArray*> ofInstances[] = {{"transforms", &worlds.arrays.transforms},
                                                             {"previous_transforms", &worlds.arrays.previousTransforms},
                                                             {"next_transforms", &worlds.arrays.nextTransforms},
                                                             {"exists", &worlds.arrays.exists}};
  const std::pair<const char*, WorldArray*> ofCameras[] = {
      {"camera_to_world", &worlds.arrays.cameraToWorld},
      {"previous_camera_to_world", &worlds.arrays.previousCameraToWorld},
      {"next_camera_to_world", &worlds.arrays.nextCameraToWorld},
      {"k", &worlds.arrays.intrinsics}};
  struct Numbers {
    const char* name;
    WorldArray* array;
    std::vector<int64_t> shape;
  };
  const Numbers ofMaterials[] = {{"base_color", &worlds.arrays.baseColor, {n, i, 4}},
                                 {"metallic", &worlds.arrays.metallic, {n, i}},
                                 {"roughness", &worlds.arrays.roughness, {n, i}},
                                 {"emissive", &worlds.arrays.emissive, {n, i, 3}}};
  worlds.palette = handlesOf<Material>(take("materials"), "materials", "a MaterialHandle");
  worlds.lights = handlesOf<Light>(take("lights"), "lights", "a LightHandle");
  const auto l = static_cast<int64_t>(worlds.lights.size());
  const Numbers ofLights[] = {{"light_position", &worlds.arrays.lightPosition, {n, l, 3}},
                              {"light_direction", &worlds.arrays.lightDirection, {n, l, 3}},
                              {"light_color", &worlds.arrays.lightColor, {n, l, 3}},
                              {"light_intensity", &worlds.arrays.lightIntensity, {n, l}}};
  const Numbers ofEnvironment[] = {{"environment_rotation", &worlds.arrays.environmentRotation, {n}},
                                   {"environment_intensity", &worlds.arrays.environmentIntensity, {n}}};
  if (const nb::object joints = take("joints"); !joints.is_none()) worlds.joints = textsOf(joints, "joints");
  const std::pair<const char*, WorldArray*> ofJoints[] = {
      {"joint_transforms", &worlds.arrays.jointTransforms},
      {"previous_joint_transforms", &worlds.arrays.previousJointTransforms},
      {"next_joint_transforms", &worlds.arrays.nextJointTransforms}};
  worlds.meshes = handlesOf<Mesh>(take("meshes"), "meshes", "a MeshHandle");
  int64_t v = 0;
  for (const Handle<Mesh> mesh : worlds.meshes) v += static_cast<int64_t>(vertices(mesh));
  const Numbers ofVertices[] = {{"vertices", &worlds.arrays.vertices, {n, v, 3}},
                                {"previous_vertices", &worlds.arrays.previousVertices, {n, v, 3}},
                                {"next_vertices", &worlds.arrays.nextVertices, {n, v, 3}}};
  std::vector<nb::object> values;
  for (const auto& [name, array] : ofInstances) values.push_back(take(name));
  for (const auto& [name, array] : ofCameras) values.push_back(take(name));
  for (const Numbers& numbers : ofMaterials) values.push_back(take(numbers.name));
  for (const Numbers& numbers : ofLights) values.push_back(take(numbers.name));
  for (const Numbers& numbers : ofEnvironment) values.push_back(take(numbers.name));
  for (const auto& [name, array] : ofJoints) values.push_back(take(name));
  for (const Numbers& numbers : ofVertices) values.push_back(take(numbers.name));
  const nb::object choice = values.emplace_back(take("material_choice"));
  if (choice.is_none() != worlds.palette.empty()) badValue("materials and material_choice require each other");
  if (const nb::object names = take("environments"); !names.is_none())
    worlds.environments = pathsOf(names, "environments");
  const nb::object environment = values.emplace_back(take("environment_index"));
  if (environment.is_none() != worlds.environments.empty())
    badValue("environments and environment_index require each other");
  const bool tensors = std::ranges::any_of(values, [](const nb::object& value) { return isTensor(value); });
  ArrayReader reader(*given, tensors ? stream() : 0);
  size_t next = 0;
  for (const auto& [name, array] : ofInstances) {
    const nb::object value = values[next++];
    if (!value.is_none() && i == 0) badValue("{} requires the list of instances that it describes: instances", name);
    if (array == &worlds.arrays.exists)
      reader.flags(value, name, i, *array);
    else
      reader.transforms(value, name, i, *array);
  }
  for (const auto& [name, array] : ofCameras) {
    if (array == &worlds.arrays.intrinsics)
      reader.intrinsics(values[next++], name, c, *array);
    else
      reader.transforms(values[next++], name, c, *array);
  }
  for (const Numbers& numbers : ofMaterials) {
    if (!values[next].is_none() && i == 0) badValue("factors of materials require the list of instances: instances");
    reader.numbers(values[next++], numbers.name, numbers.shape, *numbers.array);
  }
  for (const Numbers& numbers : ofLights) {
    if (!values[next].is_none() && l == 0)
      badValue("{} requires the list of lights that it describes: lights", numbers.name);
    reader.numbers(values[next++], numbers.name, numbers.shape, *numbers.array);
  }
  for (const Numbers& numbers : ofEnvironment)
    reader.numbers(values[next++], numbers.name, numbers.shape, *numbers.array);
  if (values[next].is_none() != worlds.joints.empty()) badValue("joints and joint_transforms require each other");
  for (const auto& [name, array] : ofJoints) {
    if (!values[next].is_none() && worlds.joints.empty())
      badValue("{} requires the list of joints that it describes: joints", name);
    reader.transforms(values[next++], name, static_cast<int64_t>(worlds.joints.size()), *array);
  }
  if (values[next].is_none() != worlds.meshes.empty()) badValue("meshes and vertices require each other");
  for (const Numbers& numbers : ofVertices) {
    if (!values[next].is_none() && worlds.meshes.empty())
      badValue("{} requires the list of meshes that it describes: meshes", numbers.name);
    reader.numbers(values[next++], numbers.name, numbers.shape, *numbers.array);
  }
  reader.indices(environment, "environment_index", {n}, worlds.arrays.environmentIndex);
  reader.indices(choice, "material_choice", {n, i}, worlds.arrays.materialChoice);
  return given;
}

void readRays(GivenWorlds& given, nb::handle origins, nb::handle directions, bool perWorld, uintptr_t stream) {
  ArrayReader reader(given, stream);
  const auto read = [&](nb::handle value, const char* name, int64_t rays, WorldArray& array) {
    std::vector<int64_t> shape{rays, 3};
    if (perWorld) shape.insert(shape.begin(), given.worlds.count);
    return static_cast<uint64_t>(reader.numbers(value, name, shape, array)[perWorld ? 1 : 0]);
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

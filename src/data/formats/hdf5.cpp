// The format "hdf5": one HDF5 file per frame with the keys, types and conventions of BlenderProc's writer (Denninger et
// al. 2023, "BlenderProc2: A Procedural Pipeline for Photorealistic Rendering"; write_hdf5() of version 2.8).
#include "data/formats/camera_support.h"
#include "data/formats/hdf5_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "base/error.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/geometry.h"
#include "data/formats/known_flow.h"
#include "data/formats/object_numbers.h"
#include "data/formats/options.h"
#include "data/json_text.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;
using output::Aov;

constexpr float kBackgroundDepth = 1e10f;  // Blender's

// The input of every key of a file.
struct KeySource {
  const DataFrame& frame;
  const ObjectNumbers& numbers;

  const output::AovImage& image(Aov aov) const { return imageOf(frame.picture, aov); }
  std::vector<uint64_t> shape(uint64_t channels) const {
    const uint64_t height = frame.picture.height, width = frame.picture.width;
    return channels > 1 ? std::vector{height, width, channels} : std::vector{height, width};
  }
  Hdf5Array floats(const std::vector<float>& values, uint64_t channels) const {
    const auto bytes = std::as_bytes(std::span(values));
    return {Hdf5Type::Float32, shape(channels), {bytes.begin(), bytes.end()}};
  }
  // As in BlenderProc, the type is the smallest that holds `largest`.
  Hdf5Array integers(const std::vector<uint32_t>& values, uint32_t largest) const {
    const uint32_t bytes = bytesForNumbers(largest);
    const Hdf5Type type = bytes == 1 ? Hdf5Type::Uint8 : bytes == 2 ? Hdf5Type::Uint16 : Hdf5Type::Uint32;
    return {type, shape(1), packNumbers(values, bytes)};
  }
};

Hdf5Array colorsOf(const KeySource& source) {
  const std::vector<uint8_t> rgb = rgbOverBlack(source.frame.picture);
  const auto bytes = std::as_bytes(std::span(rgb));
  return {Hdf5Type::Uint8, source.shape(3), {bytes.begin(), bytes.end()}};
}

Hdf5Array rgbaOf(const KeySource& source) {
  const auto bytes = std::as_bytes(std::span(source.frame.picture.display));
  return {Hdf5Type::Uint8, source.shape(4), {bytes.begin(), bytes.end()}};
}

Hdf5Array depthLike(const KeySource& source, Aov aov) {
  std::vector<float> values = source.image(aov).values;
  for (float& value : values)
    if (std::isinf(value)) value = kBackgroundDepth;
  return source.floats(values, 1);
}
Hdf5Array depthOf(const KeySource& source) {
  return depthLike(source, Aov::Depth);
}
Hdf5Array distanceOf(const KeySource& source) {
  return depthLike(source, Aov::Distance);
}

// Normals are in OpenGL's camera frame (X right, Y up, Z towards the camera), from [-1, 1] to [0, 1]; 0.5 is the
// background.
Hdf5Array normalsOf(const KeySource& source) {
  const output::Metadata& metadata = source.frame.metadata;
  glm::dmat3 toCamera(1);
  if (metadata.normalFrame != "opengl") {
    toCamera[1][1] = toCamera[2][2] = -1;
    if (metadata.normalFrame != "opencv") toCamera *= glm::dmat3(openCvFromWorld(metadata.camera));
  }
  std::vector<float> values = source.image(Aov::Normal).values;
  for (size_t i = 0; i < values.size(); i += 3) {
    const glm::dvec3 normal = toCamera * glm::dvec3(values[i], values[i + 1], values[i + 2]);
    for (int axis = 0; axis < 3; ++axis)
      values[i + static_cast<size_t>(axis)] = static_cast<float>(normal[axis] * 0.5 + 0.5);
  }
  return source.floats(values, 3);
}

Hdf5Array diffuseOf(const KeySource& source) {
  return source.floats(source.image(Aov::Albedo).values, 3);
}

// As by BlenderProc's render_nocs(): the fourth channel is 1 on surfaces and 0 elsewhere. The coordinates of a surface
// are never all 0, because the center of an object's box is 0.5 and its diagonal 1.
Hdf5Array nocsOf(const KeySource& source) {
  const std::vector<float>& nocs = source.image(Aov::Nocs).values;
  std::vector<float> values;
  values.reserve(nocs.size() / 3 * 4);
  for (size_t i = 0; i < nocs.size(); i += 3) {
    const bool isSurface = nocs[i] != 0 || nocs[i + 1] != 0 || nocs[i + 2] != 0;
    values.insert(values.end(), {nocs[i], nocs[i + 1], nocs[i + 2], isSurface ? 1.0f : 0.0f});
  }
  return source.floats(values, 4);
}

// Flow in pixels, y down, as by BlenderProc's render_optical_flow().
Hdf5Array forwardFlowOf(const KeySource& source) {
  return source.floats(knownFlow(source.frame, FlowTarget::Next), 2);
}
Hdf5Array backwardFlowOf(const KeySource& source) {
  return source.floats(knownFlow(source.frame, FlowTarget::Previous), 2);
}

Hdf5Array instancesOf(const KeySource& source) {
  return source.integers(source.numbers.instancesOf(source.image(Aov::Id)), source.numbers.instances());
}
Hdf5Array categoriesOf(const KeySource& source) {
  return source.integers(source.numbers.categoriesOf(source.image(Aov::Id)),
                         static_cast<uint32_t>(source.numbers.categories().size()));
}

// A key whose value is an array, and what it requires.
struct Key {
  std::string_view name;
  Aov aov;  // Color: the image for viewing
  Hdf5Array (*array)(const KeySource& source);
};
constexpr Key kKeys[] = {
    {"colors", Aov::Color, colorsOf},
    {"depth", Aov::Depth, depthOf},
    {"distance", Aov::Distance, distanceOf},
    {"normals", Aov::Normal, normalsOf},
    {"diffuse", Aov::Albedo, diffuseOf},
    {"nocs", Aov::Nocs, nocsOf},
    {"instance_segmaps", Aov::Id, instancesOf},
    {"category_id_segmaps", Aov::Id, categoriesOf},
    {"forward_flow", Aov::Motion, forwardFlowOf},
    {"backward_flow", Aov::Motion, backwardFlowOf},
};

const Key* findKey(std::string_view name) {
  const Key* found = std::ranges::find(kKeys, name, &Key::name);
  return found == std::end(kKeys) ? nullptr : found;
}

// The visible objects, as BlenderProc lists them: the background, which is the world, first.
Json attributesOf(const KeySource& source) {
  std::set<uint32_t> visible(source.image(Aov::Id).ids.begin(), source.image(Aov::Id).ids.end());
  std::map<uint32_t, Json> byInstance;
  for (const uint32_t id : visible) {
    const ObjectNumber* object = source.numbers.find(id);
    if (!object) {
      byInstance[0] = {{"idx", 0}, {"category_id", 0}, {"name", "World"}};
      continue;
    }
    Json& entry = byInstance[object->instance] = {
        {"idx", object->instance}, {"category_id", object->category}, {"name", object->node}};
    if (object->category > 0) entry["category"] = source.numbers.categories()[object->category - 1];
  }
  Json all = Json::array();
  for (auto& [instance, entry] : byInstance) all.push_back(std::move(entry));
  return all;
}

// The camera as BlenderProc's CameraStateWriter describes it: OpenCV's pixels, whose centers are whole numbers, and
// OpenGL's camera frame.
Json cameraStateOf(const DataFrame& frame) {
  const output::CameraMetadata& camera = frame.metadata.camera;
  const std::array<double, 9>& k = camera.intrinsics;
  glm::dmat4 pose = glm::inverse(openCvFromWorld(camera));
  pose[1] = -pose[1];
  pose[2] = -pose[2];
  return Json::array({{{"cam_K", {{k[0], k[1], k[2] - 0.5}, {k[3], k[4], k[5] - 0.5}, {0, 0, 1}}},
                       {"cam2world_matrix", output::rowsOf(pose)},
                       {"fov_x", 2 * std::atan(frame.picture.width / (2 * k[0]))},
                       {"fov_y", 2 * std::atan(frame.picture.height / (2 * k[4]))}}});
}

class Hdf5 : public Format {
 public:
  explicit Hdf5(const Json& json) : categories_("hdf5", nullptr) {
    FormatOptions options("hdf5", json);
    readKeys(options.find("keys"));
    categories_ = Categories("hdf5", options.find("categories"));
    alpha_ = options.flag("alpha", false);
    folder_ = options.find("folder") ? options.setFolder("folder", "") + "/" : "";
    options.finish();
    requireHdf5("hdf5");
  }

  std::vector<Aov> needs() const override {
    std::vector<Aov> aovs;
    for (const Key* key : keys_)
      for (const Aov aov : key->aov == Aov::Motion ? flowOutputs() : std::vector{key->aov})
        if (aov != Aov::Color && !output::contains(aovs, aov)) aovs.push_back(aov);
    return aovs;
  }
  bool needsDisplay() const override { return has("colors"); }
  std::vector<FormatFile> files(const DataFrame& frame) const override { return {{fileOf(frame)}}; }

  void check(const DataFrame& frame) const override { requirePinhole("hdf5", frame.metadata.camera); }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    const std::shared_ptr<const ObjectNumbers> numbers = scenes_.of(frame, categories_);
    const KeySource source{frame, *numbers};
    Hdf5File file;
    for (const Key* key : keys_)
      file.add(std::string(key->name), alpha_ && key->aov == Aov::Color ? rgbaOf(source) : key->array(source));
    if (has("instance_segmaps")) file.add("instance_attribute_maps", dumped(attributesOf(source)));
    file.add("campose", dumped(cameraStateOf(frame)));
    writeOf(record, folder, fileOf(frame), file.finish());
  }

 private:
  std::string fileOf(const DataFrame& frame) const { return fmt::format("{}{}.hdf5", folder_, frame.index); }

  void readKeys(const Json* names) {
    const Json list = names ? *names : Json{"colors", "depth", "normals", "instance_segmaps", "category_id_segmaps"};
    if (!list.is_array() || list.empty()) wrongKeys();
    for (const Json& name : list) {
      const Key* key = name.is_string() ? findKey(name.get<std::string>()) : nullptr;
      if (!key) wrongKeys();
      if (std::ranges::find(keys_, key) == keys_.end()) keys_.push_back(key);
    }
  }
  [[noreturn]] static void wrongKeys() {
    std::vector<std::string_view> names;
    for (const Key& key : kKeys) names.push_back(key.name);
    badUsage("keys of the format hdf5 takes a list of these: {}", fmt::format("{}", fmt::join(names, ", ")));
  }
  bool has(std::string_view name) const { return std::ranges::find(keys_, name, &Key::name) != keys_.end(); }

  std::vector<const Key*> keys_;
  Categories categories_;
  bool alpha_ = false;
  std::string folder_;
  mutable NumberedScenes scenes_;
};

}  // namespace

std::unique_ptr<Format> makeHdf5(const Json& options) {
  return std::make_unique<Hdf5>(options);
}

}  // namespace latelight::data

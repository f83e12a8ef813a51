// Converts labels to the classes of latelight.labels.
#include "labels.h"

#include "interpreter.h"
#include "values.h"

namespace latelight::python {

namespace {

// An array with one row per object, of the values that `get` returns for it: a number or a std::array.
template <typename T, typename Get>
nb::object rows(const std::vector<ObjectLabel>& objects, std::vector<size_t> shape, Get get) {
  std::vector<T> values;
  for (const ObjectLabel& object : objects)
    for (const auto value : get(object)) values.push_back(static_cast<T>(value));
  shape.insert(shape.begin(), objects.size());
  return owned(std::move(values), shape);
}

template <typename Get>
nb::object numbers(const std::vector<ObjectLabel>& objects, Get get) {
  return rows<int64_t>(objects, {}, [&](const ObjectLabel& o) { return std::array{get(o)}; });
}

template <typename Get>
nb::object boxes(const std::vector<ObjectLabel>& objects, Get get) {
  return rows<int64_t>(objects, {4}, [&](const ObjectLabel& o) {
    const PixelBox& box = get(o);
    return std::array{box.x, box.y, box.width, box.height};
  });
}

// Bytes that are 0 or 1, as an array of bool.
nb::object flags(std::vector<uint8_t>&& bytes, const std::vector<size_t>& shape) {
  return owned(std::move(bytes), shape).attr("view")("bool");
}

nb::object masks(std::vector<ObjectLabel>& objects, std::vector<uint8_t> ObjectLabel::*mask, size_t height,
                 size_t width) {
  std::vector<uint8_t> bytes;
  bytes.reserve(objects.size() * height * width);
  for (ObjectLabel& object : objects) {
    bytes.insert(bytes.end(), (object.*mask).begin(), (object.*mask).end());
    (object.*mask) = {};
  }
  return flags(std::move(bytes), {objects.size(), height, width});
}

nb::object made(const char* type, const nb::dict& fields) {
  return nb::module_::import_("latelight.labels").attr(type)(**fields);
}

}  // namespace

nb::object labelsOf(Labels&& labels) {
  const RunningPython section;
  std::vector<ObjectLabel>& objects = labels.objects;
  const size_t count = objects.size(), width = labels.width, height = labels.height;
  nb::dict fields;
  nb::list nodes;
  for (const ObjectLabel& object : objects) nodes.append(object.node);
  fields["ids"] = rows<uint32_t>(objects, {}, [](const ObjectLabel& o) { return std::array{o.id}; });
  fields["nodes"] = nodes;
  fields["id_image"] = owned(std::move(labels.ids), {height, width});
  fields["visible_pixels"] = numbers(objects, [](const ObjectLabel& o) { return o.visiblePixels; });
  fields["amodal_pixels"] = numbers(objects, [](const ObjectLabel& o) { return o.amodalPixels; });
  fields["full_pixels"] = numbers(objects, [](const ObjectLabel& o) { return o.fullPixels; });
  fields["visible_share"] = rows<double>(objects, {}, [](const ObjectLabel& o) { return std::array{o.visibleShare}; });
  fields["visible_boxes"] = boxes(objects, [](const ObjectLabel& o) { return o.visibleBox; });
  fields["amodal_boxes"] = boxes(objects, [](const ObjectLabel& o) { return o.amodalBox; });
  fields["full_boxes"] = boxes(objects, [](const ObjectLabel& o) { return o.fullBox; });
  fields["object_to_world"] = rows<double>(objects, {4, 4}, [](const ObjectLabel& o) { return o.objectToWorld; });
  fields["object_to_camera"] = rows<double>(objects, {4, 4}, [](const ObjectLabel& o) { return o.objectToCamera; });
  fields["box_min"] = rows<double>(objects, {3}, [](const ObjectLabel& o) { return o.boxMin; });
  fields["box_max"] = rows<double>(objects, {3}, [](const ObjectLabel& o) { return o.boxMax; });
  fields["box_corners"] = rows<double>(objects, {8, 3}, [](const ObjectLabel& o) {
    std::array<double, 24> values{};
    for (size_t i = 0; i < values.size(); ++i) values[i] = o.corners[i / 3][i % 3];
    return values;
  });
  std::vector<int64_t> occlusions(labels.occlusions.begin(), labels.occlusions.end());
  fields["occlusions"] = owned(std::move(occlusions), {count, count});
  fields["visible_masks"] = masks(objects, &ObjectLabel::visibleMask, height, width);
  fields["amodal_masks"] = masks(objects, &ObjectLabel::amodalMask, height, width);
  return made("Labels", fields);
}

std::vector<Keypoint> keypointsOf(nb::handle value, std::string_view name) {
  const nb::object type = nb::module_::import_("latelight.labels").attr("Keypoint");
  std::vector<Keypoint> keypoints;
  for (const nb::handle item : itemsOf(value, name, "a list of Keypoint or of paths of nodes")) {
    Keypoint keypoint;
    if (PyUnicode_Check(item.ptr())) {
      keypoint.node = keypoint.name = textOf(item, name);
    } else if (nb::isinstance(item, type)) {
      keypoint.node = textOf(item.attr("node"), "node");
      keypoint.name = textOf(item.attr("name"), "name");
      keypoint.thickness = numberOf(item.attr("thickness"), "thickness");
      const nb::object position = arrayOf(item.attr("position"), "position", Elements::Numbers, {3}, "float64");
      std::memcpy(keypoint.position.data(), viewOf<double>(position).data(), sizeof(keypoint.position));
      if (keypoint.name.empty()) keypoint.name = keypoint.node;
    } else {
      badType("{} must be a list of Keypoint or of paths of nodes, and one of its items is {}", name, typeName(item));
    }
    keypoints.push_back(std::move(keypoint));
  }
  return keypoints;
}

nb::object keypointLabelsOf(const std::vector<Keypoint>& keypoints, const std::vector<KeypointLabel>& labels) {
  const RunningPython section;
  nb::list names;
  std::vector<double> positions, pixels, depth;
  std::vector<uint32_t> visibility;
  for (size_t i = 0; i < labels.size(); ++i) {
    names.append(keypoints[i].name);
    positions.insert(positions.end(), labels[i].position.begin(), labels[i].position.end());
    pixels.insert(pixels.end(), labels[i].pixel.begin(), labels[i].pixel.end());
    depth.push_back(labels[i].depth);
    visibility.push_back(labels[i].visibility);
  }
  nb::dict fields;
  fields["names"] = names;
  fields["positions"] = owned(std::move(positions), {labels.size(), 3});
  fields["pixels"] = owned(std::move(pixels), {labels.size(), 2});
  fields["depth"] = owned(std::move(depth), {labels.size()});
  fields["visibility"] = owned(std::move(visibility), {labels.size()});
  return made("Keypoints", fields);
}

nb::object correspondenceOf(Correspondence&& c) {
  const RunningPython section;
  const size_t width = c.width, height = c.height;
  const auto shaped = [&](const nb::object& rows, size_t channels) {
    return rows.attr("reshape")(nb::make_tuple(height, width, channels));
  };
  nb::dict fields;
  fields["pixels"] = shaped(ownedRows(c.pixels), 2);
  fields["flow"] = shaped(ownedRows(c.flow), 3);
  fields["depth"] = owned(std::move(c.depth), {height, width});
  fields["visible"] = flags(std::move(c.visible), {height, width});
  return made("Correspondence", fields);
}

nb::object worldLabelsOf(std::vector<Labels>&& labels, size_t cameras) {
  const RunningPython section;
  nb::list views;
  for (Labels& each : labels) views.append(labelsOf(std::move(each)));
  return nb::module_::import_("latelight.labels").attr("_world_labels")(views, cameras);
}

nb::object worldCorrespondenceOf(std::vector<Correspondence>&& correspondences, size_t cameras) {
  const RunningPython section;
  nb::list views;
  for (Correspondence& each : correspondences) views.append(correspondenceOf(std::move(each)));
  return nb::module_::import_("latelight.labels").attr("_world_correspondence")(views, cameras);
}

nb::object worldKeypointLabelsOf(const std::vector<Keypoint>& keypoints,
                                 const std::vector<std::vector<KeypointLabel>>& labels, size_t cameras) {
  const RunningPython section;
  nb::list views;
  for (const std::vector<KeypointLabel>& each : labels) views.append(keypointLabelsOf(keypoints, each));
  return nb::module_::import_("latelight.labels").attr("_world_keypoints")(views, cameras);
}

}  // namespace latelight::python

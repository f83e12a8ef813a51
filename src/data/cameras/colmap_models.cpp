// Converts between COLMAP's camera models and lenses.
#include <algorithm>

#include "base/error.h"
#include "data/cameras/colmap.h"

namespace latelight::data {

using scene::Lens, scene::LensModel;

namespace {

// The meaning of a model's parameters, one letter per parameter. f: both focal lengths; x, y: one focal length; u, v:
// the principal point; a digit: the distortion term with this index; w, h: the picture's size, repeated. Empty if a
// scene::Lens can't represent the model.
struct ModelLayout {
  ColmapModel model;
  LensModel lens;
  std::string_view parameters;
};
constexpr ModelLayout kModels[] = {
    {{0, "SIMPLE_PINHOLE", 3}, LensModel::Pinhole, "fuv"},
    {{1, "PINHOLE", 4}, LensModel::Pinhole, "xyuv"},
    {{2, "SIMPLE_RADIAL", 4}, LensModel::OpenCv, "fuv0"},
    {{3, "RADIAL", 5}, LensModel::OpenCv, "fuv01"},
    {{4, "OPENCV", 8}, LensModel::OpenCv, "xyuv0123"},
    {{5, "OPENCV_FISHEYE", 8}, LensModel::Fisheye, "xyuv0123"},
    {{6, "FULL_OPENCV", 12}, LensModel::OpenCv, "xyuv01234567"},
    {{7, "FOV", 5}, LensModel::Pinhole, ""},
    {{8, "SIMPLE_RADIAL_FISHEYE", 4}, LensModel::Fisheye, "fuv0"},
    {{9, "RADIAL_FISHEYE", 5}, LensModel::Fisheye, "fuv01"},
    {{10, "THIN_PRISM_FISHEYE", 12}, LensModel::Pinhole, ""},
    {{11, "RAD_TAN_THIN_PRISM_FISHEYE", 16}, LensModel::Pinhole, ""},
    {{12, "SIMPLE_DIVISION", 4}, LensModel::Pinhole, ""},
    {{13, "DIVISION", 5}, LensModel::Pinhole, ""},
    // The equidistant projection without distortion: OPENCV_FISHEYE with all terms 0.
    {{14, "SIMPLE_FISHEYE", 3}, LensModel::Fisheye, "fuv"},
    {{15, "FISHEYE", 4}, LensModel::Fisheye, "xyuv"},
    {{16, "EUCM", 6}, LensModel::Pinhole, ""},
    {{17, "EQUIRECTANGULAR", 2}, LensModel::Equirectangular, "wh"},
};

const ModelLayout& layoutOf(const ColmapModel& model) {
  return *std::ranges::find(kModels, model.id, [](const ModelLayout& layout) { return layout.model.id; });
}

// Calls visit(index, part) for each parameter and each member of the lens that it sets.
template <typename L, typename Visit>
void visitParameters(std::string_view layout, L& lens, const Visit& visit) {
  for (size_t i = 0; i < layout.size(); ++i) {
    const char part = layout[i];
    if (part == 'f' || part == 'x') visit(i, lens.fx);
    if (part == 'f' || part == 'y') visit(i, lens.fy);
    if (part == 'u') visit(i, lens.cx);
    if (part == 'v') visit(i, lens.cy);
    if (part == 'w') visit(i, lens.width);
    if (part == 'h') visit(i, lens.height);
    if (part >= '0' && part <= '7') visit(i, lens.distortion[static_cast<size_t>(part - '0')]);
  }
}

}  // namespace

const ColmapModel* findColmapModel(int id) {
  for (const ModelLayout& layout : kModels)
    if (layout.model.id == id) return &layout.model;
  return nullptr;
}
const ColmapModel* findColmapModel(std::string_view name) {
  for (const ModelLayout& layout : kModels)
    if (layout.model.name == name) return &layout.model;
  return nullptr;
}

Lens lensOfColmap(const ColmapModel& model, double width, double height, std::span<const double> parameters,
                  const std::string& where) {
  const ModelLayout& layout = layoutOf(model);
  if (layout.parameters.empty())
    badInput("{} is of COLMAP's model {}, which is not supported: undistort its pictures with COLMAP", where,
             model.name);
  Lens lens{.model = layout.lens, .width = width, .height = height};
  visitParameters(layout.parameters, lens, [&](size_t i, double& part) { part = parameters[i]; });
  if (lens.width != width || lens.height != height)
    badInput("{} has the parameters {} {}, which must be the size of its pictures, {} {}", where, lens.width,
             lens.height, width, height);
  checkLens(lens, where);
  return lens;
}

ColmapCamera colmapCameraOf(const CalibratedCamera& camera) {
  const auto writable = [](LensModel model) {
    return model == LensModel::Pinhole || model == LensModel::OpenCv || model == LensModel::Fisheye;
  };
  if (!camera.lens || !writable(camera.lens->model))
    badUsage("COLMAP's files cannot express the camera \"{}\": they require a pinhole, OpenCV or fisheye lens",
             camera.name);
  const auto& d = camera.lens->distortion;
  const bool full = std::any_of(d.begin() + 4, d.end(), [](double term) { return term != 0; });
  const char* name = camera.lens->model == LensModel::Pinhole   ? "PINHOLE"
                     : camera.lens->model == LensModel::Fisheye ? "OPENCV_FISHEYE"
                     : full                                     ? "FULL_OPENCV"
                                                                : "OPENCV";
  const ColmapModel* model = findColmapModel(std::string_view(name));
  ColmapCamera written{model, std::vector<double>(model->parameters)};
  visitParameters(layoutOf(*model).parameters, *camera.lens,
                  [&](size_t i, const double& part) { written.parameters[i] = part; });
  return written;
}

ColmapPose colmapPoseOf(const glm::dmat4& pose) {
  const glm::dmat4 toCamera = inverseOf(pose);
  return {quaternionOf(glm::dmat3(toCamera)), glm::dvec3(toCamera[3])};
}

glm::dmat4 poseOfColmap(const ColmapPose& pose, const std::string& where) {
  glm::dmat4 toCamera(rotationOf(pose.rotation));
  toCamera[3] = glm::dvec4(pose.translation, 1);
  glm::dmat4 toWorld = inverseOf(toCamera);
  if (!makeRigid(toWorld)) badInput("{} has a pose that is not a rotation and translation", where);
  return toWorld;
}

ColmapFeatures featuresOf(size_t images, std::span<const ColmapPoint> points) {
  ColmapFeatures features{std::vector<std::vector<ColmapFeature>>(images), {}};
  for (size_t point = 0; point < points.size(); ++point) {
    std::vector<uint32_t>& numbers = features.ofPoint.emplace_back();
    for (const ColmapObservation& seen : points[point].track) {
      std::vector<ColmapFeature>& image = features.ofImage.at(seen.image);
      numbers.push_back(static_cast<uint32_t>(image.size()));
      image.push_back({seen.pixel, point});
    }
  }
  return features;
}

ColmapLenses differentLenses(std::span<const CalibratedCamera> cameras) {
  ColmapLenses lenses;
  for (const CalibratedCamera& camera : cameras) {
    colmapCameraOf(camera);  // throws if the camera cannot be written
    const auto known = std::ranges::find_if(
        lenses.cameras, [&](const CalibratedCamera* other) { return *other->lens == *camera.lens; });
    lenses.lensOf.push_back(static_cast<uint32_t>(known - lenses.cameras.begin()));
    if (known == lenses.cameras.end()) lenses.cameras.push_back(&camera);
  }
  return lenses;
}

}  // namespace latelight::data

// Binds the class Camera and its factory functions.
#include <cmath>
#include <limits>
#include <numbers>

#include "bindings.h"
#include "cameras.h"
#include "fields.h"

namespace latelight::python {

namespace {

using Vector = std::array<double, 3>;

constexpr double kDegrees = 180 / std::numbers::pi;

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector unit(const Vector& v, const char* what) {
  const double length = std::hypot(v[0], v[1], v[2]);
  if (!(length > 1e-12)) badValue("{}", what);
  return {v[0] / length, v[1] / length, v[2] / length};
}

Camera lookAt(nb::handle eye, nb::handle target, nb::handle up, nb::handle verticalFov) {
  const Vector from = numbersOf<double, 3>(eye, "eye"), to = numbersOf<double, 3>(target, "target");
  const Vector forward =
      unit({to[0] - from[0], to[1] - from[1], to[2] - from[2]}, "eye and target must be different points");
  const Vector right = unit(cross(forward, unit(numbersOf<double, 3>(up, "up"), "up must have a length")),
                            "up must not lie along the view");
  const Vector down = cross(forward, right);
  Camera camera;
  camera.verticalFov = floatOf(verticalFov, "vertical_fov");
  for (size_t row = 0; row < 3; ++row) {
    camera.cameraToWorld[4 * row] = right[row];
    camera.cameraToWorld[4 * row + 1] = down[row];
    camera.cameraToWorld[4 * row + 2] = forward[row];
    camera.cameraToWorld[4 * row + 3] = from[row];
  }
  return camera;
}

// Converts to OpenCV's axes. OpenGL's camera looks along -Z with Y up.
std::array<double, 16> openCvPose(nb::handle pose, const std::string& frame) {
  std::array<double, 16> matrix = matrixOf<4, 4>(pose, "camera_to_world");
  if (frame != "opencv" && frame != "opengl") badValue("frame must be \"opencv\" or \"opengl\", not \"{}\"", frame);
  if (frame == "opengl")
    for (size_t row = 0; row < 4; ++row)
      for (const size_t column : {1, 2}) matrix[4 * row + column] *= -1;
  return matrix;
}

struct Pixels {
  double width, height;
};
Pixels sizeOf(nb::handle size) {
  const auto [width, height] = numbersOf<double, 2>(size, "size");
  if (!(width > 0 && height > 0)) badValue("size must be a width and a height above 0, not {} and {}", width, height);
  return {width, height};
}

Camera fromK(nb::handle k, nb::handle pose, nb::handle size, nb::handle frame) {
  const std::array<double, 9> m = matrixOf<3, 3>(k, "k");
  const auto [width, height] = sizeOf(size);
  const double fx = m[0], fy = m[4], cx = m[2], cy = m[5];
  if (!(fx > 0 && fy > 0)) badValue("k must have focal lengths above 0, not {} and {}", fx, fy);
  if (m[1] != 0 || m[3] != 0) badValue("k must have no skew, and has {} and {}", m[1], m[3]);
  if (m[6] != 0 || m[7] != 0 || m[8] != 1) badValue("k must have the last row 0 0 1");
  Camera camera;
  camera.cameraToWorld = openCvPose(pose, textOf(frame, "frame"));
  camera.verticalFov = static_cast<float>(2 * std::atan(height / (2 * fy)) * kDegrees);
  camera.principalX = static_cast<float>(2 * cx / width - 1);
  camera.principalY = static_cast<float>(1 - 2 * cy / height);
  if (fx != fy) camera.lens = Lens{.width = width, .height = height, .fx = fx, .fy = fy, .cx = cx, .cy = cy};
  return camera;
}

constexpr std::array<std::pair<const char*, LensModel>, 6> kLensModels{{{"pinhole", LensModel::Pinhole},
                                                                        {"opencv", LensModel::OpenCv},
                                                                        {"fisheye", LensModel::Fisheye},
                                                                        {"equirectangular", LensModel::Equirectangular},
                                                                        {"cubemap", LensModel::CubeMap},
                                                                        {"ftheta", LensModel::FTheta}}};

const char* nameOf(LensModel model) {
  return kLensModels[static_cast<size_t>(model)].first;
}

nb::object kOf(const Camera& camera, nb::handle size) {
  const auto [width, height] = sizeOf(size);
  std::vector<double> k{1, 0, (camera.principalX + 1.0) * width / 2, 0, 1, (1.0 - camera.principalY) * height / 2, 0,
                        0, 1};
  if (camera.lens) {
    const LensModel model = camera.lens->model;
    if (model == LensModel::Equirectangular || model == LensModel::CubeMap)
      badValue("a camera with a lens of the model {} has no matrix K", nameOf(model));
    if (!(camera.lens->width > 0 && camera.lens->height > 0))
      badValue("a camera with a lens of the model {} has no matrix K without the lens's width and height",
               nameOf(model));
    const double sx = width / camera.lens->width, sy = height / camera.lens->height;
    k = {camera.lens->fx * sx, 0, camera.lens->cx * sx, 0, camera.lens->fy * sy, camera.lens->cy * sy, 0, 0, 1};
  } else {
    const double half = camera.orthographic ? camera.halfHeight : std::tan(camera.verticalFov / kDegrees / 2);
    const double scale = camera.aspect ? std::max(1.0, *camera.aspect * height / width) : 1.0;  // shows the full frame
    k[0] = k[4] = height / (2 * half * scale);
  }
  return owned(std::move(k), {3, 3});
}

void setModel(Lens& lens, nb::handle value, const char* name) {
  const std::string text = textOf(value, name);
  std::string names;
  for (const auto& [known, model] : kLensModels) {
    if (text == known) {
      lens.model = model;
      return;
    }
    names += (names.empty() ? "" : ", ") + std::string(known);
  }
  badValue("{} must be one of {}, not \"{}\"", name, names, text);
}

void setDistortion(Lens& lens, nb::handle value, const char* name) {
  const std::vector<double> numbers = doublesOf(value, name, {-1});
  if (numbers.size() > lens.distortion.size()) badValue("{} takes at most 8 numbers, not {}", name, numbers.size());
  lens.distortion = {};
  std::ranges::copy(numbers, lens.distortion.begin());
}

void bindLens(nb::module_& module) {
  Fields<Lens>(module, "Lens",
               "How a camera maps directions to pixels, where a field of view and a principal point do not say it.\n\n"
               "Calibrated for pictures of width x height pixels; one of another size is the same picture, scaled.")
      .field(
          "model", "str", "pinhole, opencv, fisheye, ftheta, equirectangular or cubemap",
          [](const Lens& lens) { return nb::str(nameOf(lens.model)); }, setModel)
      .number("width", &Lens::width, "pixels")
      .number("height", &Lens::height, "pixels")
      .number("fx", &Lens::fx, "focal length, pixels")
      .number("fy", &Lens::fy, "focal length, pixels")
      .number("cx", &Lens::cx, "principal point, pixels; centered: width / 2")
      .number("cy", &Lens::cy, "principal point, pixels; centered: height / 2")
      .field(
          "distortion", "tuple[float, ...]", "opencv: k1 k2 p1 p2 k3 k4 k5 k6; fisheye: k1 k2 k3 k4; ftheta: k0 to k5",
          [](const Lens& lens) { return tupleOf(lens.distortion); }, setDistortion)
      .done();
}

}  // namespace

std::vector<Camera> camerasOf(nb::handle value, std::string_view name) {
  const Camera* one = nullptr;
  if (nb::try_cast<const Camera*>(value, one, false) && one) return {*one};
  std::vector<Camera> cameras;
  for (const nb::handle item : itemsOf(value, name, "a Camera or a list of them"))
    cameras.push_back(objectOf<Camera>(item, fmt::format("each of {}", name), "a Camera"));
  return cameras;
}

void bindCamera(nb::module_& module) {
  bindLens(module);
  Fields<Camera>(
      module, "Camera",
      "Where a picture is taken from, and how.\n\n"
      "Poses are in the scene file's own frame (glTF: right-handed, Y up), lengths in meters, angles in degrees.")
      .text("name", &Camera::name, "")
      .field(
          "camera_to_world", "numpy.ndarray",
          "(4, 4) float64: OpenCV's camera frame (X right, Y down, Z forward) to the scene file's frame",
          [](const Camera& camera) { return matrix(camera.cameraToWorld); },
          [](Camera& camera, nb::handle value, const char* name) {
            camera.cameraToWorld = matrixOf<4, 4>(value, name);
          })
      .flag("orthographic", &Camera::orthographic, "without perspective; half_height says how much it shows")
      .number("vertical_fov", &Camera::verticalFov, "degrees, full angle")
      .number("half_height", &Camera::halfHeight, "meters; of orthographic cameras")
      .field(
          "aspect", "float | None",
          "width / height of the camera's own frame, which pictures of any shape show whole; None: they keep the "
          "vertical extent",
          [](const Camera& camera) -> nb::object { return camera.aspect ? nb::cast(*camera.aspect) : nb::none(); },
          [](Camera& camera, nb::handle value, const char* name) {
            camera.aspect = value.is_none() ? std::nullopt : std::optional(floatOf(value, name));
          })
      .number("near_clip", &Camera::nearClip, "meters; however near it is, depth keeps its precision")
      .number("far_clip", &Camera::farClip, "meters; infinite")
      .number("principal_x", &Camera::principalX, "offset of the principal point to the right, in half widths")
      .number("principal_y", &Camera::principalY, "offset of the principal point upwards, in half heights")
      .field(
          "lens", "Lens | None", "instead of the field of view and the principal point",
          [](const Camera& camera) { return camera.lens ? nb::cast(*camera.lens) : nb::none(); },
          [](Camera& camera, nb::handle value, const char* name) {
            if (value.is_none())
              camera.lens.reset();
            else
              camera.lens = objectOf<Lens>(value, name, "a Lens or None");
          })
      .text("aperture", &Camera::aperture,
            "\"pinhole\", an f-number as in \"f/2.8\", or the radius in meters; empty: the option of this name")
      .field(
          "focus_distance", "float | None", "meters to the plane in focus; None: the option of this name",
          [](const Camera& camera) -> nb::object {
            return camera.focusDistance ? nb::cast(*camera.focusDistance) : nb::none();
          },
          [](Camera& camera, nb::handle value, const char* name) {
            camera.focusDistance = value.is_none() ? std::nullopt : std::optional(numberOf(value, name));
          })
      .field(
          "shutter", "float | None", "exposure time, seconds; None: the option of this name",
          [](const Camera& camera) -> nb::object { return camera.shutter ? nb::cast(*camera.shutter) : nb::none(); },
          [](Camera& camera, nb::handle value, const char* name) {
            camera.shutter = value.is_none() ? std::nullopt : std::optional(numberOf(value, name));
          })
      .field(
          "readout", "float | None", "seconds from the first row to the last; None: the option of this name",
          [](const Camera& camera) -> nb::object { return camera.readout ? nb::cast(*camera.readout) : nb::none(); },
          [](Camera& camera, nb::handle value, const char* name) {
            camera.readout = value.is_none() ? std::nullopt : std::optional(numberOf(value, name));
          })
      .field(
          "exposure", "float | None", "EV; None: the option of this name. If that is metered, its compensation",
          [](const Camera& camera) -> nb::object { return camera.exposure ? nb::cast(*camera.exposure) : nb::none(); },
          [](Camera& camera, nb::handle value, const char* name) {
            camera.exposure = value.is_none() ? std::nullopt : std::optional(numberOf(value, name));
          })
      .field(
          "noise_seed", "int", "cameras with different seeds have different noise",
          [](const Camera& camera) { return nb::int_(camera.noiseSeed); },
          [](Camera& camera, nb::handle value, const char* name) {
            camera.noiseSeed = static_cast<uint32_t>(integerOf(value, name, 0, std::numeric_limits<uint32_t>::max()));
          })
      .done()
      .def_static("look_at", &lookAt, argument("eye"), argument("target"), argument("up") = nb::make_tuple(0, 1, 0),
                  argument("vertical_fov") = 40.0,
                  nb::sig("def look_at(eye: numpy.typing.ArrayLike, target: numpy.typing.ArrayLike, "
                          "up: numpy.typing.ArrayLike = (0, 1, 0), vertical_fov: float = 40) -> Camera"),
                  "A camera at `eye` that looks at `target`, both (3,), meters.")
      .def_static(
          "from_k", &fromK, argument("k"), argument("camera_to_world"), argument("size"), argument("frame") = "opencv",
          nb::sig("def from_k(k: numpy.typing.ArrayLike, camera_to_world: numpy.typing.ArrayLike, "
                  "size: tuple[int, int], frame: typing.Literal[\"opencv\", \"opengl\"] = \"opencv\") -> Camera"),
          "A pinhole camera by its matrix K (3, 3), calibrated for pictures of `size` (width, height), and its "
          "pose (4, 4).\n\nPixel centers are at half-integers. `frame` is that of the camera: OpenCV's (X "
          "right, Y down, Z forward)\nor OpenGL's (X right, Y up, Z backward).")
      .def("k", &kOf, argument("size"), nb::sig("def k(self, size: tuple[int, int]) -> numpy.ndarray"),
           "The matrix K (3, 3) for pictures of `size` (width, height): camera to pixel coordinates, before "
           "distortion.\n\n"
           "Raises UsageError for lenses of the models equirectangular and cubemap, which have none.");
}

}  // namespace latelight::python

#include "render/surface_coordinates/surface_coordinates.h"

#include <algorithm>
#include <array>

#include "render/surface_coordinates/surface_coordinates_push.h"

namespace latelight::render {

namespace {

uint32_t coordinateNamed(std::string_view name) {
  constexpr std::array<std::string_view, 7> kNames{"object-position", "nocs",       "barycentric", "tangent",
                                                   "bitangent",       "scene-flow", "curvature"};
  return static_cast<uint32_t>(std::ranges::find(kNames, name) - kNames.begin());  // kCoordinate*
}

}  // namespace

graph::ImageId addSurfaceCoordinate(const FrameContext& f, graph::ImageId triangles, std::string_view name) {
  if (name == "triangles") return triangles;
  const graph::ImageId coordinates = createTarget(f, VK_FORMAT_R32G32B32A32_SFLOAT, std::string(name));
  addCompute(f,
             {.stage = graph::Stage::Geometry,
              .name = "surface coordinates",
              .shader = "surface_coordinates.comp",
              .bindings = Bindings(f.device).sampled(triangles).storage(coordinates, graph::Use::StorageWrite),
              .size = f.pixels(),
              .constants = {{kLensConstant, f.setup.lens ? 1u : 0u}}},
             shared::SurfaceCoordinatesPush{
                 .frame = f.constants, .objectFrames = f.scene.objectFrames(), .coordinate = coordinateNamed(name)});
  return coordinates;
}

}  // namespace latelight::render

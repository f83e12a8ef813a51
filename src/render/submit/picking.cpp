#include "render/submit/picking.h"

#include <algorithm>

#include "base/error.h"

namespace latelight::render {

namespace {

using output::Aov;

struct DataAt {
  const output::FrameOutput& frame;
  size_t pixel;

  const output::AovImage& image(Aov aov) const {
    return *std::find_if(frame.aovs.begin(), frame.aovs.end(), [&](const auto& image) { return image.aov == aov; });
  }
  uint32_t id(Aov aov) const { return image(aov).ids[pixel]; }
  float scalar(Aov aov) const { return image(aov).values[pixel]; }
  glm::vec2 two(Aov aov) const { return {image(aov).values[2 * pixel], image(aov).values[2 * pixel + 1]}; }
  glm::vec3 three(Aov aov) const {
    const std::vector<float>& values = image(aov).values;
    return {values[3 * pixel], values[3 * pixel + 1], values[3 * pixel + 2]};
  }
};

Picked describe(const scene::Scene& scene, const DataAt& data) {
  Picked p;
  p.id = data.id(Aov::Id);
  if (p.id == 0) return p;
  p.part = data.id(Aov::Part);
  const auto found = std::find_if(scene.instances.begin(), scene.instances.end(),
                                  [&](const scene::Instance& i) { return i.part == p.part && !i.removed; });
  if (found == scene.instances.end()) fail(ExitCode::Internal, "No instance of the scene is the part {}.", p.part);
  p.node = scene.nodes[found->node].path;
  p.mesh = scene.nodes[found->node].mesh;
  p.primitive = found->primitive;
  p.material = scene.materials[found->material].name;
  p.position = data.three(Aov::Position);
  p.normal = data.three(Aov::Normal);
  p.geonormal = data.three(Aov::GeoNormal);
  p.depth = data.scalar(Aov::Depth);
  p.distance = data.scalar(Aov::Distance);
  p.uv = data.two(Aov::Uv);
  return p;
}

}  // namespace

PickResult pick(Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera, const Settings& settings,
                std::span<const glm::uvec2> pixels, const SceneState& moment) {
  checkPixels(settings, pixels);
  Settings data = settings;
  data.display = false;
  data.positionOrigin = {};
  data.aovs = {Aov::Id, Aov::Part, Aov::Position, Aov::Normal, Aov::GeoNormal, Aov::Depth, Aov::Distance, Aov::Uv};
  PickResult result{.picked = std::vector<Picked>(pixels.size()), .statistics = {}};
  const std::vector<Strip> strips = data.readout != 0 ? std::vector{Strip{0, data.height}} : stripsOf(data);
  for (const Strip strip : strips) {
    const auto lies = [&](glm::uvec2 pixel) { return pixel.y >= strip.first && pixel.y - strip.first < strip.rows; };
    if (std::none_of(pixels.begin(), pixels.end(), lies)) continue;
    RenderResult rendered = renderer.renderStrip(camera, data, strip, moment);
    const output::FrameOutput& frame = rendered.frames.front();
    for (size_t i = 0; i < pixels.size(); ++i) {
      if (!lies(pixels[i])) continue;
      result.picked[i] = describe(scene, {frame, size_t{pixels[i].y - strip.first} * settings.width + pixels[i].x});
      result.picked[i].pixel = pixels[i];
    }
    result.statistics = std::move(rendered.statistics);
  }
  return result;
}

void checkPixels(const Settings& settings, std::span<const glm::uvec2> pixels) {
  for (const glm::uvec2 pixel : pixels)
    if (pixel.x >= settings.width || pixel.y >= settings.height)
      badUsage("there is no pixel {},{} in an image of {}x{}: x is between 0 and {}, y between 0 and {}", pixel.x,
               pixel.y, settings.width, settings.height, settings.width - 1, settings.height - 1);
}

}  // namespace latelight::render

// Uses the installed library as an external program would. The first argument is the version for which it was built.
// Programs may define macros of any name, which the headers must not change.
#define OPTION_FLAG 7
#define OPTION_NAME(name) #name
#include <latelight/latelight.h>
static_assert(OPTION_FLAG == 7 && OPTION_NAME(a)[0] == 'a');
#undef OPTION_FLAG
#undef OPTION_NAME

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

namespace {

// The example of docs/cpp.md.
bool edits() {
  latelight::Scene scene("builtin:boxes");
  latelight::Renderer renderer(scene, "cpu");
  const std::vector<uint8_t> before = renderer.render(scene.defaultCamera(16.0f / 9)).rgba;

  auto box = scene.instancesOf("/boxes/matte").front();
  latelight::Transform transform = scene.instance(box).transform;
  transform[7] += 0.5;  // moves it up
  scene.setTransform(box, transform);

  auto paint = scene.instance(box).material;
  latelight::Material red = scene.material(paint);
  red.baseColor = {0.8f, 0.05f, 0.05f, 1};
  scene.setMaterial(paint, red);

  latelight::Light lamp;
  lamp.position = {0, 3, 2};
  lamp.intensity = 40;
  scene.addLight(lamp);

  latelight::MeshData triangle;
  triangle.name = "flag";
  triangle.positions = {{0, 1, 0}, {1, 1, 0}, {0, 2, 0}};
  auto flag =
      scene.addInstance(scene.addMesh(triangle), paint, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "flag");

  latelight::Frame frame = renderer.render(scene.defaultCamera(16.0f / 9));
  scene.removeInstance(flag);  // the handle is rejected from here on
  try {
    scene.removeInstance(flag);
    return false;
  } catch (const latelight::Error& error) {
    return error.code() == latelight::ExitCode::Usage && frame.rgba != before;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || std::strcmp(latelight::version(), argv[1]) != 0) return 2;
  latelight::Scene scene("builtin:boxes");
  latelight::Renderer renderer(scene, "cpu");
  latelight::Options options;
  options.width = 64;
  options.height = 36;
  options.aovs = {"depth", "id"};
  latelight::Frame frame = renderer.render(scene.defaultCamera(16.0f / 9), options);
  const latelight::Aov& depth = frame.aovs.at("depth");
  const latelight::Aov& id = frame.aovs.at("id");
  bool sizes = frame.rgba.size() == 64 * 36 * 4 && depth.values.size() == 64 * 36 && id.ids.size() == 64 * 36;
  bool drawn = std::any_of(id.ids.begin(), id.ids.end(), [](uint32_t i) { return i != 0; });
  for (size_t i = 0; i < id.ids.size(); ++i)
    if (std::isfinite(depth.values[i]) != (id.ids[i] != 0)) return 1;
  try {
    latelight::Scene("no such file.glb");
    return 1;
  } catch (const latelight::Error& error) {
    if (error.code() != latelight::ExitCode::BadInput) return 1;
  }
  std::printf("latelight %s\n", latelight::version());
  return sizes && drawn && edits() ? 0 : 1;
}

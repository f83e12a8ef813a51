// The option of option.patch in the C++ API: its default, its effect, and the rejection of invalid values.
#include <latelight/latelight.h>

#include <cstring>

int main() {
  latelight::Scene scene("builtin:boxes");
  latelight::Renderer renderer(scene, "cpu");
  latelight::Options bright, exposed;
  if (bright.brightness != 1) return 1;
  bright.width = exposed.width = 64, bright.height = exposed.height = 36;
  const latelight::Camera camera = scene.defaultCamera(16.0f / 9);
  const latelight::Frame plain = renderer.render(camera, bright);
  bright.brightness = 2, exposed.exposure = 1;
  const latelight::Frame frame = renderer.render(camera, bright);
  if (frame.rgba == plain.rgba || frame.rgba != renderer.render(camera, exposed).rgba) return 1;
  bright.brightness = -1;
  try {
    renderer.render(camera, bright);
  } catch (const latelight::Error& error) {
    return error.code() == latelight::ExitCode::Usage && std::strstr(error.what(), "--brightness") ? 0 : 1;
  }
  return 1;
}

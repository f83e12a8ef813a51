// A viewing session: an interactive view of a scene, without a window. A single thread must use it (such as that of
// session_thread.h).
//
//   view::ViewSession session({.scene = "helmet.glb"});
//   session.input(view::PointerMove{10, 20});
//   while (session.wantsFrame()) show(session.next());
//
// While something moves, the resolution is reduced until the frame rate reaches ten pictures per second (draft.h). At
// rest, the last picture is byte for byte the output of state().command, except for the outline of the selection.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "view/input.h"
#include "view/state.h"

namespace latelight::view {

struct Start {
  std::string scene = "builtin:hall";
  scene::LoadOptions load{};
  std::string device = "auto";
  bool validate = false;
  std::string environment{};                  // --hdri
  std::string camera{};                       // --camera
  std::optional<glm::dvec3> eye{}, target{};  // in the scene file's coordinates; set both or none
  std::optional<double> fov{};                // vertical, in degrees
  Choice choice{};
  uint32_t width = 1280, height = 720;
};

class ViewSession {
 public:
  // Throws Error if scene, device or options are invalid. Later errors are reported in state().error.
  explicit ViewSession(const Start& start);
  ~ViewSession();
  ViewSession(const ViewSession&) = delete;
  ViewSession& operator=(const ViewSession&) = delete;

  void input(const Input& input);
  // False while nothing has changed since the last picture. Checks the files of the scene and of vk::useShadersOf() for
  // changes, twice per second.
  bool wantsFrame();
  // Returns the seconds after which wantsFrame() may return true without any input; at most 0.5.
  double secondsUntilStep() const;
  // Renders the next picture and waits for the device. After an error, it returns the earlier picture.
  const SessionFrame& next();
  const SessionFrame& frame() const;  // the last picture
  // Returns true if the next picture is likely to differ: something moves, or did recently.
  bool moves() const;
  const State& state() const;

  // Returns the words of the command `latelight render ...` that renders the final picture of a side, without -o.
  std::vector<std::string> commandLine(Side side = Side::Left) const;
  // Returns the PNG file that this command writes. Throws Error.
  std::vector<std::byte> screenshot(Side side = Side::Left);
  // Returns the device's messages since the last call.
  std::vector<std::string> validationMessages();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace latelight::view

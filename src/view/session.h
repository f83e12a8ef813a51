// A viewing session: a scene, a renderer and what people do with them, without any window. One thread uses it
// (session_thread.h is one).
//
//   view::ViewSession session({.scene = "helmet.glb"});
//   session.input(view::PointerMove{10, 20});
//   while (session.wantsFrame()) show(session.next());
//
// While something moves, pictures have as few pixels as it takes to make ten a second (draft.h); once it stands still,
// the last one is byte for byte what state().command writes, but for the outline of what is selected.
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
  std::string environment{};                 // --hdri
  std::string camera{};                      // --camera
  std::optional<glm::dvec3> eye{}, target{};  // of the scene file's frame; both or none
  std::optional<double> fov{};               // degrees
  Choice choice{};
  uint32_t width = 1280, height = 720;
};

class ViewSession {
 public:
  // Throws Error where scene, device or options can't be. Later errors are sentences of state().
  explicit ViewSession(const Start& start);
  ~ViewSession();
  ViewSession(const ViewSession&) = delete;
  ViewSession& operator=(const ViewSession&) = delete;

  void input(const Input& input);
  // False while nothing has changed since the last picture. Looks at the scene's files, and those of
  // vk::useShadersOf(), twice a second.
  bool wantsFrame();
  // Seconds after which wantsFrame() may be true without any input; at most 0.5.
  double patience() const;
  // Waits for the device. Where there was an error, the earlier picture again.
  const Frame& next();
  const Frame& frame() const;  // the last one
  // Whether the next picture may well be another one: something moves, or did a moment ago.
  bool moves() const;
  const State& state() const;

  // `latelight render ...`, word by word, that makes the final picture of a side; -o stays to be said.
  std::vector<std::string> commandLine(Side side = Side::Left) const;
  // The PNG file that it writes. Throws Error.
  std::vector<std::byte> screenshot(Side side = Side::Left);
  // Of the device, since the last call.
  std::vector<std::string> validationMessages();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace latelight::view

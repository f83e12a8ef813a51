// The implementation of a viewing session: session_input.cpp handles input, session.cpp renders pictures and describes
// the state.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "view/choice.h"
#include "view/draft.h"
#include "view/session.h"
#include "view/stage.h"
#include "view/steering.h"

namespace latelight::view {

struct ViewSession::Impl {
  using Clock = std::chrono::steady_clock;

  explicit Impl(const Start& start);

  // --- input. On Error, these functions change nothing. ---
  void take(const Input& input);
  void resize(const Resize& size);
  // The parts of the state with which pictures may be impossible.
  struct Choices {
    Choice choices[2];
    std::string environment, camera;
    std::optional<CameraControl> control;
  };
  Choices choices() const;
  void restore(Choices earlier);
  // Changes these parts. If no picture can be rendered with the result, restores them and throws Error.
  void choose(const std::function<void()>& change);
  std::optional<Error> whyUnrenderable();  // nothing: pictures can be rendered
  bool restoreShown();
  void setOption(const SetOption& set);
  void showOutput(const ShowOutput& show);
  void setSplit(const SetSplit& split);
  void useCamera(const std::string& name);
  void uploadEnvironment(const UploadEnvironment& given);
  void movePointer(const PointerMove& move);
  void turnWheel(double steps);
  void pressKey(const Key& key);
  void select(glm::uvec2 pixel);
  void pickByKey();
  void escape();
  void moveSlider(double by);
  uint32_t lightAt(uint32_t place) const;  // its index in the scene
  void moveLight(uint32_t light, glm::dvec3 world);
  void dragLight(uint32_t light, glm::dvec2 pixel);
  void nudgeLight(const NudgeLight& nudge);
  void play(bool on);
  void setTime(double seconds);
  void screenshot(const Screenshot& shot);
  output::Picture finalPicture(Side side);  // the output of the side's command line
  void openScene(const std::string& source);
  void load(const std::string& source, const scene::LoadOptions& options);
  void frame(const scene::Bounds& bounds);
  CameraControl& steered();  // switches to the interactive camera
  glm::dvec3 underPointer();

  // --- time ---
  // The subject of state.error. Errors about pictures are forgotten when a picture has been rendered.
  enum class ErrorOf {
    Input,            // an input, or a file that changed
    Picture,          // a picture that cannot be rendered with the current choices
    RejectedChoices,  // choices that were restored because of it: Picture from the next change on
  };
  void setError(const std::string& sentence, ErrorOf cause) { state.error = sentence, errorOf = cause; }
  void forgetError() { setError("", ErrorOf::Input); }
  void touch() {
    touched = Clock::now(), dirty = true;
    if (errorOf == ErrorOf::RejectedChoices) errorOf = ErrorOf::Picture;
  }
  double sinceTouched() const { return std::chrono::duration<double>(Clock::now() - touched).count(); }
  bool runs() const { return state.playing || steering.flying(); }
  bool isMoving() const;
  void advance();

  // --- pictures and state ---
  bool hasSplit() const { return state.split.mode != SetSplit::Off; }
  Choice& choiceOf(Side side) { return state.choices[static_cast<int>(side)]; }
  ChosenSettings settings(Side side) const;
  CameraChoice cameraChoice() const;
  scene::Camera camera() const;
  std::string environmentWord() const;
  std::vector<std::string> commandLine(Side side) const;
  void makePicture();
  void render(bool asDraft, bool follows);
  void compose();
  bool rests() const { return !dirty && picture.final && !isMoving() && !steering.dragging(); }
  bool wantsRehearsal() const { return rests() && rehearsals > 0 && !draft.isWhole(); }
  void rehearse();
  bool wantsProbe() const;
  void probe();
  void lightAgain();
  void shadeAgain();
  void dropIfLost(ExitCode code) {
    if (code == ExitCode::DeviceLost) stage.dropDevice();
  }
  void takeValidation();
  void describe();
  void describeLights();

  Start start;
  Stage stage;
  Steering steering;
  Draft draft;
  int rehearsals;  // remaining test renders of drafts
  std::optional<CameraControl> control;
  std::vector<uint32_t> lights;  // indices of positional lights in the scene
  State state;
  SessionFrame picture;
  Stage::Result sides[2];
  std::vector<std::string> validation;
  bool dirty = true, recompose = false;
  ErrorOf errorOf = ErrorOf::Input;
  std::optional<Choices> shown;      // of the last picture that was not a draft, unless restored since
  std::optional<glm::uvec2> probed;  // the probed pixel, if nothing has changed since
  Clock::time_point touched{}, stepped = Clock::now();
};

}  // namespace latelight::view

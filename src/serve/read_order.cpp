#include <fmt/format.h>

#include <array>
#include <cmath>
#include <functional>
#include <map>

#include "base/lowercase.h"
#include "serve/messages.h"

namespace latelight::serve {

namespace {

using Json = nlohmann::json;
using Read = std::function<decltype(Order::what)(const Json&)>;

constexpr uint32_t kMaxSide = 8192;
constexpr uint32_t kMaxLight = 1u << 20;
constexpr uint64_t kMaxCount = 1ull << 53;  // JavaScript's maximum safe integer plus one

// JSON has neither infinities nor NaN.
double number(const Json& value) {
  if (!value.is_number()) throw BadMessage("a number is expected");
  return value.get<double>();
}
double number(const Json& message, const char* key) {
  return number(message.at(key));
}

template <typename T = uint32_t>
T whole(const Json& message, const char* key, T most) {
  const Json& value = message.at(key);
  if (!value.is_number_unsigned() || value.get<uint64_t>() > most)
    throw BadMessage(fmt::format("\"{}\" is no whole number up to {}", key, most));
  return value.get<T>();
}

std::string text(const Json& message, const char* key) {
  return message.at(key).get<std::string>();
}

// Returns the value for a name.
template <typename T>
T named(const Json& message, const char* key, const std::map<std::string, T>& names) {
  const auto found = names.find(text(message, key));
  if (found == names.end()) throw BadMessage(fmt::format("\"{}\" is none of its names", key));
  return found->second;
}

view::Side side(const Json& message) {
  if (!message.contains("side")) return view::Side::Left;
  return named<view::Side>(message, "side", {{"left", view::Side::Left}, {"right", view::Side::Right}});
}

view::Button button(const Json& message) {
  using view::Button;
  return named<Button>(message, "button",
                       {{"left", Button::Left}, {"middle", Button::Middle}, {"right", Button::Right}});
}

view::SetSplit split(const Json& message) {
  using view::SetSplit;
  const auto mode = named<SetSplit::Mode>(
      message, "mode", {{"off", SetSplit::Off}, {"slider", SetSplit::Slider}, {"difference", SetSplit::Difference}});
  return {mode, number(message, "at"), number(message, "amplification")};
}

view::Navigation navigation(const Json& message) {
  return named<view::Navigation>(message, "mode", {{"orbit", view::Navigation::Orbit}, {"fly", view::Navigation::Fly}});
}

// Returns exactly three numbers, within the range of floats.
std::array<double, 3> vector(const Json& message, const char* key) {
  const Json& value = message.at(key);
  std::array<double, 3> numbers{};
  if (!value.is_array() || value.size() != numbers.size())
    throw BadMessage(fmt::format("\"{}\" must be {} numbers", key, numbers.size()));
  for (size_t i = 0; i < numbers.size(); ++i) {
    numbers[i] = number(value[i]);
    if (!std::isfinite(static_cast<float>(numbers[i])))
      throw BadMessage(fmt::format("\"{}\" has a number that is too large", key));
  }
  return numbers;
}

view::MoveLight moveLight(const Json& message) {
  return {whole(message, "light", kMaxLight), vector(message, "position")};
}

// The name must not contain a path.
SendFile file(const Json& message) {
  SendFile sent{text(message, "name"), whole<uint64_t>(message, "bytes", kMaxFileBytes)};
  const std::string name = lowercase(sent.name);
  if (!name.ends_with(".hdr") && !name.ends_with(".exr")) throw BadMessage("an environment is .hdr or .exr");
  if (sent.name.find('/') != sent.name.npos) throw BadMessage("a file's name has no folder");
  return sent;
}

const std::map<std::string, Read, std::less<>>& readers() {
  using view::Input;
  static const std::map<std::string, Read, std::less<>> kReaders = {
      {"shown", [](const Json& m) { return Shown{whole(m, "number", kMaxCount)}; }},
      {"screenshot", [](const Json& m) { return TakeScreenshot{side(m)}; }},
      {"resize",
       [](const Json& m) -> Input {
         return view::Resize{whole(m, "width", kMaxSide), whole(m, "height", kMaxSide)};
       }},
      {"move",
       [](const Json& m) -> Input {
         return view::PointerMove{number(m, "x"), number(m, "y")};
       }},
      {"leave", [](const Json&) -> Input { return view::PointerLeave{}; }},
      {"button",
       [](const Json& m) -> Input {
         return view::PointerButton{button(m), m.at("down"), m.value("shift", false)};
       }},
      {"wheel", [](const Json& m) -> Input { return view::Wheel{number(m, "steps")}; }},
      {"key",
       [](const Json& m) -> Input {
         return view::Key{text(m, "name"), m.at("down"), m.value("shift", false)};
       }},
      {"blur", [](const Json&) -> Input { return view::Blur{}; }},
      {"option",
       [](const Json& m) -> Input {
         return view::SetOption{text(m, "name"), text(m, "value"), side(m)};
       }},
      {"output",
       [](const Json& m) -> Input {
         return view::ShowOutput{text(m, "name"), side(m)};
       }},
      {"split", [](const Json& m) -> Input { return split(m); }},
      {"camera", [](const Json& m) -> Input { return view::UseCamera{text(m, "name")}; }},
      {"environment", [](const Json& m) -> Input { return view::UseEnvironment{text(m, "name")}; }},
      {"navigation", [](const Json& m) -> Input { return view::SetNavigation{navigation(m)}; }},
      {"play", [](const Json& m) -> Input { return view::Play{m.at("on")}; }},
      {"variant", [](const Json& m) -> Input { return view::UseVariant{text(m, "name")}; }},
      {"lights", [](const Json& m) { return ShowLights{m.at("on")}; }},
      {"moveLight", [](const Json& m) -> Input { return moveLight(m); }},
      {"dragLight",
       [](const Json& m) -> Input {
         return view::DragLight{whole(m, "light", kMaxLight), number(m, "x"), number(m, "y")};
       }},
      {"nudgeLight",
       [](const Json& m) -> Input {
         return view::NudgeLight{whole(m, "light", kMaxLight), number(m, "dx"), number(m, "dy")};
       }},
      {"file", [](const Json& m) { return file(m); }},
      {"reload", [](const Json&) -> Input { return view::Reload{}; }},
  };
  return kReaders;
}

// Pages may open only those files of this machine that the command line named.
void checkEnvironment(const Order& order, const view::Start& start) {
  const auto* input = std::get_if<view::Input>(&order.what);
  const auto* use = input ? std::get_if<view::UseEnvironment>(input) : nullptr;
  if (use && !use->name.empty() && use->name != "studio" && use->name != "none" && use->name != start.environment)
    throw BadMessage("no such environment is offered");
}

}  // namespace

Order readOrder(std::string_view textOfMessage, const view::Start& start) {
  try {
    const Json message = Json::parse(textOfMessage);
    const auto reader = readers().find(message.at("type").get<std::string>());
    if (reader == readers().end()) throw BadMessage("there is no message of this type");
    Order order{reader->second(message), message.contains("serial") ? whole(message, "serial", kMaxCount) : 0};
    checkEnvironment(order, start);
    return order;
  } catch (const Json::exception&) {
    throw BadMessage("a message is not as the page writes them");
  }
}

}  // namespace latelight::serve

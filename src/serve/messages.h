// The messages between a page and a session.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/memory.h"
#include "view/session.h"

namespace latelight::serve {

// --- from the page: JSON ---

struct Shown {  // this message and all before it have been shown
  uint64_t number;
};
struct TakeScreenshot {
  view::Side side;
};
struct ShowLights {  // report the positions of lights
  bool on;
};
// Announces an environment image, which follows in binary messages of this many bytes in total.
struct SendFile {
  std::string name;
  size_t bytes;
};
// The server's replacement for an order that it cannot carry out. The page receives the sentence.
struct Refused {
  std::string sentence;
};
struct Order {
  std::variant<view::Input, Shown, TakeScreenshot, ShowLights, SendFile, Refused> what;
  uint64_t serial = 0;  // the page's count of orders; pictures state the last one that they include
};
// Returns true for an order that is answered with its own message.
inline bool isAnswered(const Order& order) {
  return std::holds_alternative<TakeScreenshot>(order.what) || std::holds_alternative<Refused>(order.what);
}
inline bool isFile(const Order& order) {
  const auto* input = std::get_if<view::Input>(&order.what);
  return input && std::holds_alternative<view::UploadEnvironment>(*input);
}
// Thrown for a message that the server's own page never sends. The connection is closed with this sentence.
class BadMessage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
// Parses a message. The page may not open environment files other than the one that `start` names.
Order readOrder(std::string_view text, const view::Start& start);
constexpr size_t kMaxOrderBytes = 4096;
constexpr size_t kMaxPieceBytes = 64 << 10;  // maximum part of a file per message
constexpr size_t kMaxFileBytes = 64 << 20;   // enough for a .hdr file of 4096x2048 pixels (at most 33 MB)

// --- to the page: a length, a JSON header of that many bytes, and the bytes that the header describes ---

// A message; its bytes count toward the memory limit until they have been written to the socket.
struct Message {
  std::string bytes;
  MemoryClaim memory;
};

std::string envelope(const nlohmann::json& header, const std::vector<std::string_view>& payload = {});
// Returns the tables from which the page builds its controls: options, outputs and the like.
nlohmann::json tables(const view::Start& start);
nlohmann::json describe(const view::ViewSession& session, bool withLights);
// Returns the values of `now` that differ from `before`.
nlohmann::json changes(const nlohmann::json& before, const nlohmann::json& now);

}  // namespace latelight::serve

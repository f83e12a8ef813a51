// What a page and a session say to each other.
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

struct Shown {  // a message has been shown, and all before it
  uint64_t number;
};
struct TakeScreenshot {
  view::Side side;
};
struct ShowLights {  // tell where they are
  bool on;
};
// An environment's picture follows in binary messages of this many bytes in total.
struct SendFile {
  std::string name;
  size_t bytes;
};
// The server's own order in place of one that it can't carry out: the page is sent the sentence.
struct Refused {
  std::string sentence;
};
struct Order {
  std::variant<view::Input, Shown, TakeScreenshot, ShowLights, SendFile, Refused> what;
  uint64_t serial = 0;  // the page's own count; pictures say the last one that they follow
};
// An order that is answered with a message of its own.
inline bool isAnswered(const Order& order) {
  return std::holds_alternative<TakeScreenshot>(order.what) || std::holds_alternative<Refused>(order.what);
}
inline bool isFile(const Order& order) {
  const auto* input = std::get_if<view::Input>(&order.what);
  return input && std::holds_alternative<view::GiveEnvironment>(*input);
}
// What no page of ours says: its connection is closed with this sentence.
class BadMessage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
// `start`: of environments, files other than the one that it names are not the page's to open.
Order readOrder(std::string_view text, const view::Start& start);
constexpr size_t kMaxOrderBytes = 4096;
constexpr size_t kMaxPieceBytes = 64 << 10;  // of a file, per message
constexpr size_t kMaxFileBytes = 64 << 20;   // a .hdr file of 4096x2048 pixels has at most 33 MB

// --- to the page: a length, a header in JSON of that many bytes, and the bytes that the header tells of ---

// Its bytes count against the limit of memory until they have been written to the socket.
struct Message {
  std::string bytes;
  MemoryClaim memory;
};

std::string envelope(const nlohmann::json& header, const std::vector<std::string_view>& payload = {});
// What controls are made of: options, outputs and the like.
nlohmann::json tables(const view::Start& start);
nlohmann::json describe(const view::ViewSession& session, bool withLights);
// Those values of `now` that `before` has not.
nlohmann::json changes(const nlohmann::json& before, const nlohmann::json& now);

}  // namespace latelight::serve

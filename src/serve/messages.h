// What a page and a session say to each other.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

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
// An environment's picture follows in binary messages: as much as they are together.
struct SendFile {
  std::string name;
  size_t bytes;
};
struct Order {
  std::variant<view::Input, Shown, TakeScreenshot, ShowLights, SendFile> what;
  uint64_t serial = 0;  // the page's own count; pictures say the last one that they follow
};
// What no page of ours says: its connection is closed with this sentence.
class BadMessage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
// `start`: of environments, files other than the one that it names are not the page's to open.
Order readOrder(std::string_view text, const view::Start& start);
constexpr size_t kMostBytes = 4096;       // of such a message
constexpr size_t kMostPiece = 64 << 10;   // of a file, a message
constexpr size_t kMostOfFile = 64 << 20;  // 4096x2048 pixels of a .hdr file are 33 MB at most

// --- to the page: a length, a header in JSON of that many bytes, and the bytes that the header tells of ---

std::string envelope(const nlohmann::json& header, const std::vector<std::string_view>& payload = {});
// What controls are made of: options, outputs and the like.
nlohmann::json tables(const view::Start& start);
nlohmann::json describe(const view::ViewSession& session, bool withLights);
// Those values of `now` that `before` has not.
nlohmann::json changes(const nlohmann::json& before, const nlohmann::json& now);

}  // namespace latelight::serve

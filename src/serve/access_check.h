// Access control: every request, for a page or for a session, is checked here first, against the secret token, the host
// name and the origin.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace latelight::serve {

// The parts of a request that are checked.
struct RequestHeader {
  std::string_view target;                 // "/TOKEN/style.css", or "http://localhost:8765/TOKEN/style.css"
  std::string_view host;                   // "localhost:8765"
  std::optional<std::string_view> origin;  // set for requests from a page: "http://localhost:8765"
};

class AccessCheck {
 public:
  // `names`: the names of this machine that browsers use, in lower case, in addition to "localhost" and addresses.
  // Throws Error(Usage) for a name that no browser can send.
  AccessCheck(std::string token, std::vector<std::string> names);

  struct Answer {
    std::string path;     // the path after the token: "", "style.css"
    std::string refusal;  // reason in a few words; empty: access is granted
  };
  Answer open(const RequestHeader& header) const;

 private:
  bool knows(std::string_view host) const;

  std::string token_;
  std::vector<std::string> names_;
};

}  // namespace latelight::serve

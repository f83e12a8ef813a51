// A client that acts like the page toward the server, without a browser.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace latelight::serve {

// Sends these bytes on a connection of their own, and returns all that comes back until it is closed.
std::string ask(uint16_t port, const std::string& bytes);
std::string get(uint16_t port, const std::string& target, const std::string& more = "");  // `more`: lines of the header

class Client {
 public:
  // Throws where the server does not let it in.
  Client(uint16_t port, const std::string& token, const std::string& origin = "");
  ~Client();  // goes without a word
  Client(Client&&) noexcept;

  uint64_t say(nlohmann::json message);  // its serial number
  void sayText(const std::string& text);
  void sayBinary(const std::string& bytes);

  struct Message {
    nlohmann::json header;
    std::string payload;
  };
  Message hear();                     // throws where the server closed the connection, or says nothing for half an hour
  void show(const Message& message);  // acknowledges it
  // The next final picture, with everything on the way shown, and the session's state by then.
  Message hearFinal();
  const nlohmann::json& state() const;
  bool hearsWithin(std::chrono::milliseconds time);

  uint16_t closeCode() const;  // the server's; 0: none was said
  std::string closeReason() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// RGB of a picture's strips, decoded.
struct Decoded {
  uint32_t width = 0, height = 0;
  std::string rgb;
};
Decoded decode(const Client::Message& message);

}  // namespace latelight::serve

// A client that acts like the page toward the server, without a browser.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace latelight::serve {

// Sends these bytes on a new connection, and returns everything that is received until it is closed.
std::string ask(uint16_t port, const std::string& bytes);
std::string get(uint16_t port, const std::string& target, const std::string& more = "");  // `more`: lines of the header

class Client {
 public:
  // Throws if the server rejects the connection.
  Client(uint16_t port, const std::string& token, const std::string& origin = "");
  ~Client();  // closes the connection without a message
  Client(Client&&) noexcept;

  uint64_t say(nlohmann::json message);  // returns its serial number
  void sayText(const std::string& text);
  void sayBinary(const std::string& bytes);

  struct Message {
    nlohmann::json header;
    std::string payload;
  };
  Message hear();                     // throws if the server closed the connection, or sent no message for half an hour
  void show(const Message& message);  // acknowledges it
  // Returns the next final picture, after all pictures in flight were shown, and the session's state at that time.
  Message hearFinal();
  const nlohmann::json& state() const;
  bool hearsWithin(std::chrono::milliseconds time);

  uint16_t closeCode() const;  // received from the server; 0: none
  std::string closeReason() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The decoded RGB pixels of a picture's strips.
struct Decoded {
  uint32_t width = 0, height = 0;
  std::string rgb;
};
Decoded decode(const Client::Message& message);

}  // namespace latelight::serve

// The WebSocket connection of a page to its session.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <memory>
#include <string>

#include "serve/hub.h"

namespace latelight::serve {

using Request = boost::beast::http::request<boost::beast::http::empty_body>;

// Starts a socket for a request that has passed the gate. It lives as long as its connection.
void startSocket(boost::asio::ip::tcp::socket socket, Request request, const std::string& peer, Hub& hub,
                 std::unique_ptr<Visit> visit);

}  // namespace latelight::serve

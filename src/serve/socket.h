// A connection that a page keeps open: its session's, by WebSocket.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <memory>
#include <string>

#include "serve/hub.h"

namespace latelight::serve {

using Request = boost::beast::http::request<boost::beast::http::empty_body>;

// The request has passed the gate. The socket lives as long as its connection.
void startSocket(boost::asio::ip::tcp::socket socket, Request request, const std::string& peer, Hub& hub,
                 std::unique_ptr<Visit> visit);

}  // namespace latelight::serve

// A connection that speaks HTTP: it gives out the page's files, or becomes a socket.
#pragma once

#include <boost/asio/ip/tcp.hpp>

#include "serve/hub.h"

namespace latelight::serve {

// It lives as long as its connection.
void startConnection(boost::asio::ip::tcp::socket socket, Hub& hub);

}  // namespace latelight::serve

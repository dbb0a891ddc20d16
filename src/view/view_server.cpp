// SPDX-License-Identifier: MIT
// The only source that includes cpp-httplib.
#include "limber/view/view_server.hpp"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/random.h>

#include <array>
#include <charconv>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "page_template.hpp"

namespace limber {
namespace {

constexpr const char* kLoopback = "127.0.0.1";
constexpr std::size_t kThreads =
    32;  // a page holds one for its events, and some for a second after a request

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw std::system_error(errno, std::generic_category(), "random token for the live view");
  }
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

/// Whether one text is the other, in a time that does not depend on where they differ.
bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    difference |= static_cast<unsigned char>(a[k]) ^ static_cast<unsigned char>(b[k]);
  }
  return difference == 0;
}

std::uint64_t number_in(const httplib::Request& request, const char* name) {
  const std::string text = request.get_param_value(name);
  std::uint64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::optional<ViewCommand> command_named(const std::string& name) {
  if (name == "pause") return ViewCommand::kPause;
  if (name == "step") return ViewCommand::kStep;
  if (name == "run") return ViewCommand::kRun;
  if (name == "time") return ViewCommand::kRunInTime;
  if (name == "dismiss") return ViewCommand::kDismiss;
  return std::nullopt;
}

/// Another process must not listen on the same port: no SO_REUSEPORT, which cpp-httplib sets by itself.
void reuse_address_only(socket_t socket) {
  const int yes = 1;
  setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
}

}  // namespace

class ViewServer::Http {
 public:
  Http(ViewBoard& board, std::uint16_t port) : board_(board), token_(random_token()) {
    configure();
    add_routes();
    port_ =
        port == 0 ? server_.bind_to_any_port(kLoopback) : (server_.bind_to_port(kLoopback, port) ? port : -1);
    if (port_ <= 0) {
      throw std::runtime_error(fmt::format(
          "port {} of {} cannot be listened on: is it taken? Port 0 is any that is free", port, kLoopback));
    }
    url_ = fmt::format("http://{}:{}/{}/", kLoopback, port_, token_);
    listening_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) {
      std::this_thread::yield();
    }
  }
  ~Http() {
    board_.close();
    server_.stop();
    listening_.join();
  }
  Http(const Http&) = delete;
  Http& operator=(const Http&) = delete;

  [[nodiscard]] const std::string& url() const { return url_; }

 private:
  void configure() {
    server_.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    server_.set_socket_options(reuse_address_only);
    server_.set_tcp_nodelay(true);
    server_.set_keep_alive_max_count(1'000'000);
    server_.set_keep_alive_timeout(1);
    server_.set_payload_max_length(1024);
    server_.set_default_headers({{"Cache-Control", "no-store"},
                                 {"Referrer-Policy", "no-referrer"},
                                 {"X-Content-Type-Options", "nosniff"},
                                 {"X-Frame-Options", "DENY"},
                                 {"Cross-Origin-Resource-Policy", "same-origin"}});
    server_.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      if (is_allowed(request)) return httplib::Server::HandlerResponse::Unhandled;
      response.status = 403;
      return httplib::Server::HandlerResponse::Handled;
    });
  }

  [[nodiscard]] bool is_allowed(const httplib::Request& request) const {
    const std::string_view path = request.path;
    if (path.size() < token_.size() + 2 || path[0] != '/' || path[token_.size() + 1] != '/' ||
        !same_secret(path.substr(1, token_.size()), token_)) {
      return false;
    }
    const std::string here = fmt::format("{}:{}", kLoopback, port_),
                      name = fmt::format("localhost:{}", port_);
    const std::string host = request.get_header_value("Host");
    const std::string origin = request.get_header_value("Origin");
    return (host == here || host == name) && (origin.empty() || origin == "http://" + host);
  }

  void add_routes() {
    const std::string below = "/" + token_ + "/";
    server_.Get(below, [](const httplib::Request&, httplib::Response& response) {
      response.set_content(detail::view_page().data(), detail::view_page().size(),
                           "text/html; charset=utf-8");
    });
    server_.Get(below + "events", [this](const httplib::Request& request, httplib::Response& response) {
      send_events(request, response);
    });
    server_.Post(below + "control", [this](const httplib::Request& request, httplib::Response& response) {
      const auto command = command_named(request.get_param_value("do"));
      response.status = command ? 204 : 400;
      if (command) board_.command(*command);
    });
    server_.Post(below + "shown", [this](const httplib::Request& request, httplib::Response& response) {
      board_.acknowledge(number_in(request, "viewer"), number_in(request, "frame"));
      response.status = 204;
    });
  }

  void send_events(const httplib::Request& request, httplib::Response& response) {
    const std::uint64_t viewer = board_.enter(request.has_param("acknowledge"));
    if (viewer == 0) {
      response.status = 503;
      response.set_content("too many pages look on already\n", "text/plain");
      return;
    }
    response.set_chunked_content_provider(
        "text/event-stream",
        [this, viewer](std::size_t, httplib::DataSink& sink) {
          const std::string events = board_.next(viewer);
          if (!sink.write(events.data(), events.size())) return false;
          if (board_.closed()) sink.done();  // only now: what was taken from the board may be its end
          return true;
        },
        [this, viewer](bool) { board_.leave(viewer); });
  }

  ViewBoard& board_;
  const std::string token_;
  int port_ = -1;
  std::string url_;
  httplib::Server server_;
  std::thread listening_;
};

ViewServer::ViewServer(ViewBoard& board, std::uint16_t port) : http_(std::make_unique<Http>(board, port)) {}

ViewServer::~ViewServer() = default;

const std::string& ViewServer::url() const { return http_->url(); }

}  // namespace limber

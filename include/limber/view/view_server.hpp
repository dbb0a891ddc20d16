// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "limber/view/view_board.hpp"

namespace limber {

/// @brief Serves a board as a page to browsers on this computer.
///
/// Listens on 127.0.0.1 alone. Every address begins with a random token of 128 bits; a request without it, or
/// with the name of another host (DNS rebinding) or origin, is answered with 403. The page is one file and
/// asks nobody else for anything. Below /TOKEN/: the page; `events` (server-sent events, see
/// ViewBoard::next); `control?do=pause|step|run|time|dismiss` and `shown?viewer=V&frame=N`, both POST.
class ViewServer {
 public:
  /// @param board  must outlive the server
  /// @param port   0: any that is free
  /// @throws std::runtime_error if the port cannot be listened on
  ViewServer(ViewBoard& board, std::uint16_t port);
  ~ViewServer();  ///< closes the board
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  /// Where the page is, with the token.
  [[nodiscard]] const std::string& url() const;

 private:
  class Http;
  std::unique_ptr<Http> http_;
};

}  // namespace limber

// SPDX-License-Identifier: MIT
#pragma once

#include <httplib.h>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace limber::testing {

/// Of a live view; `path` begins and ends with a slash.
struct Address {
  std::string host;
  int port = 0;
  std::string path;
};

/// "http://HOST:PORT/TOKEN/" in parts.
inline Address address_of(const std::string& url) {
  const std::size_t host = url.find("//") + 2, port = url.find(':', host), path = url.find('/', port);
  return {url.substr(host, port - host), std::stoi(url.substr(port + 1, path - port - 1)), url.substr(path)};
}

inline httplib::Result get(const Address& at, const std::string& path, const httplib::Headers& headers = {}) {
  httplib::Client client(at.host, at.port);
  client.set_connection_timeout(2);
  return client.Get(path, headers);
}

inline httplib::Result post(const Address& at, const std::string& path) {
  httplib::Client client(at.host, at.port);
  return client.Post(path);
}

/// Addresses of this computer other than 127.0.0.1.
inline std::vector<std::string> other_addresses() {
  std::vector<std::string> out = {"127.0.0.2", "::1"};
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) == 0) {
    for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
      if (one->ifa_addr != nullptr && one->ifa_addr->sa_family == AF_INET) {
        char text[INET_ADDRSTRLEN] = {};
        inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr, text,
                  sizeof(text));
        if (std::string(text) != "127.0.0.1") out.emplace_back(text);
      }
    }
    freeifaddrs(all);
  }
  return out;
}

/// Server-sent events, read by a thread of its own as a browser would.
class EventStream {
 public:
  EventStream(const Address& at, const std::string& name) : client_(at.host, at.port) {
    client_.set_read_timeout(20);
    thread_ = std::thread([this, path = at.path + name] {
      client_.Get(path, [this](const char* data, std::size_t size) { return take({data, size}); });
      const std::lock_guard lock(mutex_);
      over_ = true;
      changed_.notify_all();
    });
  }
  ~EventStream() {
    {
      const std::lock_guard lock(mutex_);
      left_ = true;
    }
    client_.stop();
    thread_.join();
  }
  EventStream(const EventStream&) = delete;
  EventStream& operator=(const EventStream&) = delete;

  /// The next event, comments left out; empty if there is none within 10 s, or will be none.
  std::string next() {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::seconds(10), [this] { return over_ || !events_.empty(); });
    if (events_.empty()) return "";
    std::string event = std::move(events_.front());
    events_.pop_front();
    return event;
  }
  /// Events that have come and were not taken.
  [[nodiscard]] std::size_t waiting() {
    const std::lock_guard lock(mutex_);
    return events_.size();
  }

 private:
  bool take(const std::string& text) {
    const std::lock_guard lock(mutex_);
    text_ += text;
    for (std::size_t end = text_.find("\n\n"); end != std::string::npos; end = text_.find("\n\n")) {
      if (text_[0] != ':') events_.push_back(text_.substr(0, end + 1));
      text_.erase(0, end + 2);
    }
    changed_.notify_all();
    return !left_;
  }

  httplib::Client client_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string text_;
  std::deque<std::string> events_;
  bool over_ = false, left_ = false;
  std::thread thread_;
};

}  // namespace limber::testing

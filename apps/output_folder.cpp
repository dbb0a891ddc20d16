// SPDX-License-Identifier: MIT
#include "output_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <string>
#include <string_view>

#include "limber/core/errors.hpp"
#include "limber/io/atomic_file.hpp"

namespace limber::app {
namespace {

namespace fs = std::filesystem;

/// FNV-1a: paths may be longer than a socket's name.
std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : text) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  }
  return hash;
}

/// What of a path is there already: itself, or the folder that would hold the rest.
fs::path existing_part(const fs::path& path) {
  fs::path out = (fs::absolute(path) / "").parent_path();
  while (!fs::exists(fs::symlink_status(out))) {
    out = out.parent_path();
  }
  return out;
}

/// Writes a file without a name, of which nothing stays however the program ends. @return false where that
/// fails, or no such files exist
bool takes_nameless_file(const fs::path& folder) {
  const int descriptor = open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
  if (descriptor < 0) {
    return false;
  }
  const bool written = write(descriptor, " ", 1) == 1;
  close(descriptor);
  return written;
}

}  // namespace

void require_writable_folder(const fs::path& path) {
  const auto refuse = [&path](const std::string& found) {
    throw DataError(path.string(), 0, "a folder that can be made and written", found);
  };
  try {
    if (takes_nameless_file(existing_part(path))) {
      return;
    }
    const FolderUnlessEmpty folder(path);  // by its name, and what is wrong is said
    if (!fs::is_directory(path)) {
      refuse("something that is no folder");
    }
    AtomicFile probe(path / ".limber-probe");  // never committed: it only has to open
    probe.write(" ");
  } catch (const fs::filesystem_error& error) {
    refuse(error.code().message());
  }
}

ClaimedPlace::ClaimedPlace(const fs::path& path) {
  const fs::path place = (fs::weakly_canonical(fs::absolute(path)) / "").lexically_normal();
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  // Linux's abstract names begin with a zero; they are of no folder.
  const std::string text = fmt::format("limber-results-{:016x}", hash_of(place.string()));
  std::copy(text.begin(), text.end(), name.sun_path + 1);
  socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_ < 0) {
    return;  // without it the later one notices at its end
  }
  const auto size = static_cast<socklen_t>(sizeof(sa_family_t) + 1 + text.size());
  if (bind(socket_, reinterpret_cast<const sockaddr*>(&name), size) != 0 && errno == EADDRINUSE) {
    close(socket_);
    throw DataError(path.string(), 0, "a place that no other limber is working for",
                    "one that is claimed by a limber that runs: wait for it, or choose another one");
  }
}

ClaimedFolder::ClaimedFolder(const fs::path& path) : ClaimedPlace((require_writable_folder(path), path)) {}

ClaimedPlace::~ClaimedPlace() {
  if (socket_ >= 0) {
    close(socket_);
  }
}

}  // namespace limber::app

// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace limber::app {

/// @brief Tries whether a folder for results can be made and written, before the long work starts. Leaves no
/// trace, so that nothing is there if the work fails or is killed.
/// @throws DataError if it cannot
void require_writable_folder(const std::filesystem::path& path);

/// A file or folder for results that no other limber of this computer may choose meanwhile: of two that work
/// at once the later one would be for nothing. The claim is a name of the system's, no file: it ends with the
/// process, however that ends. Processes of containers with a network of their own do not see it.
class ClaimedPlace {
 public:
  /// @throws DataError if another process holds it
  explicit ClaimedPlace(const std::filesystem::path& path);
  ~ClaimedPlace();
  ClaimedPlace(const ClaimedPlace&) = delete;
  ClaimedPlace& operator=(const ClaimedPlace&) = delete;

 private:
  int socket_ = -1;
};

/// The same of a folder that can be made and written.
class ClaimedFolder : public ClaimedPlace {
 public:
  /// @throws DataError as ClaimedPlace and require_writable_folder
  explicit ClaimedFolder(const std::filesystem::path& path);
};

}  // namespace limber::app

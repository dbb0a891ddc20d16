// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "byte_source.hpp"
#include "limber/bags/bag_file.hpp"

/// What rosbag2 compresses with zstd: whole files (mode FILE), or each message (mode MESSAGE).
namespace limber::detail {

/// Whether these are the first bytes of something that zstd has packed.
[[nodiscard]] bool is_packed(Bytes beginning);

/// The first bytes of a file that zstd has packed, unpacked; fewer where there are no more, or it is damaged.
[[nodiscard]] std::string unpacked_beginning(const std::filesystem::path& packed, std::size_t count);

using OpenBag = std::function<std::unique_ptr<BagFile>(const std::filesystem::path&)>;

/// @brief A bag that is packed as a whole. It is unpacked to a file in the folder for temporary files, which
/// goes when the bag goes; as far as that is possible, and `damages` says where it ended.
/// @param open  opens the unpacked file
/// @throws DataError if there is no room, or what was packed is no bag
[[nodiscard]] std::unique_ptr<BagFile> open_packed_bag(const std::filesystem::path& packed,
                                                       const OpenBag& open);

/// @brief The same bag with its messages unpacked, where they are packed: CDR never begins like zstd.
/// @param path  of the bag, for messages
[[nodiscard]] std::unique_ptr<BagFile> with_messages_unpacked(const std::filesystem::path& path,
                                                              std::unique_ptr<BagFile> bag);

}  // namespace limber::detail

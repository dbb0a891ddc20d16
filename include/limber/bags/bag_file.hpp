// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

/// Files of messages: ROS 1 bags (format 2.0), MCAP files and ROS 2 bags (sqlite3), without ROS.
namespace limber {

/// How the bytes of a message are to be read.
enum class Serialization { kRos1, kCdr, kOther };

/// A topic as the bag describes it.
struct BagTopic {
  std::string name;  ///< "/cam0/image_raw"
  std::string type;  ///< "sensor_msgs/Image": ROS 2's "/msg/" is left out
  /// how the bytes of its messages are to be read
  Serialization serialization = Serialization::kOther;
  std::string serialization_name;  ///< as the file has it
};

/// Where a message lies.
struct BagPlace {
  std::uint64_t at =
      0;  ///< byte in the file, of the message or of its compressed chunk; or row of a database
  std::uint64_t within = 0;       ///< byte in the chunk once it is decompressed; of a row that its table does
                                  ///< not lead to, byte in the file
  std::uint64_t size = 0;         ///< [bytes]
  std::uint32_t file = 0;         ///< of a bag of several files
  bool in_chunk = false;          ///< compressed
  std::uint64_t packed_size = 0;  ///< [bytes] of a message that is compressed by itself; 0: it is not
};

/// A message on the walk through a bag.
struct BagMessage {
  std::size_t topic = 0;  ///< index into topics()
  std::int64_t t_ns = 0;  ///< when it was recorded: bag time, not the stamp in its header
  /// where the whole message lies
  BagPlace place;
  std::span<const std::uint8_t> data;  ///< its beginning, as much as was wanted; valid during the call
};

/// @brief One bag. Nothing of it is kept in memory but its topics and a few decompressed chunks.
/// No index is needed: the messages themselves are walked through, so a bag that was never closed is read
/// like any other. What is damaged is left out, what lies behind it is read, and `damages` says what is
/// missing.
class BagFile {
 public:
  virtual ~BagFile() = default;

  /// How many bytes of each message of a topic the visitor wants; 0: none, and the message is only counted.
  using Wanted = std::function<std::size_t(const BagTopic&)>;
  /// Called for every message; what it throws ends the walk and passes through.
  using Visitor = std::function<void(const BagMessage&)>;

  /// @brief Visits all messages in the order of the file.
  /// @throws DataError (file, byte) if the file cannot be read at all; what a visitor throws passes through
  virtual void walk(const Wanted& wanted, const Visitor& visitor) = 0;

  /// The whole of a message that walk() visited. @throws DataError if the file has changed since
  [[nodiscard]] virtual std::vector<std::uint8_t> read(const BagPlace& place) = 0;

  /// Topics that walk() has met, in the order of their appearance.
  [[nodiscard]] virtual const std::vector<BagTopic>& topics() const = 0;
  /// What walk() could not read, in plain words with byte offsets and times; empty for a sound file.
  [[nodiscard]] virtual const std::vector<std::string>& damages() const = 0;
  /// Whether walk() has met all that was written into the file. One that was never closed may be whole.
  [[nodiscard]] virtual bool is_whole() const = 0;
  [[nodiscard]] virtual std::string format() const = 0;  ///< "ROS 1 bag", "MCAP", "ROS 2 bag (sqlite3)"
};

/// Whether open_bag() would know the file by its first bytes, or the folder by the bags in it.
[[nodiscard]] bool is_bag(const std::filesystem::path& path);

/// @brief Opens a bag; its content tells the format. A folder is a ROS 2 bag: the files that its
/// metadata.yaml lists, in this order, or without one all its .db3 and .mcap files (also .zstd), by name.
/// What is listed and missing counts as damage. A file that is packed by zstd is unpacked to a temporary one.
/// @throws DataError if it is none, or of a version or compression that is not read
[[nodiscard]] std::unique_ptr<BagFile> open_bag(const std::filesystem::path& path);

}  // namespace limber

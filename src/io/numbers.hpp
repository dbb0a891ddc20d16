// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// Text to numbers and checks on what came out; shared by all readers of this room.
namespace limber::detail {

/// The number that is the whole of `text`; may be inf or nan, which the caller judges.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

/// The integer that is the whole of `text` and fits into 64 bits.
[[nodiscard]] std::optional<std::int64_t> parse_integer(std::string_view text);

/// Decimal seconds, also as 1.5e-01, to integer nanoseconds, rounded to the nearest; never through double.
[[nodiscard]] std::optional<std::int64_t> parse_seconds_as_ns(std::string_view text);

/// Nanoseconds as seconds with nine decimals.
[[nodiscard]] std::string format_ns_as_seconds(std::int64_t t_ns);

/// Text from a file for an error message: quoted, at most 40 characters, control characters escaped.
[[nodiscard]] std::string excerpt(std::string_view text);

/// The rotation nearest to R; nothing if an entry of R^T R - I exceeds 1e-3 or R is a reflection.
[[nodiscard]] std::optional<Eigen::Matrix3d> checked_rotation(const Eigen::Matrix3d& R);

/// Rotation of the quaternion (w x y z); nothing if its norm is further than 1e-2 from 1.
[[nodiscard]] std::optional<Eigen::Matrix3d> checked_quaternion(const Eigen::Vector4d& wxyz);

/// Whether a number can be a focal length [px].
[[nodiscard]] bool is_focal_length(double f);
inline constexpr const char* kFocalLengthsInWords = "positive focal lengths fu, fv [px], 0.001 to 1000000";

/// Quaternion (w x y z) of R, w >= 0.
[[nodiscard]] Eigen::Vector4d quaternion_wxyz(const Eigen::Matrix3d& R);

}  // namespace limber::detail

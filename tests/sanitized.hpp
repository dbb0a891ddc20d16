// SPDX-License-Identifier: MIT
#pragma once

namespace limber::testing {

/// Whether this is a build under the address sanitizer: it keeps freed memory, and long statistics take
/// minutes.
#if defined(__SANITIZE_ADDRESS__)  // GCC
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)  // Clang
inline constexpr bool kSanitized = __has_feature(address_sanitizer);
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace limber::testing

// SPDX-License-Identifier: MIT
#include "limber/sensors/distortion.hpp"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>
#include <string>

namespace limber {
namespace {

TEST(Distortion, EveryModelHasANameOfItsOwnAndNamedCoefficients) {
  std::set<std::string> names;
  for (const Distortion& model : distortion_models()) {
    EXPECT_TRUE(names.emplace(model_name(model)).second) << model_name(model);
    EXPECT_EQ(coefficient_names(model).size(), coefficients(model).size());
  }
  EXPECT_EQ(names.size(), std::variant_size_v<Distortion>);
  EXPECT_EQ(model_name(Rational{}), "rational-polynomial");
  EXPECT_EQ(coefficient_names(Omni{}), (std::vector<std::string_view>{"xi", "k1", "k2", "p1", "p2"}));
}

TEST(Distortion, CoefficientsComeBackInTheOrderOfTheirNames) {
  for (const Distortion& model : distortion_models()) {
    std::vector<double> k = coefficients(model);
    for (std::size_t i = 0; i < k.size(); ++i) {
      k[i] = 0.1 * static_cast<double>(i + 1);
    }
    const Distortion other = with_coefficients(model, k);
    EXPECT_EQ(other.index(), model.index());
    EXPECT_EQ(coefficients(other), k);
    k.push_back(1.0);
    EXPECT_THROW(static_cast<void>(with_coefficients(model, k)), std::invalid_argument);
  }
  const auto rational = std::get<Rational>(
      with_coefficients(Rational{}, std::vector<double>{1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0}));
  EXPECT_EQ(rational.p1, 3.0) << "as OpenCV orders them";
  EXPECT_EQ(rational.k6, 8.0);
}

}  // namespace
}  // namespace limber

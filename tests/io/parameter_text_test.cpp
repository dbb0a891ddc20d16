// SPDX-License-Identifier: MIT
#include "limber/io/parameter_text.hpp"

#include <gmock/gmock.h>

#include <numbers>

#include "message_of.hpp"

namespace limber {
namespace {

using ::testing::HasSubstr;
using testing::message_of;

constexpr double kDegree = std::numbers::pi / 180.0;

StereoCalibration rig(double baseline) {
  StereoCalibration out;
  out.cam0 = {400.0, 410.0, 320.0, 240.0, 640, 480, NoDistortion{}};
  out.cam1 = {300.0, 310.0, 320.0, 240.0, 640, 480, NoDistortion{}};
  out.theta(3) = -baseline;
  return out;
}

TEST(ParseCalibrationError, ReadsDegreesAndMetres) {
  const ParameterVector error = parse_calibration_error("0.01,-0.05,90,0.1,-1e-2,5", rig(2.0));
  EXPECT_DOUBLE_EQ(error[0], 0.01 * kDegree);
  EXPECT_DOUBLE_EQ(error[1], -0.05 * kDegree);
  EXPECT_DOUBLE_EQ(error[2], std::numbers::pi / 2.0);
  EXPECT_EQ(error[3], 0.1);
  EXPECT_EQ(error[4], -0.01);
  EXPECT_EQ(error[5], 5.0);
  EXPECT_TRUE(error.tail<kMoreParameters>().isZero(0.0));
}

TEST(ParseCalibrationError, ReadsPercentOfTheBaselineAndOfTheFocalLength) {
  const ParameterVector error = parse_calibration_error("0,0,0,5%,-0.5%,0.25%,fu0=1%,fv1=-2%", rig(0.12));
  EXPECT_TRUE(error.head<3>().isZero(0.0));
  EXPECT_NEAR(error[3], 0.006, 1e-16);
  EXPECT_NEAR(error[4], -0.0006, 1e-16);
  EXPECT_NEAR(error[5], 0.0003, 1e-16);
  EXPECT_NEAR(error[6], 4.0, 1e-14);
  EXPECT_NEAR(error[13], -6.2, 1e-14);
}

TEST(ParseCalibrationError, ReadsNamesAlone) {
  const ParameterVector error = parse_calibration_error("dt1=0.005,imu-ay=1,tx=1%", rig(2.0));
  EXPECT_EQ(error[17], 0.005);
  EXPECT_DOUBLE_EQ(error[19], kDegree);
  EXPECT_DOUBLE_EQ(error[3], 0.02);
  EXPECT_EQ(parameters_of(error).count(), 3U);
}

TEST(ParseCalibrationError, RefusesEverythingElseAndSaysWhatItFound) {
  for (const std::string text : {"",
                                 ",",
                                 "1",
                                 "0,0,0,0,0",
                                 "0,0,0,0,0,0,0",
                                 "0,0,0,0,0,0,",
                                 ",0,0,0,0,0",
                                 "0,0,,0,0,0",
                                 "0,0,0,0,0,",
                                 "0;0;0;0;0;0",
                                 "0 0 0 0 0 0",
                                 "5%,0,0,0,0,0",
                                 "0,0,5%,0,0,0",
                                 "0,0,0,5%%,0,0",
                                 "0,0,0,%,0,0",
                                 "0,0,0,5 %,0,0",
                                 "0,0,0,5cm,0,0",
                                 "0,0,0,x,0,0",
                                 "nan,0,0,0,0,0",
                                 "0,0,0,inf,0,0",
                                 "0,0,0,-inf%,0,0",
                                 "0,0,0,1e999,0,0",
                                 "dt1",
                                 "dt1=",
                                 "dt1=1%",
                                 "cu0=1%",
                                 "imu-tx=1%",
                                 "dt2=0.1",
                                 "intrinsics1=1",
                                 "dt1=0.1,dt1=0.2",
                                 "0,0,0,0,0,0,ax=1",
                                 "dt1=0.1,0,0,0,0,0,0",
                                 "dt1=0.1,"}) {
    const std::string message = message_of([&] { (void)parse_calibration_error(text, rig(2.0)); });
    EXPECT_THAT(message, HasSubstr("expected six numbers ax,ay,az,tx,ty,tz")) << text;
    EXPECT_THAT(message, HasSubstr("'" + text + "'"));
  }
}

TEST(ParseParameterSigmas, TakesOnePlausibleErrorWhereNoneIsGiven) {
  const StereoCalibration calibration = rig(0.5);
  const ParameterVector plausible = plausible_errors(calibration);
  const ParameterVector sigma = parse_parameter_sigmas("dt0,intrinsics1,ax=0.2,tx=10%", calibration);
  EXPECT_EQ(sigma[11], plausible[11]);
  EXPECT_EQ(sigma.segment<5>(12), plausible.segment<5>(12));
  EXPECT_EQ(sigma[17], 0.0);  // a time offset is no intrinsic
  EXPECT_DOUBLE_EQ(sigma[0], 0.2 * kDegree);
  EXPECT_DOUBLE_EQ(sigma[3], 0.05);
  EXPECT_EQ(parameters_of(sigma).count(), 8U);
}

TEST(ParseParameterSigmas, TakesAnyCaseAndNamesWhatWasMeant) {
  EXPECT_EQ(parse_parameter_sigmas("DT0,Imu", rig(1.0)), parse_parameter_sigmas("dt0,imu", rig(1.0)));
  EXPECT_THAT(message_of([&] { (void)parse_parameter_sigmas("radial00=1", rig(1.0)); }),
              HasSubstr("unknown parameter 'radial00=1' in 'radial00=1' (did you mean radial0?)"));
  EXPECT_THAT(message_of([&] { (void)parse_calibration_error("imuax=1", rig(1.0)); }),
              HasSubstr("found 'imuax=1' (did you mean imu-ax?)"));
}

TEST(ParseParameterSigmas, RefusesEverythingElseAndSaysWhatItFound) {
  for (const std::string text : {"", ",", "dt0,", "full", "none", "k1", "dt0 ,dt1"}) {
    EXPECT_THAT(message_of([&] { (void)parse_parameter_sigmas(text, rig(1.0)); }),
                HasSubstr("unknown parameter"))
        << text;
  }
  for (const std::string text : {"dt0=0", "dt0=-1", "dt0=x", "dt0=", "dt0,dt0", "imu,imu-tx", "dt0=1%"}) {
    EXPECT_THAT(message_of([&] { (void)parse_parameter_sigmas(text, rig(1.0)); }),
                HasSubstr("expected NAME or NAME=SIGMA"))
        << text;
  }
}

TEST(FormatParameters, IsReadBackAsItWas) {
  const StereoCalibration calibration = rig(1.0);
  const std::string text = "ax=0.25,tx=-0.5,fu1=3,dt0=0.002,imu-tz=0.01";
  const ParameterVector error = parse_calibration_error(text, calibration);
  EXPECT_EQ(format_parameters(error), "ax=0.25,tx=-0.5,dt0=0.002,fu1=3,imu-tz=0.01");
  EXPECT_TRUE(parse_calibration_error(format_parameters(error), calibration).isApprox(error, 1e-15));
  EXPECT_EQ(format_parameters(ParameterVector::Zero()), "");
}

}  // namespace
}  // namespace limber

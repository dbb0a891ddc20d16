// SPDX-License-Identifier: MIT
#include "limber/datasets/replace_calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "message_of.hpp"
#include "rig_files/rigs.hpp"

namespace limber {
namespace {

using ::testing::HasSubstr;
using testing::message_of;
using testing::some_rig;

Recording recording_of(const StereoCalibration& calibration) {
  Recording out;
  out.calibration = calibration;
  return out;
}

RigFile file_of(const StereoCalibration& calibration, ImageKind images = ImageKind::kRaw) {
  RigFile out;
  out.calibration = calibration;
  out.images = images;
  return out;
}

TEST(ReplaceCalibration, TakesTheFileAndKeepsWhatItDoesNotSay) {
  Recording recording = recording_of(some_rig());
  RigFile rig = file_of(some_rig());
  rig.calibration.body = BodyFrame::kCam0;
  rig.calibration.T_body_cam0 = Pose{};
  rig.calibration.cam0.width = rig.calibration.cam0.height = 0;
  rig.calibration.cam1.fu = 400.0;
  replace_calibration(recording, rig, std::nullopt);
  EXPECT_EQ(recording.calibration.cam1.fu, 400.0);
  EXPECT_EQ(recording.calibration.cam0.width, 752);
  EXPECT_EQ(recording.calibration.T_body_cam0.p, some_rig().T_body_cam0.p);
  EXPECT_EQ(recording.calibration.body, BodyFrame::kImu);
  EXPECT_THAT(recording.notes, ::testing::Contains(HasSubstr("T_BS stays")));
}

TEST(ReplaceCalibration, KeepsTheReadoutTimeThatTheFileDoesNotSay) {
  StereoCalibration own = some_rig();
  own.readout_time_s = {0.02, 0.02};
  Recording recording = recording_of(own);
  replace_calibration(recording, file_of(some_rig()), std::nullopt);
  EXPECT_EQ(recording.calibration.readout_time_s, own.readout_time_s);
  StereoCalibration said = some_rig();
  said.readout_time_s = {0.01, 0.0};
  replace_calibration(recording, file_of(said), std::nullopt);
  EXPECT_EQ(recording.calibration.readout_time_s, said.readout_time_s);
}

TEST(ReplaceCalibration, ALeftCameraStaysTheBody) {
  StereoCalibration own = some_rig();
  own.body = BodyFrame::kCam0;
  own.T_body_cam0 = Pose{};
  Recording recording = recording_of(own);
  replace_calibration(recording, file_of(some_rig()), std::nullopt);
  EXPECT_EQ(recording.calibration.body, BodyFrame::kCam0);
  EXPECT_EQ(recording.calibration.T_body_cam0.p, Eigen::Vector3d::Zero());
}

TEST(ReplaceCalibration, RefusesAnotherSize) {
  Recording recording = recording_of(some_rig());
  RigFile rig = file_of(some_rig());
  rig.calibration.cam1.height = 400;
  EXPECT_THAT(message_of([&] { replace_calibration(recording, rig, std::nullopt); }), HasSubstr("752 x 400"));
}

TEST(ReplaceCalibration, RefusesRawForRectifiedAndTheReverseUnlessToldSo) {
  const StereoCalibration raw = some_rig(), rectified = some_rig(NoDistortion{});
  Recording recording = recording_of(rectified);
  EXPECT_THAT(message_of([&] { replace_calibration(recording, file_of(raw), std::nullopt); }),
              HasSubstr("--images raw"));
  EXPECT_NO_THROW(replace_calibration(recording, file_of(raw), ImageKind::kRaw));
  recording = recording_of(raw);
  EXPECT_THAT(message_of([&] {
                replace_calibration(recording, file_of(rectified, ImageKind::kRectified), std::nullopt);
              }),
              HasSubstr("--images rectified"));
  EXPECT_THAT(message_of([&] {
                replace_calibration(recording, file_of(rectified, ImageKind::kRectified), ImageKind::kRaw);
              }),
              HasSubstr("said were"));
}

TEST(ReplaceCalibration, ARawCameraMayHaveNoDistortion) {
  Recording recording = recording_of(some_rig(NoDistortion{}));
  EXPECT_NO_THROW(replace_calibration(recording, file_of(some_rig(NoDistortion{})), std::nullopt));
  EXPECT_NO_THROW(replace_calibration(recording, file_of(some_rig(NoDistortion{})), ImageKind::kRaw));
}

}  // namespace
}  // namespace limber

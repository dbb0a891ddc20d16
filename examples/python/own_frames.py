# SPDX-License-Identifier: MIT
"""Own data, frame by frame: a start from sensors, then a pose with its uncertainty after every frame.

Samples and matched points come from a simulation here; put your own source in its place.
"""
import limber

source = limber.simulate("drone_constant", seed=1)  # its right camera has moved; nobody tells the filter
imu, frames = source.imu, list(limber.frames(source))[:200]

options = limber.NavigatorOptions(method="lcekf", imu_noise=source.imu_noise, sigma_px=source.pixel_noise)
navigator, fed = limber.OnlineNavigator(source.calibration, options), 0
for frame in frames:
    while fed < len(imu) and imu["t_ns"][fed] <= frame.t_ns:  # inputs up to the frame, then the frame
        navigator.add_imu(imu["t_ns"][fed], imu["omega"][fed], imu["accel"][fed])
        fed += 1
    report = navigator.process(frame)
    if report.start and report.start.status != "waiting":
        print(f"started after {report.start.waited_s:.2f} s, tilt known to {report.start.tilt_sigma:.3f} rad")

state = navigator.estimate()
sigma = state.covariance.diagonal()[:3]**0.5
print(f"t = {state.t_ns * 1e-9:.2f} s: p = {state.p.round(3)} m, sigma {sigma.round(3)} m, {report.frame.used} points")
print(f"the rig: {navigator.health.verdict}, {navigator.health.axes}")
assert report.frame.status == "updated" and navigator.health.verdict == "decalibrated"

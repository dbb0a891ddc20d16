# SPDX-License-Identifier: MIT
"""Own data, frame by frame: a start from sensors, then a pose with its uncertainty after every frame.

Samples and matched points come from a simulation here; put your own source in its place.
"""
import limber

source = limber.simulate("drone_constant", seed=1)  # its right camera has moved; nobody tells the filter
imu, frames = source.imu, list(limber.frames(source))[:200]

options = limber.NavigatorOptions(method="lcekf", imu_noise=source.imu_noise, sigma_px=source.pixel_noise)
start = limber.SensorStart(source.calibration, options)
navigator, fed = None, 0
for frame in frames:
    receiver = navigator or start
    while fed < len(imu) and (fed == 0 or imu["t_ns"][fed - 1] < frame.t_ns):  # inputs up to the frame, then the frame
        receiver.add_imu(imu["t_ns"][fed], imu["omega"][fed], imu["accel"][fed])
        fed += 1
    if navigator is None:
        report = start.add_frame(frame)
        if report.status != "waiting":
            navigator = limber.Navigator(source.calibration, start.result(), options)
            fed = max(fed - 2, 0)  # the navigator wants the samples around its start, too
            print(f"started after {report.waited_s:.2f} s, tilt known to {report.tilt_sigma:.3f} rad")
        continue
    report = navigator.process(frame)

state = navigator.estimate()
sigma = state.covariance.diagonal()[:3]**0.5
print(f"t = {state.t_ns * 1e-9:.2f} s: p = {state.p.round(3)} m, sigma {sigma.round(3)} m, {report.used} points")
print(f"the rig: {report.health.verdict}, {report.health.axes}")
assert report.status == "updated" and report.health.verdict == "decalibrated"

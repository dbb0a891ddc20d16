# SPDX-License-Identifier: MIT
"""Diagnose and repair: python3 repair.py [RECORDING [ERROR]]; without a recording, a simulated rig that is bent.

ERROR makes the calibration wrong first, to see it mended: 0,2,0,20%,0,0 is 2 degrees of ay and a fifth of the baseline.
"""
import sys

import limber

recording = limber.read(sys.argv[1]) if len(sys.argv) > 1 else limber.simulate("drone_constant", seed=3)
if len(sys.argv) > 2:
    recording.assume_error(sys.argv[2])
print(limber.health(recording))
mended = limber.recalibrate(recording)
print(mended)
recording.calibration = mended.calibration
print(limber.health(recording).verdict, "with the corrected calibration")
print("ATE of ekf with it:", limber.run(recording, "ekf").summary["ate_se3_m"], "m")

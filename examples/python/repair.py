# SPDX-License-Identifier: MIT
"""Diagnose and repair: python3 repair.py [RECORDING [ERROR]]; without arguments, a simulated rig that is bent.

ERROR makes the calibration wrong first, to see it mended: 0,2,0,20%,0,0 is 2 degrees of ay and a fifth of the baseline.
"""
import sys

import limber

recording = limber.read(sys.argv[1]) if len(sys.argv) > 1 else limber.simulate("drone_none", seed=3)
error = sys.argv[2] if len(sys.argv) > 2 else "" if len(sys.argv) > 1 else "0,2,0,20%,0,0"
if error:
    recording.assume_error(error)
print(limber.health(recording))
mended = limber.recalibrate(recording)
print(mended)
recording.calibration = mended.calibration
print(limber.health(recording).verdict, "with the corrected calibration")
print("ATE of ekf with it:", limber.run(recording, "ekf").summary["ate_m"]["se3"], "m")

# SPDX-License-Identifier: MIT
"""A recording, whether it is an EuRoC or a KITTI folder."""
import euroc
import kitti


def stereo_stamps(recording):
    """Stamps [ns] of its stereo pairs, ascending."""
    return sorted(t_ns for t_ns, _, _ in kitti.stereo_pairs(recording)) if kitti.is_kitti(recording) else euroc.stereo_stamps(recording)


def stereo_pairs(recording):
    """[(t [ns], left image, right image)]"""
    return (kitti if kitti.is_kitti(recording) else euroc).stereo_pairs(recording)


def cameras(recording):
    """Both, as euroc.camera gives them."""
    read = (kitti if kitti.is_kitti(recording) else euroc).camera
    return [read(recording, name) for name in ("cam0", "cam1")]


def has_imu(recording):
    return (recording / "mav0/imu0/data.csv").exists()


def has_images(recording):
    """Not a track log, whose points are matched already."""
    return not (recording / "mav0/tracks0/data.csv").exists()

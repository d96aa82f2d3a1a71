#!/usr/bin/env bash
# Calibrate from return errors that were measured with a tape.
# Usage: bash 03_tape_measure.sh TABLE.csv SIDE VEHICLE.toml
set -euo pipefail
table=$1 side=$2 vehicle=$3

# First every step of the calculation, formula by formula, with the numbers of the UMBmark paper's equations.
omnimate umbmark "$table" --side "$side" --vehicle "$vehicle" --check | sed -n '1,10p'

# Then the result. A straight of 10.012 m by tape, for which odometry said 10.000 m, adds the mean diameter.
omnimate umbmark "$table" --side "$side" --vehicle "$vehicle" --tape 10.012 10.000 --out calibrated.toml | tail -9

# The result as parameters of the ROS 2 diff_drive_controller.
omnimate umbmark "$table" --side "$side" --vehicle "$vehicle" --export ros2
